// The numbers by which page and solver speak of interactions and bodies, in SI units and world axes.  The order is that
// of app/page/interaction_numbers.h and of solver_body in app/page/solver/solver.cpp.

/** Types of interactions. */
export const kType = {
  gravity: 0, pin: 1, pointForce: 2, impulse: 3, grab: 4, gust: 5, ground: 6, collider: 7, poke: 8, torque: 9, wind: 10,
  weight: 11,
};

/** Kinds of regions; they select driving particles by their places at rest. */
export const kRegion = {all: 0, sphere: 1, box: 2, halfSpace: 3, cylinder: 4};

/** Numbers of an interaction. */
export const kInteractionNumbers = 22;

const kAt = {
  type: 0, duration: 1, region: 2, point: 3, vector: 6, radius: 9, strength: 10, friction: 13, rate: 14,
  dragCoefficient: 15, airDensity: 16, stiffness: 17, damping: 18, maxForce: 19, contact: 20, mass: 21,
};
const kSeparating = 2;

/**
 * Numbers of an interaction that begins now and lasts until it is ended: `type` by name, a sphere (centre [3] and
 * radius, m) or everything, and a vector (`strength`: N, N s or m/s).
 */
export function interactionNumbers({type, centre = null, radius = 0, strength = [0, 0, 0], friction = 0}) {
  const numbers = new Array(kInteractionNumbers).fill(0);
  const put = (at, values) => values.forEach((value, c) => numbers[at + c] = value);
  numbers[kAt.type] = kType[type];
  numbers[kAt.region] = centre ? kRegion.sphere : kRegion.all;
  put(kAt.point, centre ?? [0, 0, 0]);
  numbers[kAt.radius] = radius;
  put(kAt.strength, strength);
  numbers[kAt.friction] = friction;
  numbers[kAt.dragCoefficient] = 1;
  numbers[kAt.airDensity] = 1.2;
  numbers[kAt.contact] = kSeparating;
  return numbers;
}

/** What the numbers of an interaction say, the other way round. */
export function readInteraction(numbers) {
  const vector = (at) => numbers.slice(at, at + 3);
  return {
    type: Object.keys(kType).find((name) => kType[name] === numbers[kAt.type]),
    region: numbers[kAt.region], point: vector(kAt.point), vector: vector(kAt.vector), radius: numbers[kAt.radius],
    strength: vector(kAt.strength), friction: numbers[kAt.friction],
    dragCoefficient: numbers[kAt.dragCoefficient], airDensity: numbers[kAt.airDensity],
  };
}

/** Whether the region of an interaction (see readInteraction) contains a place at rest, both in metres. */
export function regionContains({region, point, vector, radius}, [x, y, z]) {
  const d = [x - point[0], y - point[1], z - point[2]];
  switch (region) {
    case kRegion.sphere: return Math.hypot(...d) <= radius;
    case kRegion.box: return [x, y, z].every((value, c) => value >= point[c] && value <= vector[c]);
    case kRegion.halfSpace: return d[0] * vector[0] + d[1] * vector[1] + d[2] * vector[2] <= 0;
    case kRegion.cylinder: {
      const axis = vector.map((value, c) => value - point[c]), length = Math.hypot(...axis);
      const along = (d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]) / length;
      return along >= 0 && along <= length && Math.hypot(...d) ** 2 - along ** 2 <= radius ** 2;
    }
    default: return true;
  }
}

/** Numbers of a body for solver_body: `solver` of the header, and the size of a cell (m). */
export function bodyNumbers(solver, cellSize) {
  const {fps, damping_time: damping, gravity, contact_friction: friction} = solver;
  const {grid, flip_time: flip, sleep_speed: sleep} = solver;
  return [cellSize, fps, damping, ...gravity, 0, friction ?? 0, grid ?? 0, flip ?? 0, sleep ?? 0];
}
