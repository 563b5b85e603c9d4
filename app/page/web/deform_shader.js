// Pass 1: the Gaussians of the object carried by their drivers.

import {kWidth} from './cloud.js';

/** Drivers in a row of their textures. */
export const kDriversPerRow = 256;

/** Rotations and stretches of 3 x 3 matrices.  Matrices are column-major, as GLSL has them. */
const kPolar = `
mat3 cofactor(mat3 F) {
  return mat3(cross(F[1], F[2]), cross(F[2], F[0]), cross(F[0], F[1]));
}

float squaredNorm(mat3 F) {
  return dot(F[0], F[0]) + dot(F[1], F[1]) + dot(F[2], F[2]);
}

// One Jacobi rotation of rows and columns p and q of a symmetric 4 x 4 matrix; r and s are the other two.
void rotatePair(inout float pp, inout float qq, inout float pq, inout float pr, inout float qr, inout float ps,
                inout float qs, inout vec4 vp, inout vec4 vq) {
  if (abs(pq) < 1e-20) return;
  float theta = (qq - pp) / (2. * pq);
  float t = (theta >= 0. ? 1. : -1.) / (abs(theta) + sqrt(theta * theta + 1.));
  float c = inversesqrt(t * t + 1.), s = t * c;
  pp -= t * pq;
  qq += t * pq;
  pq = 0.;
  vec2 old = vec2(pr, ps);
  pr = c * pr - s * qr;
  qr = s * old.x + c * qr;
  ps = c * ps - s * qs;
  qs = s * old.y + c * qs;
  vec4 v = vp;
  vp = c * vp - s * vq;
  vq = s * v + c * vq;
}

mat3 rotationOf(vec4 q) {  // (w, x, y, z) of length 1
  float w = q.x, x = q.y, y = q.z, z = q.w;
  return mat3(1. - 2. * (y * y + z * z), 2. * (x * y + w * z), 2. * (x * z - w * y),
              2. * (x * y - w * z), 1. - 2. * (x * x + z * z), 2. * (y * z + w * x),
              2. * (x * z + w * y), 2. * (y * z - w * x), 1. - 2. * (x * x + y * y));
}

vec4 quaternionOf(mat3 R) {
  vec4 squares = vec4(1. + R[0][0] + R[1][1] + R[2][2], 1. + R[0][0] - R[1][1] - R[2][2],
                      1. - R[0][0] + R[1][1] - R[2][2], 1. - R[0][0] - R[1][1] + R[2][2]);
  float wx = R[1][2] - R[2][1], wy = R[2][0] - R[0][2], wz = R[0][1] - R[1][0];
  float xy = R[1][0] + R[0][1], xz = R[2][0] + R[0][2], yz = R[2][1] + R[1][2];
  float most = max(max(squares.x, squares.y), max(squares.z, squares.w));
  vec4 q = vec4(wz, xz, yz, squares.w);
  if (most == squares.x) q = vec4(squares.x, wx, wy, wz);
  else if (most == squares.y) q = vec4(wx, squares.y, xy, xz);
  else if (most == squares.z) q = vec4(wy, xy, squares.z, yz);
  return normalize(q);
}

// The rotation that maximises tr(R^T F), for any F: its quaternion is the dominant eigenvector of a symmetric 4 x 4
// matrix (Davenport; Horn 1987).
mat3 closestRotation(mat3 F) {
  float a = F[0][0] + F[1][1] + F[2][2], b = F[0][0] - F[1][1] - F[2][2];
  float c = F[1][1] - F[0][0] - F[2][2], d = F[2][2] - F[0][0] - F[1][1];
  float ab = F[1][2] - F[2][1], ac = F[2][0] - F[0][2], ad = F[0][1] - F[1][0];
  float bc = F[1][0] + F[0][1], bd = F[2][0] + F[0][2], cd = F[2][1] + F[1][2];
  vec4 va = vec4(1, 0, 0, 0), vb = vec4(0, 1, 0, 0), vc = vec4(0, 0, 1, 0), vd = vec4(0, 0, 0, 1);
  for (int sweep = 0; sweep < 8; ++sweep) {
    rotatePair(a, b, ab, ac, bc, ad, bd, va, vb);
    rotatePair(a, c, ac, ab, bc, ad, cd, va, vc);
    rotatePair(a, d, ad, ab, bd, ac, cd, va, vd);
    rotatePair(b, c, bc, ab, ac, bd, cd, vb, vc);
    rotatePair(b, d, bd, ab, ad, bc, cd, vb, vd);
    rotatePair(c, d, cd, ac, ad, bc, bd, vc, vd);
  }
  float most = max(max(a, b), max(c, d));
  return rotationOf(normalize(most == a ? va : most == b ? vb : most == c ? vc : vd));
}

// Rotation of the polar decomposition, of determinant 1 for every F: by Newton's iteration (Higham 1986) unless F is
// nearly singular or inverted.
mat3 polarRotation(mat3 F) {
  float size = sqrt(squaredNorm(F));
  if (!(size > 0.)) return mat3(1);
  mat3 X = F * (1.7320508 / size);
  mat3 C = cofactor(X);
  float determinant = dot(X[0], C[0]);
  if (!(determinant > .02 * 5.1961524)) return closestRotation(F * (1. / size));
  for (int i = 0; i < 12; ++i) {
    mat3 next = .5 * (X + C * (1. / determinant));
    float change = squaredNorm(next - X);
    X = next;
    if (change < 1e-8) break;  // the next step would be its square
    C = cofactor(X);
    determinant = dot(X[0], C[0]);
  }
  return X;
}

// F with its principal stretches kept within [1 / kStretchLimit, kStretchLimit] and inversions undone.
const float kStretchLimit = 4.;
mat3 limitStretch(mat3 F) {
  mat3 C = cofactor(F);
  float determinant = dot(F[0], C[0]), most = kStretchLimit * kStretchLimit;
  if (determinant > 0. && squaredNorm(F) <= most && squaredNorm(C) <= most * determinant * determinant) return F;
  mat3 R = polarRotation(F), S = transpose(R) * F;
  float a = S[0][0], b = S[1][1], c = S[2][2], none = 0., nothing = 0.;
  float ab = .5 * (S[0][1] + S[1][0]), ac = .5 * (S[0][2] + S[2][0]), bc = .5 * (S[1][2] + S[2][1]);
  vec4 va = vec4(1, 0, 0, 0), vb = vec4(0, 1, 0, 0), vc = vec4(0, 0, 1, 0);
  for (int sweep = 0; sweep < 6; ++sweep) {
    rotatePair(a, b, ab, ac, bc, none, nothing, va, vb);
    rotatePair(a, c, ac, ab, bc, none, nothing, va, vc);
    rotatePair(b, c, bc, ab, ac, none, nothing, vb, vc);
  }
  mat3 V = mat3(va.xyz, vb.xyz, vc.xyz);
  vec3 limited = clamp(vec3(a, b, c), 1. / kStretchLimit, kStretchLimit);
  return R * mat3(V[0] * limited.x, V[1] * limited.y, V[2] * limited.z) * transpose(V);
}
`;

/** Drivers and weights of a Gaussian, packed as eight numbers of 16 and of 8 bits. */
export const kBinding = `int driverAt(uvec4 packed, int k) {
  uint pair = k < 2 ? packed.x : k < 4 ? packed.y : k < 6 ? packed.z : packed.w;
  return int((k & 1) == 0 ? pair & 65535u : pair >> 16);
}

float weightAt(uvec2 packed, int k) {
  return float((k < 4 ? packed.x : packed.y) >> uint(8 * (k & 3)) & 255u);
}`;

/** Fragment shader of the pass; one fragment per Gaussian. */
export const kDeform = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

uniform sampler2D restPosition, restCovarianceA, restCovarianceB;  // of the Gaussians, ${kWidth} to a row
uniform usampler2D driver, weight;                                 // of the Gaussians: 8 x 16 bits, 8 x 8 bits
uniform sampler2D driverRest, driverNow;                           // positions; positions and deformation gradients

layout(location = 0) out vec4 outPosition;
layout(location = 1) out vec4 outCovarianceA;
layout(location = 2) out vec4 outCovarianceB;
layout(location = 3) out vec4 outRotation;

const float kTwistShare = .1;
${kPolar}
${kBinding}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 position = texelFetch(restPosition, at, 0);
  vec4 covarianceA = texelFetch(restCovarianceA, at, 0), covarianceB = texelFetch(restCovarianceB, at, 0);
  uvec4 drivers = texelFetch(driver, at, 0);
  uvec2 weights = texelFetch(weight, at, 0).xy;
  outPosition = position;
  outCovarianceA = covarianceA;
  outCovarianceB = covarianceB;
  outRotation = vec4(1, 0, 0, 0);

  // Weighted means of the drivers.
  float total = 0.;
  vec3 rest = vec3(0), now = vec3(0);
  mat3 F = mat3(0);
  for (int k = 0; k < 8; ++k) {
    float w = weightAt(weights, k);
    if (w == 0.) continue;
    int j = driverAt(drivers, k);
    ivec2 texel = ivec2(j % ${kDriversPerRow}, j / ${kDriversPerRow});
    vec4 a = texelFetch(driverNow, ivec2(3 * texel.x, texel.y), 0);
    vec4 b = texelFetch(driverNow, ivec2(3 * texel.x + 1, texel.y), 0);
    vec4 c = texelFetch(driverNow, ivec2(3 * texel.x + 2, texel.y), 0);
    total += w;
    rest += w * texelFetch(driverRest, texel, 0).xyz;
    now += w * a.xyz;
    F += w * mat3(a.w, b.z, c.y, b.x, b.w, c.z, b.y, c.x, c.w);
  }
  if (total == 0.) return;
  rest /= total;
  now /= total;
  F *= 1. / total;

  // Their rigid fit.
  mat3 H = mat3(0);
  float spread = 0.;
  for (int k = 0; k < 8; ++k) {
    float w = weightAt(weights, k) / total;
    if (w == 0.) continue;
    int j = driverAt(drivers, k);
    ivec2 texel = ivec2(j % ${kDriversPerRow}, j / ${kDriversPerRow});
    vec3 from = texelFetch(driverRest, texel, 0).xyz - rest;
    vec3 to = texelFetch(driverNow, ivec2(3 * texel.x, texel.y), 0).xyz - now;
    H += w * outerProduct(to, from);
    spread += w * dot(from, from);
  }
  H = spread > 0. ? H * (1. / spread) + kTwistShare * F : F;
  mat3 R = polarRotation(H), M = limitStretch(F);

  mat3 covariance = mat3(covarianceA.xyz, covarianceA.yw, covarianceB.x, covarianceA.z, covarianceB.xy);
  covariance = M * covariance * transpose(M);
  outPosition.xyz = R * (position.xyz - rest) + now;
  outCovarianceA = vec4(covariance[0], covariance[1][1]);
  outCovarianceB = vec4(covariance[1][2], covariance[2][2], 0, 0);
  outRotation = quaternionOf(R);
}`;
