// Drivers of a coarser level carried by those of level 0, as a Gaussian is carried by its drivers.

export const kNeighbours = 8;  // drivers that carry one, at most
const kTwistShare = 0.1;  // as in gaussians/render/deform_kernels.h
const kMostTurns = 60;

/**
 * The rotation closest to A [9] (rows): turns a quaternion step by step towards it (Müller et al. 2016); A may be
 * singular or inverted.
 */
export function closestRotation(A) {
  let q = [1, 0, 0, 0], R = [1, 0, 0, 0, 1, 0, 0, 0, 1];
  for (let turn = 0; turn < kMostTurns; ++turn) {
    const axis = [0, 0, 0];
    let along = 0;
    for (let j = 0; j < 3; ++j) {
      const r0 = R[j], r1 = R[3 + j], r2 = R[6 + j], a0 = A[j], a1 = A[3 + j], a2 = A[6 + j];
      axis[0] += r1 * a2 - r2 * a1;
      axis[1] += r2 * a0 - r0 * a2;
      axis[2] += r0 * a1 - r1 * a0;
      along += r0 * a0 + r1 * a1 + r2 * a2;
    }
    const size = Math.hypot(...axis), angle = size / (Math.abs(along) + 1e-9);
    if (angle < 1e-7) break;
    const s = Math.sin(angle / 2) / size, [w, x, y, z] = q;
    const c = Math.cos(angle / 2), [a, b, d] = axis.map((value) => s * value);
    q = [c * w - a * x - b * y - d * z, c * x + a * w + b * z - d * y, c * y - a * z + b * w + d * x,
         c * z + a * y - b * x + d * w];
    const length = Math.hypot(...q);
    const [W, X, Y, Z] = q = q.map((value) => value / length);
    R = [1 - 2 * (Y * Y + Z * Z), 2 * (X * Y - W * Z), 2 * (X * Z + W * Y),
         2 * (X * Y + W * Z), 1 - 2 * (X * X + Z * Z), 2 * (Y * Z - W * X),
         2 * (X * Z - W * Y), 2 * (Y * Z + W * X), 1 - 2 * (X * X + Y * Y)];
  }
  return R;
}

/** Carries drivers at rest [N, 3] by those of another level at rest [M, 3], all in scene units. */
export class Carrier {
  /**
   * `binding`: {driver, weight}, both [N, 8], the others that carry each one and their weights up to a factor; drivers
   * without weight are not used, and one that nothing carries stays at rest.
   */
  constructor(rest, from, {driver, weight}) {
    this.rest = rest;
    this.from = from;
    this.place = driver;
    this.weight = new Float32Array(weight.length);
    for (let first = 0; first < weight.length; first += kNeighbours) {
      let sum = 0;
      for (let k = 0; k < kNeighbours; ++k) sum += weight[first + k];
      for (let k = 0; k < kNeighbours && sum > 0; ++k) this.weight[first + k] = weight[first + k] / sum;
    }
  }

  /** The carried drivers, {positions [N, 3], gradients [N, 9]}, given the others. */
  carry({positions, gradients}) {
    const {rest, from, place, weight} = this, count = rest.length / 3;
    const out = {positions: new Float32Array(3 * count), gradients: new Float32Array(9 * count)};
    for (let i = 0; i < count; ++i) {
      const before = [0, 0, 0], after = [0, 0, 0], F = new Array(9).fill(0), H = new Array(9).fill(0);
      const first = kNeighbours * i;
      let last = first;
      while (last < first + kNeighbours && weight[last] > 0) ++last;
      if (last === first) {
        out.positions.set(rest.subarray(3 * i, 3 * i + 3), 3 * i);
        out.gradients.set([1, 0, 0, 0, 1, 0, 0, 0, 1], 9 * i);
        continue;
      }
      for (let k = first; k < last; ++k) {
        const m = place[k], w = weight[k];
        for (let c = 0; c < 3; ++c) {
          before[c] += w * from[3 * m + c];
          after[c] += w * positions[3 * m + c];
        }
        for (let c = 0; c < 9; ++c) F[c] += w * gradients[9 * m + c];
      }
      let spread = 0;
      for (let k = first; k < last; ++k) {
        const m = place[k], w = weight[k];
        for (let c = 0; c < 3; ++c) {
          const d = from[3 * m + c] - before[c];
          spread += w * d * d;
          for (let r = 0; r < 3; ++r) H[3 * r + c] += w * (positions[3 * m + r] - after[r]) * d;
        }
      }
      const R = closestRotation(spread > 0 ? H.map((value, c) => value / spread + kTwistShare * F[c]) : F);
      for (let r = 0; r < 3; ++r) {
        let sum = after[r];
        for (let c = 0; c < 3; ++c) sum += R[3 * r + c] * (rest[3 * i + c] - before[c]);
        out.positions[3 * i + r] = sum;
      }
      out.gradients.set(F, 9 * i);
    }
    return out;
  }
}
