// The object under the hands of a person: from the recording to the solver and back.

import {chooseLevel} from './budget.js';
import {ClipError} from './container.js';
import {report, showStatus} from './messages.js';
import {Hand} from './tools.js';
import {LiveMotion} from './live_motion.js';
import {Tint} from './tint.js';

const kQuiet = 10000;  // ms after a complaint about the solver
const kSlow = 0.9;  // of real time, below which slow motion is worth saying

/** Passes the object from the recording to the solver when someone takes hold of it. */
export class Physics {
  /** `recorded`: {level, source} of the baked motion; `bodies` of all levels, the finest first (see readBodies). */
  constructor({header, viewer, player, solver, bodies, recorded, object, legend}) {
    Object.assign(this, {header, viewer, player, solver, bodies, recorded, object});
    this.body = bodies.at(-1);
    this.live = new LiveMotion({
      solver, header, onAnswer: (answer) => this.#answered(answer), onSettings: () => this.onChange(),
      onBreak: (seconds) => showStatus(`The replay ends here: the last ${seconds.toFixed(1)} s of its recording are ` +
          'dropped, and what you do now is recorded instead.'),
      onFail: (error) => this.#failed(error),
    });
    this.hand = new Hand(this.live, header.solver.height);
    this.forces = new Map();  // of the last frame (N), by number
    this.tint = new Tint(viewer.renderer, legend);
    this.measured = this.measuring = false;
    this.times = [];  // ms of a frame of the levels that were measured, the finest first
    this.movable = movableOf(recorded.level, object.count);
    this.complained = -Infinity;  // when it was said that the solver had failed
    this.onChange = () => {};
    viewer.keepsCentres = true;
    viewer.touch();  // for centres of a clip that stands still
    viewer.onMove = (drivers) => this.#moved(drivers);
    viewer.onStep = () => this.hand.update(viewer.pageView());
    player.onUse = () => this.leave();
  }

  /** Finds the finest level that keeps real time, unless someone takes hold before. */
  async measure() {
    if (this.measured || this.measuring) return;
    this.measuring = true;
    try {
      const {live} = this, {session} = live, cancelled = () => live.running || live.session !== session;
      const {level, ms} = await chooseLevel(this.solver, this.header, this.bodies, cancelled);
      if (cancelled()) return;
      this.times = ms;
      this.measured = true;
      this.body = this.bodies[level];
      live.msPerFrame = ms[level];
    } finally {
      this.measuring = false;
    }
  }

  get running() {
    return this.live.running;
  }

  /** Share of real time at which the motion runs for want of speed; null where it keeps up. */
  get slowMotion() {
    if (!this.running || this.live.manual) return null;
    const {speed, measured, timeScale} = this.live, least = Math.min(speed, measured ?? speed);
    return least < kSlow * timeScale ? least : null;
  }

  /**
   * Hands the object over to the solver as it is shown, at a whole frame so that recordings can start there; one whose
   * material remembers what was done to it as it is in the first frame.  Returns whether that is not what was shown.
   */
  enter() {
    if (this.running) return false;
    const shown = Math.round(this.viewer.shown ?? this.player.frame);
    const frame = this.header.solver.remembers ? 0 : shown;
    this.#begin(frame, this.body, null);
    if (frame === shown) return false;
    showStatus('What is done to this material stays done, so you begin where the clip begins.');
    return true;
  }

  /** Goes back to the recording, at the frame where it was left. */
  leave() {
    if (!this.running) return;
    this.live.stop();
    showStatus('');
    this.#showRecorded();
    this.measure().catch(report);
  }

  /** Does again what was done since the last hand-over, at the same frames. */
  replay() {
    const {done} = this.live;
    if (done?.frames) this.#begin(done.startFrame, done.body, done);
  }

  #begin(frame, body, script) {
    this.player.pause();
    this.player.seek(frame);
    this.hand.drop();
    this.forces.clear();
    this.live.begin(body, frame, script);
    this.viewer.setSource(this.live, body.level);
    this.onChange();
  }

  /** Stiffness (factor), damping (s, 0 = none) and gravity (m/s^2 along up, added). */
  set(settings) {
    this.live.set(settings);
    this.viewer.touch();
  }

  /** Colours the object by a quantity (see Tint), or by its own colours where `kind` is null. */
  colourBy(kind) {
    this.tint.choose(kind);
    this.viewer.touch();
    this.viewer.dirty = true;
  }

  /** Place at rest of a Gaussian (scene units). */
  restOf(index) {
    return [...this.object.positions.subarray(4 * index, 4 * index + 3)];
  }

  #moved(drivers) {
    if (!this.tint.kind) return;
    const body = this.running ? this.live.body : this.bodies[this.recorded.level.index];
    const velocities = drivers.velocities ??
        (this.tint.kind === 'speed' ? body.velocitiesAt(this.player.frame, this.header.clip.fps) : null);
    this.tint.update({
      gradients: drivers.gradients, velocities, young: body.material.young, youngScale: this.live.settings.stiffness,
    });
  }

  #answered({forces, failed, refused = []}) {
    this.forces = new Map(forces.map(([number, ...force]) => [number, force]));
    if (!failed && refused.length) this.#complain('What you did last has no effect.', `(${refused[0][1]})`);
    if (!failed) return;
    this.hand.drop();
    this.#complain('The motion became too violent for the solver.',
        'It continues without your hand or added pins, with the original settings. ' +
            `(${failed.replace(/^simulate: /, '')})`);
  }

  #complain(message, advice) {
    this.onChange();
    const now = performance.now();
    if (now - this.complained < kQuiet) return;
    this.complained = now;
    report(new ClipError(message, advice));
  }

  /** The session is over already. */
  #failed(error) {
    this.#showRecorded();
    report(error);
  }

  #showRecorded() {
    this.hand.drop();
    this.forces.clear();
    if (this.live.recording) this.player.seek(this.live.recording.startFrame);
    this.viewer.setSource(this.recorded.source, this.recorded.level);
    this.onChange();
  }
}

/** Which Gaussians [N] follow drivers of a level. */
function movableOf({weight}, count) {
  return Uint8Array.from({length: count}, (_, i) => weight[2 * i] || weight[2 * i + 1] ? 1 : 0);
}
