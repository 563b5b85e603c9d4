// Gaussians, laid out for textures that are kWidth texels wide, one texel per Gaussian.

import {ClipError} from './container.js';

/** Width of all textures of Gaussians (texels). */
export const kWidth = 2048;
const kChunk = 256;  // Gaussians that share a box of positions

function fillPositions(container, name, count, out) {
  const chunks = Math.ceil(count / kChunk);
  const {values} = container.array(`${name}.position`, [count, 3]);
  const low = container.array(`${name}.chunk_low`, [chunks, 3]).values;
  const size = container.array(`${name}.chunk_size`, [chunks, 3]).values;
  for (let i = 0; i < count; ++i) {
    const chunk = 3 * Math.floor(i / kChunk);
    for (let c = 0; c < 3; ++c) out[4 * i + c] = low[chunk + c] + values[3 * i + c] / 65535 * size[chunk + c];
  }
}

function fillOpacities(container, name, count, out) {
  const {values, low, span, steps} = container.array(`${name}.opacity`, [count]);
  for (let i = 0; i < count; ++i) out[4 * i + 3] = low + values[i] / steps * span;
}

/** Writes the unit quaternion (w, x, y, z) packed as its three smallest components. */
function unpackQuaternion(bits, out) {
  const largest = bits >>> 30;
  let rest = 1, shift = 0;
  for (let k = 0; k < 4; ++k) {
    if (k === largest) continue;
    out[k] = ((bits >>> shift & 1023) / 1022 * 2 - 1) * Math.SQRT1_2;
    rest -= out[k] * out[k];
    shift += 10;
  }
  out[largest] = Math.sqrt(Math.max(0, rest));
  const length = Math.hypot(out[0], out[1], out[2], out[3]);
  for (let k = 0; k < 4; ++k) out[k] /= length;
}

/** Covariances R diag(scale)^2 R^T as (xx, xy, xz, yy) and (yz, zz, -, -). */
function fillCovariances(container, name, count, outA, outB) {
  const scales = container.array(`${name}.log_scale`, [count, 3]);
  const rotations = container.array(`${name}.rotation`, [count]).values;
  const q = new Float64Array(4), variance = new Float64Array(3);
  for (let i = 0; i < count; ++i) {
    for (let c = 0; c < 3; ++c) {
      variance[c] = Math.exp(2 * (scales.low + scales.values[3 * i + c] / scales.steps * scales.span));
    }
    unpackQuaternion(rotations[i], q);
    const [w, x, y, z] = q, [a, b, c] = variance;
    const r00 = 1 - 2 * (y * y + z * z), r01 = 2 * (x * y - w * z), r02 = 2 * (x * z + w * y);
    const r10 = 2 * (x * y + w * z), r11 = 1 - 2 * (x * x + z * z), r12 = 2 * (y * z - w * x);
    const r20 = 2 * (x * z - w * y), r21 = 2 * (y * z + w * x), r22 = 1 - 2 * (x * x + y * y);
    outA[4 * i] = a * r00 * r00 + b * r01 * r01 + c * r02 * r02;
    outA[4 * i + 1] = a * r00 * r10 + b * r01 * r11 + c * r02 * r12;
    outA[4 * i + 2] = a * r00 * r20 + b * r01 * r21 + c * r02 * r22;
    outA[4 * i + 3] = a * r10 * r10 + b * r11 * r11 + c * r12 * r12;
    outB[4 * i] = a * r10 * r20 + b * r11 * r21 + c * r12 * r22;
    outB[4 * i + 1] = a * r20 * r20 + b * r21 * r21 + c * r22 * r22;
  }
}

function packBaseColours(container, name, count, texels) {
  const {values, low, span, steps} = container.array(`${name}.colour`, [count, 3]);
  const packed = new Uint16Array(4 * texels);
  for (let i = 0; i < count; ++i) {
    for (let c = 0; c < 3; ++c) packed[4 * i + c] = values[3 * i + c];
  }
  return {packed, low, step: span / steps};
}

/** Higher coefficients as they are stored, 16 bytes to a texel: layer k holds bytes 16 k .. 16 k + 15. */
function packHarmonics(container, name, count, texels, degree) {
  if (degree === 0) return null;
  const coefficients = (degree + 1) ** 2 - 1;
  const {values, low, span, steps} = container.array(`${name}.sh`, [count, coefficients, 3]);
  const stride = 3 * coefficients * values.BYTES_PER_ELEMENT, layers = Math.ceil(stride / 16);
  const from = new Uint8Array(values.buffer, values.byteOffset, values.byteLength);
  const to = new Uint8Array(16 * texels * layers);
  for (let i = 0; i < count; ++i) {
    for (let k = 0; k < stride; ++k) to[16 * ((k >> 4) * texels + i) + (k & 15)] = from[i * stride + k];
  }
  return {packed: new Uint32Array(to.buffer), layers, low, step: span / steps, bytes: values.BYTES_PER_ELEMENT};
}

/**
 * The Gaussians `name` ('object' or 'background') of an inflated section: {count, rows, degree, positions, covarianceA,
 * covarianceB, base, harmonics}; positions [rows * kWidth, 4] are x, y, z and the opacity, in scene units and the world
 * frame.
 */
export function readCloud(container, name, {splats: count, sh_degree: degree = 0}) {
  if (!Number.isInteger(count) || count < 0 || !(degree >= 0 && degree <= 3)) {
    throw new ClipError(`The header of this file is damaged (${name}).`);
  }
  const rows = Math.ceil(count / kWidth), texels = rows * kWidth;
  const cloud = {
    count, rows, degree,
    positions: new Float32Array(4 * texels),
    covarianceA: new Float32Array(4 * texels),
    covarianceB: new Float32Array(4 * texels),
  };
  fillPositions(container, name, count, cloud.positions);
  fillOpacities(container, name, count, cloud.positions);
  fillCovariances(container, name, count, cloud.covarianceA, cloud.covarianceB);
  cloud.base = packBaseColours(container, name, count, texels);
  cloud.harmonics = packHarmonics(container, name, count, texels, degree);
  return cloud;
}

/** Smallest sphere around the box of the positions [count, stride]: {centre, radius}. */
export function boundingSphere(positions, count, stride) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < count; ++i) {
    for (let c = 0; c < 3; ++c) {
      low[c] = Math.min(low[c], positions[stride * i + c]);
      high[c] = Math.max(high[c], positions[stride * i + c]);
    }
  }
  return {
    centre: low.map((value, c) => (value + high[c]) / 2),
    radius: Math.hypot(...low.map((value, c) => (high[c] - value) / 2)),
  };
}
