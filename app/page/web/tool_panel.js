// The buttons, sliders and keys of the physics.

import {showStatus} from './messages.js';
import {kColourings} from './tint.js';
import {kTools} from './tools.js';

const kGravity = 9.81;          // m/s^2
const kDampingLow = 0.05, kDampingHigh = 10;  // s
const kDampingSteps = 46;       // the step after them stands for no damping

const element = (id) => document.getElementById(id);
const rounded = (value) => String(Number(value.toPrecision(2)));

function dampingAt(step) {
  if (step > kDampingSteps) return 0;
  return kDampingLow * (kDampingHigh / kDampingLow) ** (step / kDampingSteps);
}

function stepOf(damping) {
  if (!(damping > 0)) return kDampingSteps + 1;
  const step = Math.round(kDampingSteps * Math.log(damping / kDampingLow) / Math.log(kDampingHigh / kDampingLow));
  return Math.min(Math.max(step, 0), kDampingSteps);
}

/** Saves a value as a JSON file. */
function save(value, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([`${JSON.stringify(value, null, 1)}\n`], {type: 'application/json'}));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** The factor of E at a softness of 0 (its high end) to 1; `band`: factors {low, typical, high} and the usual softness. */
function factorAt({low, typical, high}, softness) {
  const [from, to, share] = softness < 0.5 ? [high, typical, 2 * softness] : [typical, low, 2 * softness - 1];
  return from * (to / from) ** share;
}

function softnessAt({low, typical, high}, factor) {
  const share = (from, to) => Math.log(factor / from) / Math.log(to / from);
  const softness = factor > typical ? share(high, typical) / 2 : 0.5 + share(typical, low) / 2;
  return Math.min(Math.max(softness, 0), 1);
}

/** The stiffness as a factor, or where it was predicted as the softness within its band. */
function stiffnessSlider({live, header, set}) {
  const band = header.softness;
  if (!band) {
    return {
      apply: (value) => set({stiffness: value === 0 ? 1 : 10 ** value}), now: () => Math.log10(live.settings.stiffness),
      text: (value) => `×${rounded(10 ** value)}`,
    };
  }
  const slider = element('stiffness');
  slider.labels[0].firstElementChild.textContent = 'Softness';
  Object.assign(slider, {min: 0, max: 1, step: 0.01});
  return {
    apply: (value) => set({stiffness: value === band.value ? 1 : factorAt(band, value)}),
    now: () => softnessAt(band, live.settings.stiffness),
    text: (value) => `${rounded(value)} · E ×${rounded(live.settings.stiffness)}`,
  };
}

/** What each slider sets, and how its value reads. */
function slidersOf({live, hand, header, set}) {
  return {
    'wind-speed': {
      apply: (value) => hand.windSpeed = value, now: () => hand.windSpeed, text: (value) => `${value} m/s`,
    },
    'stiffness': stiffnessSlider({live, header, set}),
    'damping': {
      // The value of the file lies between two steps.
      apply: (step) => set({damping: step === stepOf(live.defaults.damping) ? live.defaults.damping : dampingAt(step)}),
      now: () => stepOf(live.settings.damping),
      text: () => live.settings.damping > 0 ? `${rounded(live.settings.damping)} s` : 'none',
    },
    'gravity': {
      apply: (value) => set({gravity: kGravity * value}), now: () => live.settings.gravity / kGravity,
      text: (value) => value ? `${rounded(Math.abs(value))} g ${value > 0 ? 'up' : 'down'}` : 'as captured',
    },
    'time-scale': {
      apply: (value) => live.timeScale = value, now: () => live.timeScale, text: (value) => `×${rounded(value)}`,
    },
  };
}

/** Connects the panel; the result has `refresh()` and the keys for connectControls, {keys, shifted}. */
export function connectPanel(physics, input) {
  const {live, hand} = physics, panel = element('physics'), colour = element('colour-by');
  const buttons = [...document.querySelectorAll('[data-tool]')], stage = element('stage');
  const sliders = slidersOf({live, hand, header: physics.header, set: (settings) => physics.set(settings)});

  const show = (open) => {
    panel.hidden = !open;
    element('show-physics').setAttribute('aria-expanded', open);
  };
  const useTool = (name) => {
    if (hand.held) input.release();
    hand.tool = name;
    for (const button of buttons) button.setAttribute('aria-pressed', button.dataset.tool === name);
    physics.viewer.dirty = true;
  };
  const refreshSliders = () => {
    for (const [id, {now, text}] of Object.entries(sliders)) {
      const slider = element(id);
      slider.value = now();
      element(`${id}-value`).textContent = text(Number(slider.value));
      slider.setAttribute('aria-valuetext', element(`${id}-value`).textContent);
    }
  };
  const colourBy = (kind) => {
    colour.value = kind;
    physics.colourBy(kind || null);
  };
  const reset = () => {
    physics.leave();
    physics.set(live.defaults);
    live.timeScale = 1;
    refreshSliders();
  };

  for (const [id, {apply}] of Object.entries(sliders)) {
    element(id).addEventListener('input', ({target}) => {
      apply(Number(target.value));
      refreshSliders();
    });
  }
  for (const button of buttons) button.addEventListener('click', () => useTool(button.dataset.tool));
  element('hand-size').addEventListener('change', ({target}) => hand.size = Number(target.value));
  colour.addEventListener('change', () => colourBy(colour.value));
  const actions = {
    'show-physics': () => show(panel.hidden), 'hide-physics': () => show(false), 'reset': reset,
    'replay': () => physics.replay(),
    'save-recording': () => save(live.done.json, 'recording.json'),
    'save-interactions': () => {
      save(live.done.forces, 'interactions.json');
      showStatus(live.done.unsaid);
    },
  };
  for (const [id, action] of Object.entries(actions)) element(id).addEventListener('click', action);
  physics.onChange = refreshSliders;
  refreshSliders();
  element('tools').hidden = element('physics-help').hidden = false;
  element('canvas').classList.add('touchable');

  const nextColouring = () => {
    const all = ['', ...kColourings];
    colourBy(all[(all.indexOf(colour.value) + 1) % all.length]);
  };
  return {
    reset,
    refresh: () => {
      const {running, slowMotion} = physics, {done, received, body} = live;
      for (const id of ['replay', 'save-recording', 'save-interactions']) element(id).disabled = !done?.frames;
      stage.classList.toggle('live', running);
      document.body.classList.toggle('away', running);
      element('live').hidden = !running;
      if (!running) return;
      const slow = slowMotion ? ` · slow motion ×${rounded(slowMotion)}` : '';
      const again = live.script ? ' · replay' : '';
      element('live-text').textContent = `${(received / body.fps).toFixed(1)} s${again}${slow}`;
    },
    keys: {
      ...Object.fromEntries(kTools.map((name, k) => [String(k + 1), () => useTool(name)])),
      'g': () => input.toggle(), 'r': reset, 't': actions['show-physics'], 'v': nextColouring,
    },
    shifted: {'r': actions.replay},
  };
}
