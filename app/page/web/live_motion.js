// The object as it moves now: a source of drivers (see BakedMotion) that the solver advances in real time.

import {Recording} from './recording.js';
import {kType} from './solver_layout.js';

const kLongestDebt = 0.25;      // s of motion that are asked of the solver at a time
const kShare = 0.85;            // of the time that the solver may take; the rest is the page's
const kSmooth = 0.1;            // weight of the last frame in the mean time of frames
const kWindow = 1;              // s over which the speed is measured
const kFewestPerSecond = 20;    // frames; where fewer come, those in between are interpolated
const kDefaults = {stiffness: 1, gravity: 0};
const kOfAHand = [kType.grab, kType.poke, kType.wind];  // they last as long as it holds

/** One session of the solver. */
export class LiveMotion {
  /**
   * `onAnswer(answer)` follows each frame, `onSettings()` a change of theirs in a replay, `onBreak(seconds)` a replay
   * that is broken off so long before its end, `onFail(error)` the end.
   */
  constructor({solver, header, onAnswer, onSettings, onBreak, onFail}) {
    Object.assign(this, {solver, onAnswer, onSettings, onBreak, onFail});
    this.held = header.solver.held ?? [];
    this.file = header.solver;
    this.defaults = {...kDefaults, damping: header.solver.damping_time};
    this.settings = {...this.defaults};
    this.gravity = header.solver.gravity;
    const size = Math.hypot(...header.up);
    this.up = header.up.map((value) => value / size);
    this.framesPerSecond = header.clip.fps;
    this.timeScale = 1;
    this.manual = false;  // frames are advanced on demand only
    this.msPerFrame = this.substeps = 0;
    this.session = 0;     // answers of earlier ones are dropped
  }

  /** Begins in the state of the recording at a frame; `script` is a recording to do again. */
  begin(body, frame, script = null) {
    const now = body.at(frame), v = body.velocitiesAt(frame, this.framesPerSecond);
    ++this.session;
    this.body = body;
    this.#guard(this.solver.load(body));
    const x = now.positions.map((value) => value * body.metres), F = now.gradients.slice();
    const memory = body.material.memory.slice();
    this.#guard(this.solver.request({start: {frame, x, v, F, memory, held: this.held}}, [x.buffer, F.buffer]));
    this.recording = new Recording(body, frame, this.file);
    this.script = script;
    if (script) this.settings = {...this.defaults};
    this.queue = [];
    this.acting = new Map(this.held.map((numbers, number) => [number, numbers]));
    this.next = this.held.length;
    this.level = body.level.index;
    this.before = this.now = {...now, velocities: v};
    this.received = this.shown = 0;  // frames
    this.under = this.debt = 0;      // frames asked for, and due
    this.measured = null;            // share of real time in the last window
    this.window = {seconds: 0, received: 0};
    this.changed = true;
    this.running = true;
    if (!script && Object.keys(this.defaults).some((name) => this.settings[name] !== this.defaults[name])) this.#set();
  }

  /** Back to rest: nothing more is asked of the solver. */
  stop() {
    ++this.session;
    this.running = false;
  }

  /** Begins an interaction (numbers of solver_layout.js) before the next frame; its number. */
  start(numbers) {
    this.interrupt();
    const number = this.next++;
    this.acting.set(number, numbers);
    this.queue.push(['begin', number, numbers]);
    return number;
  }

  /** Where a finger is, or by how much the hand of a grab has moved since it took hold (m), after the next frame. */
  move(number, name, [x, y, z]) {
    if (!this.acting.has(number)) return;
    const same = this.queue.findIndex((command) => command[0] === name && command[1] === number);
    if (same >= 0) this.queue.splice(same, 1);
    this.queue.push([name, number, x, y, z]);
  }

  /** Ends an interaction before the next frame. */
  end(number) {
    this.interrupt();
    if (this.acting.delete(number)) this.queue.push(['end', number]);
  }

  /** {stiffness (factor), damping (s, 0 = none), gravity (m/s^2 along up, added)}. */
  set(settings) {
    Object.assign(this.settings, settings);
    if (!this.running) return;
    this.interrupt();
    this.#set();
  }

  #set() {
    this.queue = this.queue.filter(([name]) => name !== 'set');
    this.queue.push(this.#command(this.settings));
  }

  #command({stiffness, damping, gravity}) {
    return ['set', stiffness, damping, ...this.gravity.map((value, c) => value + gravity * this.up[c])];
  }

  /** What was done: all of it while it is done again, until something else is done. */
  get done() {
    return this.script ?? this.recording;
  }

  /** Stops doing a recording again, because something else is done now; what follows in it is dropped. */
  interrupt() {
    if (!this.script) return;
    const rest = this.script.frames - this.recording.frames;
    this.script = null;
    if (rest > 0) this.onBreak(rest / this.body.fps);
    for (const number of this.acting.keys()) {
      if (number >= this.held.length) this.queue.push(['end', number]);
    }
    this.#drop();
  }

  /** Share of real time at which the motion runs, as far as the solver keeps up. */
  get speed() {
    const most = this.msPerFrame > 0 ? kShare * 1000 / (this.body.fps * this.msPerFrame) : Infinity;
    return Math.min(this.timeScale, most);
  }

  /** Lets wall time pass. */
  advance(seconds) {
    if (!this.running) return;
    const rate = this.speed * this.body.fps, most = Math.max(2, kLongestDebt * this.body.fps);
    this.#measure(seconds);
    if (!this.manual) {
      this.debt = Math.min(this.debt + seconds * rate, most);
      while (this.debt >= 1 && this.under < most) {
        this.step(1).catch(() => {});  // guarded
        --this.debt;
      }
    }
    const latest = this.received, least = latest - 1;
    const between = Math.min(Math.max(this.shown + seconds * rate, least), latest);
    const next = this.manual || rate >= kFewestPerSecond ? latest : between;
    this.changed ||= next !== this.shown;
    this.shown = next;
  }

  #measure(seconds) {
    const {window} = this;
    window.seconds += seconds;
    if (window.seconds < kWindow) return;
    this.measured = (this.received - window.received) / (window.seconds * this.body.fps);
    this.window = {seconds: 0, received: this.received};
  }

  /** Promise of the answer to what was queued and so many frames. */
  async step(frames) {
    const {session, recording} = this;
    if (this.script && recording.frames >= this.script.frames) this.#finish();
    if (this.script) this.#rehearse();
    const commands = this.queue;
    this.queue = [];
    if (!this.script) this.#endPushes(commands);
    const frame = recording.frames;
    recording.add(commands, frames);
    this.under += frames;
    const answer = await this.#guard(this.solver.request({step: {commands, frames}}));
    recording.take(answer, frame, this.#command(this.defaults));
    if (session === this.session) this.#take(answer, frames);
    return answer;
  }

  /** An impulse is over after its frame; the solver keeps a place for it until it is told. */
  #endPushes(commands) {
    for (const [name, number, numbers] of commands) {
      const push = name === 'begin' && numbers[0] === kType.impulse;
      if (push && this.acting.delete(number)) this.queue.push(['end', number]);
    }
  }

  #rehearse() {
    const commands = this.script.before(this.recording.frames);
    this.queue.unshift(...commands);
    for (const [name, number, numbers] of commands) {
      if (name === 'begin') this.acting.set(number, numbers);
      if (name === 'begin') this.next = Math.max(this.next, number + 1);
      if (name === 'end') this.acting.delete(number);
    }
    const set = commands.findLast(([name]) => name === 'set');
    if (!set) return;
    const [, stiffness, damping, ...gravity] = set;
    const added = gravity.reduce((sum, value, c) => sum + (value - this.gravity[c]) * this.up[c], 0);
    this.settings = {stiffness, damping, gravity: added};
    this.onSettings();
  }

  /** At the end of a replay no hand is there to let go; pins stay. */
  #finish() {
    this.script = null;
    for (const [number, [type]] of this.acting) {
      if (number >= this.held.length && kOfAHand.includes(type)) this.end(number);
    }
  }

  /** Forgets what was begun; what the file holds goes on. */
  #drop() {
    for (const number of [...this.acting.keys()]) {
      if (number >= this.held.length) this.acting.delete(number);
    }
  }

  #take(answer, frames) {
    this.under -= frames;
    this.received += frames;
    this.before = frames > 0 ? this.now : this.before;
    this.now = answer;
    this.changed = true;
    if (frames > 0) {
      this.substeps = answer.substeps;
      const {ms} = answer;
      this.msPerFrame = this.msPerFrame > 0 && ms < 3 * this.msPerFrame
          ? this.msPerFrame + kSmooth * (ms - this.msPerFrame) : ms;
    }
    for (const [number] of answer.refused ?? []) this.acting.delete(number);
    if (answer.failed) {
      this.queue = this.queue.filter(([name, number]) => name === 'end' && number < this.held.length);
      if (!this.script) {
        // The solver does not know yet that what was begun since then, and the settings sent since then, are over.
        const begun = [...this.acting.keys()].filter((number) => number >= this.held.length);
        this.queue.push(...begun.map((number) => ['end', number]), this.#command(this.defaults));
      }
      this.#drop();
      this.settings = {...this.defaults};
    }
    this.onAnswer(answer);
  }

  /** The session is over when this promise fails. */
  #guard(promise) {
    const {session} = this;
    promise.catch((error) => {
      this.solver.body = null;
      if (session !== this.session) return;
      this.stop();
      this.onFail(error);
    });
    return promise;
  }

  /** Drivers to draw now. */
  frameAt() {
    this.changed = false;
    const share = this.shown - (this.received - 1);
    if (share >= 1 || this.before === this.now) return this.now;
    const mix = (a, b) => a.map((value, i) => value + share * (b[i] - value));
    return {
      positions: mix(this.before.positions, this.now.positions),
      gradients: mix(this.before.gradients, this.now.gradients), velocities: this.now.velocities,
    };
  }
}
