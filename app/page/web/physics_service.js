// The physics for tests and tools: members of window.pliant.

import {interactionNumbers} from './solver_layout.js';

/**
 * Members that drive the solver by hand.  Lengths are in scene units.  After `begin`, `grab` or `advance` frames pass
 * on demand only, until a person takes hold.
 */
export function physicsService({physics, panel}) {
  const {live, bodies} = physics;
  const metres = bodies[0].metres;
  const scaled = (point) => point.map((value) => value * metres);
  const enter = () => {
    physics.enter();
    live.manual = true;
  };
  const begin = ({centre = null, radius = 0, ...description}) => {
    enter();
    return live.start(interactionNumbers({...description, centre: centre && scaled(centre), radius: radius * metres}));
  };
  return {
    /** Interaction as in interactionNumbers, lengths in scene units; its number. */
    begin,
    /** Takes hold of what lies within a radius of a place at rest (scene units). */
    grab: (restPoint, radius) => begin({type: 'grab', centre: restPoint, radius}),
    /** Moves the hand of a grab by so much since it took hold, or a finger to a place (scene units). */
    drag: (number, by) => live.move(number, 'drag', scaled(by)),
    move: (number, to) => live.move(number, 'move', scaled(to)),
    release: (number) => live.end(number),
    /** So many frames, exactly; resolves to the last one's substeps, ms and forces (N). */
    advance: async (frames) => {
      enter();
      let answer = null;
      for (let frame = 0; frame < frames; ++frame) answer = await live.step(1);
      if (!answer) return null;
      const {substeps, ms, forces, failed} = answer;
      return {substeps, ms, forces, failed};
    },
    /** {stiffness, damping (s), gravity (m/s^2 along up)}. */
    setSettings: (settings) => physics.set(settings),
    /** Positions [M, 3] of the drivers now (scene units); those of the recording where nobody takes hold. */
    drivers: () => Float32Array.from(physics.running ? live.now.positions : physics.viewer.drivers.positions),
    /** Takes a level in place of the one that was chosen, from the next time on that someone takes hold. */
    setLevel: (index) => {
      physics.body = bodies[index];
      physics.measured = true;
    },
    recording: () => live.done?.json ?? null,
    /** Starts again and does the same; in hand-driven mode by `advance`. */
    replay: () => physics.replay(),
    reset: panel.reset,
    live: () => physics.running,
  };
}

/** What `window.pliant.solver` says of the running level. */
export function solverState(physics) {
  return {
    levels: physics.bodies.map(({count, cellSize}) => ({drivers: count, cellSize})),
    /** Milliseconds of a frame of the levels that were measured. */
    get times() {
      return physics.times;
    },
    get level() {
      return (physics.running ? physics.live.body : physics.body).level.index;
    },
    get substeps() {
      return physics.live.substeps;
    },
    get msPerFrame() {
      return physics.live.msPerFrame;
    },
  };
}
