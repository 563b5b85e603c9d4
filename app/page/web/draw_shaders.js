// Passes 2 to 4: colours, splats, and the picture over its background.

import {kWidth} from './cloud.js';
import {kBinding, kDriversPerRow} from './deform_shader.js';
import {kViridisShader} from './tint.js';

/** Splats in one instance of the drawing: four vertices each. */
export const kSplatsPerInstance = 512;

// Real spherical harmonics at the unit direction (x, y, z), in the order and with the signs of 3DGS files.
const kBasis = [
  '.28209479177387814',
  '-.4886025119029199 * y', '.4886025119029199 * z', '-.4886025119029199 * x',
  '1.0925484305920792 * x * y', '-1.0925484305920792 * y * z', '.31539156525252005 * (2. * z * z - x * x - y * y)',
  '-1.0925484305920792 * x * z', '.5462742152960396 * (x * x - y * y)',
  '-.5900435899266435 * y * (3. * x * x - y * y)', '2.890611442640554 * x * y * z',
  '-.4570457994644658 * y * (4. * z * z - x * x - y * y)',
  '.3731763325901154 * z * (2. * z * z - 3. * x * x - 3. * y * y)',
  '-.4570457994644658 * x * (4. * z * z - x * x - y * y)', '1.445305721320277 * z * (x * x - y * y)',
  '-.5900435899266435 * x * (x * x - 3. * y * y)',
];

/** GLSL that adds the terms of the harmonics to `colour`, read from packed words of 1 or 2 bytes per number. */
function harmonicTerms({layers, bytes}, degree) {
  const numbers = 4 / bytes, lines = [];
  for (let layer = 0; layer < layers; ++layer) {
    lines.push(`uvec4 t${layer} = texelFetch(harmonics, ivec3(at, ${layer}), 0);`);
    for (let word = 0; word < 4; ++word) {
      const bits = `t${layer}.${'xyzw'[word]}`;
      lines.push(bytes === 1 ? `uvec4 w${4 * layer + word} = uvec4(${bits}) >> uvec4(0, 8, 16, 24) & 255u;`
                             : `uvec2 w${4 * layer + word} = uvec2(${bits}) >> uvec2(0, 16) & 65535u;`);
    }
  }
  const number = (j) => `w${Math.floor(j / numbers)}.${'xyzw'[j % numbers]}`;
  for (let k = 1; k < (degree + 1) ** 2; ++k) {
    const [r, g, b] = [0, 1, 2].map((c) => number(3 * (k - 1) + c));
    lines.push(`colour += ${kBasis[k]} * (harmonicsLow + harmonicsStep * vec3(${r}, ${g}, ${b}));`);
  }
  return lines.join('\n  ');
}

const kTint = `
uniform usampler2D driver, weight;
uniform sampler2D scalar;  // of the drivers, 0 to 1
uniform float tint;        // share of the colour that shows it
${kBinding}
${kViridisShader}

vec3 tinted(vec3 colour, ivec2 at) {
  uvec4 drivers = texelFetch(driver, at, 0);
  uvec2 weights = texelFetch(weight, at, 0).xy;
  float total = 0., sum = 0.;
  for (int k = 0; k < 8; ++k) {
    float w = weightAt(weights, k);
    int j = driverAt(drivers, k);
    if (w > 0.) sum += w * texelFetch(scalar, ivec2(j % ${kDriversPerRow}, j / ${kDriversPerRow}), 0).x;
    total += w;
  }
  return total > 0. ? mix(colour, viridis(sum / total), tint) : colour;
}`;

/** Fragment shader of the colours of a cloud, one fragment per Gaussian; those of what `moves` may show a quantity. */
export function colourShader({degree, harmonics}, moves) {
  return `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
precision highp usampler2DArray;

uniform sampler2D position, rotation;
uniform usampler2D base;
uniform usampler2DArray harmonics;
uniform int firstRow;  // of the cloud in the textures of all Gaussians
uniform vec3 centre;   // of the camera
uniform float baseLow, baseStep, harmonicsLow, harmonicsStep;
out vec4 result;
${moves ? kTint : ''}

void main() {
  ivec2 all = ivec2(gl_FragCoord.xy), at = all - ivec2(0, firstRow);
  vec3 ray = texelFetch(position, all, 0).xyz - centre;
  float squared = dot(ray, ray);
  vec3 d = squared > 0. ? ray * inversesqrt(squared) : vec3(0);
  vec4 q = texelFetch(rotation, all, 0);
  vec3 t = 2. * cross(d, q.yzw);
  d += q.x * t + cross(t, q.yzw);  // seen from the frame at rest: R^T d
  float x = d.x, y = d.y, z = d.z;
  vec3 colour = .5 + ${kBasis[0]} * (baseLow + baseStep * vec3(texelFetch(base, at, 0).xyz));
  ${harmonics ? harmonicTerms(harmonics, degree) : ''}
  colour = max(colour, 0.);
  ${moves ? 'if (tint > 0.) colour = tinted(colour, at);' : ''}
  result = vec4(colour, 1);
}`;
}

/** Vertex shader of the splats: a quad around the ellipse where alpha is at least 1/255 (EWA projection). */
export const kSplatVertex = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

uniform sampler2D position, covarianceA, covarianceB, colour;
uniform usampler2D order;  // of the Gaussians, farthest first
uniform int count;         // of them
uniform mat3 R;            // cam_from_world
uniform vec3 t;
uniform vec2 focal, principal, size;  // pixels
uniform vec4 bounds;       // of x/z and y/z at which the Jacobian is taken: low and high
uniform bool antialiased;
out vec2 local;            // in standard deviations along the axes of the ellipse
flat out vec4 shade;       // colour, opacity

const float kNear = .2, kScreenVariance = .3, kMinAlpha = 1. / 255., kMinCompensation = 2.5e-5;

void main() {
  gl_Position = vec4(2, 2, 2, 1);
  int rank = gl_InstanceID * ${kSplatsPerInstance} + gl_VertexID / 4;
  if (rank >= count) return;
  int index = int(texelFetch(order, ivec2(rank % ${kWidth}, rank / ${kWidth}), 0).x);
  ivec2 at = ivec2(index % ${kWidth}, index / ${kWidth});
  vec4 centre = texelFetch(position, at, 0);
  vec3 p = R * centre.xyz + t;
  float opacity = centre.w;
  if (!(p.z > kNear) || opacity < kMinAlpha) return;

  vec4 a = texelFetch(covarianceA, at, 0);
  vec2 b = texelFetch(covarianceB, at, 0).xy;
  mat3 covariance = mat3(a.xyz, a.yw, b.x, a.z, b.xy);
  vec2 ray = p.xy / p.z, held = clamp(ray, bounds.xz, bounds.yw), mean = focal * ray + principal;
  mat3 axes = transpose(R);
  vec3 jx = focal.x / p.z * (axes[0] - held.x * axes[2]), jy = focal.y / p.z * (axes[1] - held.y * axes[2]);
  vec3 cx = covariance * jx, cy = covariance * jy;
  float sharpXx = dot(jx, cx), xy = dot(jx, cy), sharpYy = dot(jy, cy);
  float xx = sharpXx + kScreenVariance, yy = sharpYy + kScreenVariance;
  float sharp = max(sharpXx * sharpYy - xy * xy, 0.);
  float determinant = sharp + kScreenVariance * (sharpXx + sharpYy) + kScreenVariance * kScreenVariance;
  if (antialiased) opacity *= sqrt(max(sharp / determinant, kMinCompensation));
  if (!(opacity >= kMinAlpha)) return;

  float reach = sqrt(max(2. * log(opacity * 255.), 0.)) + .01;
  vec2 box = reach * sqrt(vec2(xx, yy));
  if (any(lessThan(mean + box, vec2(0))) || any(greaterThan(mean - box, size))) return;
  float half_ = .5 * (xx - yy), radius = length(vec2(half_, xy)), major = .5 * (xx + yy) + radius;
  vec2 axis = half_ >= 0. ? vec2(radius + half_, xy) : vec2(xy, radius - half_);
  axis = radius > 0. ? normalize(axis) : vec2(1, 0);
  local = reach * vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID & 2) - 1);
  vec2 pixel = mean + local.x * sqrt(major) * axis + local.y * sqrt(determinant / major) * vec2(-axis.y, axis.x);
  shade = vec4(texelFetch(colour, at, 0).rgb, opacity);
  gl_Position = vec4(vec2(2, -2) * pixel / size + vec2(-1, 1), 0, 1);
}`;

/** Fragment shader of the splats; the result is premultiplied. */
export const kSplatFragment = `#version 300 es
precision highp float;
in vec2 local;
flat in vec4 shade;
out vec4 result;

void main() {
  float alpha = shade.a * exp(-.5 * dot(local, local));
  if (alpha < 1. / 255.) discard;
  alpha = min(alpha, .99);
  result = vec4(alpha * shade.rgb, alpha);
}`;

/** Fragment shader that puts the blended splats over the background colour. */
export const kResolve = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D blended;
uniform vec3 background;
out vec4 result;

void main() {
  vec4 sum = texelFetch(blended, ivec2(gl_FragCoord.xy), 0);
  result = vec4(sum.rgb + (1. - sum.a) * background, 1);
}`;
