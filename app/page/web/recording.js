// What a person did, frame by frame, and the files that say it.

import {kRegion, kType, readInteraction} from './solver_layout.js';

/** The commands (see createSolverHost) given to a session since it began, in SI units. */
export class Recording {
  /** `file`: what the header says of the solver. */
  constructor(body, startFrame, file) {
    this.body = body;
    this.startFrame = startFrame;
    this.file = file;
    this.held = file.held?.length ?? 0;  // numbers of the interactions of the file
    this.frames = 0;
    this.commands = [];      // [{frame, command, implied}], implied: what the solver does by itself where it fails
    this.holds = new Map();  // where a grab took hold (m), by number
  }

  /** Records commands given before the next frame, and that so many frames follow. */
  add(commands, frames) {
    for (const command of commands) this.commands.push({frame: this.frames, command});
    this.frames += frames;
  }

  /** Commands given before a frame. */
  before(frame) {
    return this.commands.filter((entry) => entry.frame === frame && !entry.implied).map(({command}) => command);
  }

  /** Takes in what the solver says of a frame; `settings` is the command by which it goes on where it has failed. */
  take({holds, failed}, frame, settings) {
    for (const [number, ...hold] of holds) this.holds.set(number, hold);
    if (!failed) return;
    const begun = this.commands.filter((entry) => entry.command[0] === 'begin' && entry.frame <= frame);
    const implied = [...begun.map(({command: [, number]}) => ['end', number]), settings];
    const later = this.commands.findIndex((entry) => entry.frame > frame);
    this.commands.splice(later < 0 ? this.commands.length : later, 0,
        ...implied.map((command) => ({frame, command, implied: true})));
  }

  /** Rows of what was begun, as in interactions.json: lengths in scene units, times in seconds since the begin. */
  get interactions() {
    return this.commands.filter((entry) => this.#acts(entry)).map((entry) => this.#row(entry));
  }

  /** An interactions.json by itself: what of the script of the run went on, and what was begun. */
  get forces() {
    const script = [];
    for (const {row, held} of this.file.script ?? []) {
      const end = this.#released(held);
      if (end === 0) continue;
      script.push(end === undefined || row.type === 'weight' ? row : {...row, duration: end / this.body.fps});
    }
    return [...script, ...this.interactions];
  }

  /** What was done and is not in `forces`, as a sentence; empty where they say all of it. */
  get unsaid() {
    const {damping_time: damping, gravity} = this.file, without = new Set();
    for (const {command: [name, ...values]} of this.commands) {
      if (name !== 'set') continue;
      const [stiffness, time, ...pull] = values;
      if (stiffness !== 1) without.add(`the stiffness ×${Number(stiffness.toPrecision(2))}`);
      if (time !== damping) without.add(time > 0 ? `the damping of ${Number(time.toPrecision(2))} s` : 'no damping');
      if (pull.some((value, c) => value !== gravity[c])) without.add('the changed gravity');
    }
    const script = new Map((this.file.script ?? []).map(({row, held}) => [held, row.type]));
    for (let held = 0; held < this.held; ++held) {
      const type = script.get(held), end = this.#released(held), said = type && (type !== 'weight' || end === 0);
      if (end !== undefined && !said) without.add('the release of what held the object');
    }
    if (this.startFrame > 0) without.add(`its beginning at frame ${this.startFrame}`);
    return without.size ? `The forces are saved without ${[...without].join(', ')}; the recording has all of it.` : '';
  }

  /** The recording as JSON. */
  get json() {
    const settings = this.commands.filter(({command: [name]}) => name === 'set').map(({frame, command}) => {
      const [, young, damping, ...gravity] = command;
      return {frame, young_scale: young, damping_time: damping, gravity};
    });
    const unpinned = this.commands.filter(({command: [name, number]}) => name === 'end' && number < this.held)
        .map(({frame, command: [, held]}) => ({frame, held}));
    return {
      format: 'pliant-recording', version: 1, drivers: this.body.count, clustered_to: this.body.clusteredTo,
      start_frame: this.startFrame, solver_fps: this.body.fps, frames: this.frames, object: this.file.object,
      simulated: this.file.simulated, held: this.held, settings, interactions: this.interactions, unpinned,
    };
  }

  /** Whether something begins that lasts a frame and, if it is a grab, has taken hold. */
  #acts({frame, command: [name, number, numbers]}) {
    return name === 'begin' && !(this.#end(number) <= frame) &&
        (numbers[0] !== kType.grab || this.holds.has(number));
  }

  /** The frame before which the hand let go of an interaction of the file. */
  #released(held) {
    return held === null ? undefined : this.#end(held);
  }

  /** The frame before which an interaction ends. */
  #end(number) {
    return this.commands.find(({command}) => command[0] === 'end' && command[1] === number)?.frame;
  }

  #row({frame, command: [, number, numbers]}) {
    const it = readInteraction(numbers), {fps} = this.body, scene = (values) => values.map((v) => v / this.body.metres);
    const end = this.#end(number);
    const region = it.region === kRegion.sphere ? {sphere: scene([...it.point, it.radius])} : 'all';
    const start = frame / fps, span = end === undefined ? {} : {duration: (end - frame) / fps};
    switch (it.type) {
      case 'grab': return {type: 'grab', region, path: this.#path(number, frame, end), start, ...span};
      case 'poke': {
        const path = this.#path(number, frame, end, it.point);
        return {type: 'poke', radius: scene([it.radius])[0], path, friction: it.friction, start, ...span};
      }
      case 'impulse': return {type: 'impulse', region, impulse: it.strength, start};
      case 'wind': return {
        type: 'wind', wind: it.strength, drag_coefficient: it.dragCoefficient, air_density: it.airDensity, start,
        ...span,
      };
      default: return {type: it.type, region, start, ...span};
    }
  }

  /** Way of a hand or finger from `first` (m) on: [[t, x, y, z]], one point per frame. */
  #path(number, begin, end = this.frames, first = this.holds.get(number)) {
    const targets = new Map();
    for (const {frame, command: [name, of, ...at]} of this.commands) {
      if (of !== number) continue;
      if (name === 'move') targets.set(frame, at);
      if (name === 'drag') targets.set(frame, at.map((value, c) => value + first[c]));
    }
    const row = (frame, at) => [(frame - begin) / this.body.fps, ...at.map((value) => value / this.body.metres)];
    const path = [row(begin, first)];
    let last = first;
    for (let frame = begin; frame < end; ++frame) path.push(row(frame + 1, last = targets.get(frame) ?? last));
    return path;
  }
}
