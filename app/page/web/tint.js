// Colours that show a quantity of the drivers, and their legend.

import {quantity} from './overlay.js';

const kShareWithin = 0.99;  // of the drivers, which the scale covers
const kStops = 12;          // of the legend's gradient

// Coefficients of a polynomial close to the colour map viridis, for 0 to 1 (M. Zucker).
const kViridis = [
  [0.2777273, 0.0054073, 0.3340998], [0.1050930, 1.4046135, 1.3845902], [-0.3308618, 0.2148476, 0.0950952],
  [-4.6342305, -5.7991010, -19.3324410], [6.2282699, 14.1799334, 56.6905526],
  [4.7763850, -13.7451454, -65.3530326], [-5.4354559, 4.6458526, 26.3124352],
];

/** GLSL function `vec3 viridis(float t)`. */
export const kViridisShader = `vec3 viridis(float t) {
  return ${kViridis.map((rgb) => `vec3(${rgb.map((value) => value.toFixed(7)).join(', ')})`).join(' + t * (')}` +
    `${')'.repeat(kViridis.length - 1)};
}`;

function viridis(t) {
  return [0, 1, 2].map((c) => Math.min(1, Math.max(0, kViridis.reduceRight((sum, row) => sum * t + row[c], 0))));
}

/** Largest principal stretch of F [9] at an offset: the root of the largest eigenvalue of F^T F, in closed form. */
export function largestStretch(F, at) {
  const a = F[at], b = F[at + 1], c = F[at + 2], d = F[at + 3], e = F[at + 4], f = F[at + 5];
  const g = F[at + 6], h = F[at + 7], i = F[at + 8];
  const xx = a * a + d * d + g * g, yy = b * b + e * e + h * h, zz = c * c + f * f + i * i;
  const xy = a * b + d * e + g * h, xz = a * c + d * f + g * i, yz = b * c + e * f + h * i;
  const mean = (xx + yy + zz) / 3, u = xx - mean, v = yy - mean, w = zz - mean;
  const p = Math.sqrt((u * u + v * v + w * w + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  if (!(p > 1e-9)) return Math.sqrt(Math.max(mean, 0));
  const determinant = u * (v * w - yz * yz) - xy * (xy * w - yz * xz) + xz * (xy * yz - v * xz);
  const angle = Math.acos(Math.min(1, Math.max(-1, determinant / (2 * p * p * p)))) / 3;
  return Math.sqrt(Math.max(mean + 2 * p * Math.cos(angle), 0));
}

const kQuantities = {
  stretch: {
    title: 'Maximum stretch', least: 1.02, growing: true, text: (value) => `×${value.toFixed(2)}`, low: 1,
    values: ({gradients}, out) => out.forEach((_, m) => out[m] = largestStretch(gradients, 9 * m)),
  },
  speed: {
    title: 'Speed', least: 1e-3, growing: true, text: (value) => quantity(value, 'm/s'), low: 0,
    values: ({velocities: v}, out) => out.forEach((_, m) => {
      out[m] = Math.hypot(v[3 * m], v[3 * m + 1], v[3 * m + 2]);
    }),
  },
  young: {
    title: 'Young’s modulus', text: (value) => quantity(10 ** value, 'Pa'),
    values: ({young, youngScale}, out) => out.forEach((_, m) => {
      out[m] = Math.log10(Math.max(young[m] * youngScale, 1e-9));
    }),
  },
};

/** Names of the quantities that colours can show. */
export const kColourings = Object.keys(kQuantities);

/** Tints the object; `kind` is a name of kColourings or null for its own colours. */
export class Tint {
  constructor(renderer, legend) {
    this.renderer = renderer;
    this.legend = legend;
    this.kind = null;
    const stops = Array.from({length: kStops + 1}, (_, k) => {
      return `rgb(${viridis(k / kStops).map((value) => Math.round(255 * value)).join(' ')})`;
    });
    legend.querySelector('.scale').style.background = `linear-gradient(90deg, ${stops.join(', ')})`;
  }

  choose(kind) {
    this.kind = kind;
    this.high = -Infinity;
    this.legend.hidden = !kind;
    if (!kind) this.renderer.setTint(null);
  }

  /** Shows the drivers of now: {gradients [M, 9], velocities [M, 3] (m/s), young [M] (Pa), youngScale}. */
  update(drivers) {
    const {title, text, values, least = -Infinity, growing, low: fixed} = kQuantities[this.kind];
    const scalars = new Float32Array(drivers.young.length);
    values(drivers, scalars);
    const sorted = scalars.slice().sort(), rank = (share) => sorted[Math.round(share * (sorted.length - 1))];
    const high = Math.max(rank(growing ? kShareWithin : 1), least, growing ? this.high : -Infinity);
    const low = fixed ?? rank(0);
    this.high = high;
    for (let m = 0; m < scalars.length; ++m) {
      const share = high > low ? (scalars[m] - low) / (high - low) : 0.5;
      scalars[m] = Math.min(Math.max(share, 0), 1);
    }
    this.renderer.setTint(scalars);
    const [name, from, to] = ['.name', '.low', '.high'].map((part) => this.legend.querySelector(part));
    name.textContent = title;
    from.textContent = text(low);
    to.textContent = text(high);
  }
}
