// How fine the drivers may be so that the solver keeps real time on this device.

const kWarmUp = 10, kTimed = 20;  // frames
const kShare = 0.7;               // of the time of a frame that the solver may take
const kHopeless = 4;              // times that share, after which a level is not measured further
const kGlance = 3;                // frames after which that is decided

/** Times some frames (ms) from the start of the recording; null when cancelled. */
async function measure(solver, body, held, framesPerSecond, cancelled, budget) {
  const {positions, gradients: F} = body.at(0), x = positions.map((value) => value * body.metres);
  const {memory} = body.material, v = body.velocitiesAt(0, framesPerSecond);
  solver.load(body).catch(() => {});  // the next request fails as well
  await solver.request({start: {frame: 0, x, v, F, memory, held}});
  let total = 0, frames = 0;
  for (let frame = 0; frame < kWarmUp + kTimed; ++frame) {
    if (cancelled()) return null;
    const {ms, failed} = await solver.request({step: {commands: [], frames: 1}});
    if (failed) return Infinity;
    if (frame + 1 >= kGlance && ms > kHopeless * budget) return ms;
    if (frame < kWarmUp) continue;
    total += ms;
    ++frames;
  }
  return total / frames;
}

/**
 * Finds the finest of the bodies that keeps real time, else the coarsest: {level, ms [levels tried]}.  `cancelled()`
 * stops the search; the coarsest level not tried is taken then.
 */
export async function chooseLevel(solver, header, bodies, cancelled) {
  const {fps, held = []} = header.solver, budget = kShare * 1000 / fps, ms = [];
  for (const [level, body] of bodies.entries()) {
    if (cancelled()) break;
    const time = await measure(solver, body, held, header.clip.fps, cancelled, budget);
    if (time === null) return {level: bodies.length - 1, ms};
    ms.push(time);
    if (time < budget) return {level, ms};
  }
  return {level: bodies.length - 1, ms};
}
