// The toolbar and the keys.

const kSpeeds = [0.1, 0.25, 0.5, 1];
const kRepeated = /^(arrow|page)|^[wasd+=_-]$/;  // keys that act again while they are held down
const kTurn = Math.PI / 36, kPan = 0.05, kZoom = 1.15;  // of one key press

const element = (id) => document.getElementById(id);

function toggleHelp() {
  const help = element('help');
  if (help.open) help.close();
  else help.showModal();
}

/**
 * Connects toolbar and keys with the player and the camera: {refresh, add}.  `refresh` updates what they show; `add`
 * takes the keys of another part, {keys, shifted}, and `first(event)`, which is true for keys that it has used.
 */
export function connectControls(player, camera) {
  const scrub = element('scrub'), time = element('time'), playButton = element('play'), speed = element('speed');
  const loopButton = element('loop'), help = element('help');

  const refresh = () => {
    const frame = player.frame, seconds = (value) => (value / player.fps).toFixed(2);
    scrub.value = frame;
    scrub.style.setProperty('--played', `${100 * frame / Math.max(1, player.frames - 1)}%`);
    scrub.setAttribute('aria-valuetext',
        `${seconds(frame)} seconds, frame ${Math.floor(frame) + 1} of ${player.frames}`);
    time.textContent = `${seconds(frame)} / ${seconds(player.frames - 1)} s`;
    playButton.dataset.state = player.playing ? 'playing' : 'paused';
    playButton.setAttribute('aria-label', player.playing ? 'Pause' : 'Play');
    playButton.title = player.playing ? 'Pause (Space)' : 'Play (Space)';
    loopButton.setAttribute('aria-pressed', player.loop);
    speed.value = player.speed;
  };
  const toggle = () => {
    if (player.playing) player.pause();
    else player.play();
  };
  const changeSpeed = (by) => {
    const at = kSpeeds.indexOf(player.speed) + by;
    player.speed = kSpeeds[Math.min(Math.max(at, 0), kSpeeds.length - 1)];
  };

  scrub.max = player.frames - 1;
  for (const control of document.querySelectorAll('#controls [disabled]')) control.disabled = false;
  scrub.disabled = playButton.disabled = player.frames < 2;
  scrub.addEventListener('input', () => {
    player.jump(Number(scrub.value));
    refresh();
  });
  speed.addEventListener('change', () => player.speed = Number(speed.value));
  const actions = {
    'play': toggle,
    'loop': () => player.loop = !player.loop,
    'clip-camera': () => camera.reset(),
    'fit': () => camera.fit(),
  };
  for (const [id, action] of Object.entries(actions)) {
    element(id).addEventListener('click', () => {
      action();
      refresh();
    });
  }

  const keys = {
    ' ': toggle, 'k': toggle,
    'arrowleft': () => player.step(-1), 'arrowright': () => player.step(1),
    'home': () => player.jump(0), 'end': () => player.jump(player.frames - 1),
    '[': () => changeSpeed(-1), ']': () => changeSpeed(1),
    'l': actions.loop, 'c': actions['clip-camera'], 'f': actions.fit, 'h': toggleHelp, '?': toggleHelp,
    'a': () => camera.turn(-kTurn, 0), 'd': () => camera.turn(kTurn, 0),
    'w': () => camera.turn(0, kTurn), 's': () => camera.turn(0, -kTurn),
    '+': () => camera.zoom(1 / kZoom), '=': () => camera.zoom(1 / kZoom), '-': () => camera.zoom(kZoom),
    '_': () => camera.zoom(kZoom),
  };
  const shifted = {
    'arrowleft': keys.a, 'arrowright': keys.d, 'arrowup': keys.w, 'arrowdown': keys.s,
    'a': () => camera.pan(-kPan, 0), 'd': () => camera.pan(kPan, 0),
    'w': () => camera.pan(0, -kPan), 's': () => camera.pan(0, kPan),
  };
  let first = () => false;
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.toLowerCase(), target = event.target;
    if (help.open && !['h', '?'].includes(key)) return;
    if (key === ' ' && target.closest('button, select, summary')) return;
    if (target.closest('select, video')) return;
    if (first(event)) {
      event.preventDefault();
      return;
    }
    if (target.matches('input') && !event.shiftKey && /^(arrow|home|end|page)/.test(key)) return;
    const action = event.shiftKey && shifted[key] || keys[key];
    if (!action) return;
    event.preventDefault();
    if (event.repeat && !kRepeated.test(key)) return;
    action();
    refresh();
  });
  refresh();
  const add = (more) => {
    Object.assign(keys, more.keys);
    Object.assign(shifted, more.shifted);
    first = more.first;
  };
  return {refresh, add};
}

/** Adds a line about the clip. */
export function addDetail(name, text) {
  const term = document.createElement('dt'), value = document.createElement('dd');
  term.textContent = name;
  value.textContent = text;
  if (name === 'Command') {
    value.className = 'code';
    value.replaceChildren(...text.split(/(?<= )/).map((word) => {  // lines break between arguments only
      const span = document.createElement('span');
      span.textContent = word;
      return span;
    }));
  }
  element('details').append(term, value);
}

/** Fills in the title and the lines about the clip, and connects the help overlay, which has them all. */
export function showAbout({title, about = {}}) {
  document.title = element('title').textContent = title || 'Pliant clip';
  const lines = Object.entries({
    'Made with': about.pliant && `Pliant ${about.pliant}`, 'Source': about.source, 'License': about.licence, 'Material': about.material,
    'To save space': about.given_up, 'Command': about.command,
  }).filter(([, text]) => text);
  const shortly = {'Made with': 'Made with ', 'Source': 'Source: ', 'License': 'License: '};
  element('about').textContent =
      lines.filter(([name]) => name in shortly).map(([name, text]) => shortly[name] + text).join(' · ');
  for (const [name, text] of lines) addDetail(name, text);
  for (const id of ['show-help', 'about']) element(id).addEventListener('click', toggleHelp);
  element('help').addEventListener('click', ({target}) => target === element('help') && toggleHelp());  // outside
}
