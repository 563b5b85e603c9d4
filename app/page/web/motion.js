// What moves the object: driving particles at rest, the Gaussians they carry, and the baked motion of the clip.

import {ClipError} from './container.js';
import {kWidth} from './cloud.js';

const kDriversPerGaussian = 8;
const kUnused = 65535;

/**
 * Level `index` of drivers: {index, count, rest [M, 3] scene units, driver, weight}, the last two laid out for
 * textures: eight 16-bit indices and eight 8-bit weights per Gaussian.  Gaussians that do not move have no weight.
 */
export function readLevel(container, index, {drivers: count}, splats, rows) {
  const name = `level${index}`;
  const rest = container.array(`${name}.rest`, [count, 3]).values.slice();
  const stored = container.array(`${name}.driver`, [splats, kDriversPerGaussian]).values;
  const weights = container.array(`${name}.weight`, [splats, kDriversPerGaussian]).values;
  const bound = container.has('object.bound') ? container.array('object.bound', [splats]).values : null;
  const driver = new Uint16Array(kDriversPerGaussian * rows * kWidth);
  const weight = new Uint8Array(kDriversPerGaussian * rows * kWidth);
  for (let i = 0; i < splats; ++i) {
    if (bound && !bound[i]) continue;
    for (let k = kDriversPerGaussian * i; k < kDriversPerGaussian * (i + 1); ++k) {
      if (stored[k] === kUnused) continue;
      if (stored[k] >= count) throw new ClipError(`The data in this file are inconsistent (${name}.driver).`);
      driver[k] = stored[k];
      weight[k] = weights[k];
    }
  }
  return {index, count, rest, driver: new Uint32Array(driver.buffer), weight: new Uint32Array(weight.buffer)};
}

/** A level without drivers: nothing moves. */
export function emptyLevel(rows) {
  const texels = rows * kWidth;
  return {
    index: 0, count: 0, rest: new Float32Array(0),
    driver: new Uint32Array(4 * texels), weight: new Uint32Array(2 * texels),
  };
}

/** Integers [frames, lanes] from residuals of a linear prediction: q[t] = r[t] + 2 q[t-1] - q[t-2]. */
function integrate(low, high, frames, lanes) {
  let out = new Int16Array(frames * lanes);
  let last = new Int32Array(lanes), beforeLast = new Int32Array(lanes);
  for (let t = 0; t < frames; ++t) {
    const base = t * lanes;
    let most = 0;
    for (let i = 0; i < lanes; ++i) {
      const q = (high[base + i] << 24 >> 16 | low[base + i]) + 2 * last[i] - beforeLast[i] | 0;
      beforeLast[i] = q;
      most = Math.max(most, q < 0 ? ~q : q);
    }
    [last, beforeLast] = [beforeLast, last];
    if (most > 32767 && out instanceof Int16Array) out = Int32Array.from(out);
    out.set(last, base);
  }
  return out;
}

/**
 * The motion of level 0 as it was simulated: a source of drivers.  A source has `level` (the index of its drivers) and
 * `frameAt(frame)`.
 */
export class BakedMotion {
  constructor(container, header, level) {
    const {frames} = header.clip, drivers = level.count, steps = header.motion;
    if (!(steps?.position_step >= 0) || !(steps?.gradient_step >= 0)) {
      throw new ClipError('The header of this file is damaged (motion).');
    }
    const decode = (name, components) => {
      const shape = [frames, components, drivers];
      return integrate(container.array(`motion.${name}_low`, shape).values,
          container.array(`motion.${name}_high`, shape).values, frames, components * drivers);
    };
    this.level = level.index;
    this.frames = frames;
    this.drivers = drivers;
    this.rest = level.rest;
    this.steps = steps;
    this.position = decode('position', 3);
    this.gradient = decode('gradient', 9);
    this.out = this.arrays();
  }

  /** Arrays for the drivers of a frame. */
  arrays() {
    return {positions: new Float32Array(3 * this.drivers), gradients: new Float32Array(9 * this.drivers)};
  }

  /**
   * Drivers at a frame, in between by linear interpolation: {positions [M, 3], gradients [M, 9] row-major}; in `out`
   * (see arrays), else in arrays that the next call without it fills again.
   */
  frameAt(frame, out = this.out) {
    const at = Math.min(Math.max(frame, 0), this.frames - 1);
    const first = Math.floor(at), share = at - first, drivers = this.drivers;
    const {positions, gradients} = out;
    const fill = (values, stored, components, step) => {
      for (let c = 0; c < components; ++c) {
        const lane = (first * components + c) * drivers;
        const next = share > 0 ? lane + components * drivers : lane;
        for (let m = 0; m < drivers; ++m) {
          values[components * m + c] = step * (stored[lane + m] + share * (stored[next + m] - stored[lane + m]));
        }
      }
    };
    fill(positions, this.position, 3, this.steps.position_step);
    fill(gradients, this.gradient, 9, this.steps.gradient_step);
    for (let i = 0; i < positions.length; ++i) positions[i] += this.rest[i];
    for (let i = 0; i < gradients.length; i += 9) {
      ++gradients[i];
      ++gradients[i + 4];
      ++gradients[i + 8];
    }
    return out;
  }
}

/** A source that keeps the drivers at rest, for a clip without its motion. */
export class Still {
  constructor(level) {
    this.level = level.index;
    this.frames = 1;
    const gradients = new Float32Array(9 * level.count);
    for (let i = 0; i < gradients.length; i += 9) gradients[i] = gradients[i + 4] = gradients[i + 8] = 1;
    this.out = {positions: level.rest, gradients};
  }

  frameAt() {
    return this.out;
  }
}
