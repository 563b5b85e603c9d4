// Drivers of a coarser level carried by those of level 0, as a Gaussian is carried by its drivers.

const kNeighbours = 8;
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

/** For each of the points [N, 3] its nearest ones among `from` [M, 3] and weights that fade out with distance. */
function neighbours(points, from) {
  const count = from.length / 3, order = Uint32Array.from({length: count}, (_, m) => m);
  order.sort((a, b) => from[3 * a] - from[3 * b]);
  const wanted = Math.min(kNeighbours + 1, count);  // the last one sets the reach
  const place = new Uint32Array(points.length / 3 * kNeighbours), weight = new Float32Array(place.length);
  for (let i = 0; 3 * i < points.length; ++i) {
    const [x, y, z] = points.subarray(3 * i, 3 * i + 3), found = [];
    let low = 0, high = count;
    while (low < high) {
      const middle = low + high >> 1;
      if (from[3 * order[middle]] < x) low = middle + 1;
      else high = middle;
    }
    const gap = (k) => k < 0 || k >= count ? Infinity : Math.abs(from[3 * order[k]] - x);
    for (let left = low - 1, right = low;;) {
      const k = gap(left) < gap(right) ? left-- : right++;
      if (!(gap(k) < Infinity) || found.length === wanted && gap(k) > found[wanted - 1].distance) break;
      const m = order[k], distance = Math.hypot(from[3 * m] - x, from[3 * m + 1] - y, from[3 * m + 2] - z);
      if (found.length === wanted && distance >= found[wanted - 1].distance) continue;
      let at = Math.min(found.length, wanted - 1);
      while (at > 0 && found[at - 1].distance > distance) found[at] = found[--at];
      found[at] = {m, distance};
    }
    const reach = Math.max(found.at(-1).distance, 1e-9), used = found.slice(0, Math.max(1, wanted - 1));
    const weights = used.map(({distance}) => (1 - (distance / reach) ** 2) ** 2 + 1e-6);
    const sum = weights.reduce((a, b) => a + b);
    used.forEach(({m}, k) => {
      place[kNeighbours * i + k] = m;
      weight[kNeighbours * i + k] = weights[k] / sum;
    });
  }
  return {place, weight};
}

/** Carries drivers at rest [N, 3] by those of another level at rest [M, 3], all in scene units. */
export class Carrier {
  constructor(rest, from) {
    this.rest = rest;
    this.from = from;
    Object.assign(this, neighbours(rest, from));
  }

  /** The carried drivers, {positions [N, 3], gradients [N, 9]}, given the others. */
  carry({positions, gradients}) {
    const {rest, from, place, weight} = this, count = rest.length / 3;
    const out = {positions: new Float32Array(3 * count), gradients: new Float32Array(9 * count)};
    for (let i = 0; i < count; ++i) {
      const before = [0, 0, 0], after = [0, 0, 0], F = new Array(9).fill(0), H = new Array(9).fill(0);
      const first = kNeighbours * i, last = first + kNeighbours;
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
