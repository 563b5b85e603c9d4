#include "tests/gaussians/render/reference_renderer.h"

#include <Eigen/Dense>
#include <algorithm>
#include <numbers>
#include <vector>

namespace pliant {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Real spherical harmonics from associated Legendre functions with the Condon-Shortley phase:
// Y_l^m = sqrt(2) N P_l^|m|(cos theta) {sin |m| phi for m < 0, cos m phi for m > 0}, listed m = -l..l.
double harmonic(int l, int m, const Vector3d& d) {
  const int a = std::abs(m);
  const double phi = std::atan2(d.y(), d.x());
  const double sine = std::sqrt(std::max(0.0, 1 - d.z() * d.z()));
  double p = 1;  // P_a^a, then upwards in l
  for (int k = 1; k <= a; ++k) p *= -(2 * k - 1) * sine;
  double previous = 0;
  for (int k = a + 1; k <= l; ++k) {
    const double next = ((2 * k - 1) * d.z() * p - (k + a - 1) * previous) / (k - a);
    previous = p;
    p = next;
  }
  double ratio = 1;  // (l - a)! / (l + a)!
  for (int k = l - a + 1; k <= l + a; ++k) ratio /= k;
  const double n = std::sqrt((2 * l + 1) / (4 * std::numbers::pi) * ratio);
  if (m == 0) return n * p;
  return std::sqrt(2.0) * n * p * (m < 0 ? std::sin(a * phi) : std::cos(a * phi));
}

struct Drawn {
  double u, v, z, opacity;
  Matrix2d inverse;
  Vector3d color;
};

bool prepare(const GaussianCloud& cloud, size_t i, const Camera& camera, bool antialiased, Drawn& out) {
  const Matrix3d W = camera.cam_from_world.linear();
  const Vector3d mean = cloud.position[i].cast<double>(), t = camera.cam_from_world * mean;
  if (t.z() <= 0.2) return false;
  const Eigen::Vector4d q = cloud.rotation[i].cast<double>().normalized();
  const Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  const Vector3d scale = cloud.log_scale[i].cast<double>().array().exp();
  const Matrix3d sigma = R * scale.cwiseAbs2().asDiagonal() * R.transpose();
  // Centred principal points only: the frustum is clamped at 1.3 times the half fields of view.
  const double limit_x = 1.3 * camera.width / (2 * camera.fx), limit_y = 1.3 * camera.height / (2 * camera.fy);
  const double x = std::clamp(t.x() / t.z(), -limit_x, limit_x) * t.z();
  const double y = std::clamp(t.y() / t.z(), -limit_y, limit_y) * t.z();
  Eigen::Matrix<double, 2, 3> J;
  J << camera.fx / t.z(), 0, -camera.fx * x / (t.z() * t.z()), 0, camera.fy / t.z(), -camera.fy * y / (t.z() * t.z());
  const Matrix2d sharp = J * W * sigma * W.transpose() * J.transpose();
  const Matrix2d blurred = sharp + 0.3 * Matrix2d::Identity();
  out.u = camera.fx * t.x() / t.z() + camera.cx;
  out.v = camera.fy * t.y() / t.z() + camera.cy;
  out.z = t.z();
  out.inverse = blurred.inverse();
  out.opacity = 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logit[i])));
  if (antialiased) out.opacity *= std::sqrt(std::max(0.000025, sharp.determinant() / blurred.determinant()));
  const Vector3d direction = (mean - camera.centre()).normalized();
  out.color.setConstant(0.5);
  for (int l = 0, k = 0; l <= cloud.sh_degree; ++l)
    for (int m = -l; m <= l; ++m, ++k)
      for (int c = 0; c < 3; ++c) out.color[c] += harmonic(l, m, direction) * cloud.sh_of(i)[3 * k + c];
  out.color = out.color.cwiseMax(0.0);
  return true;
}

bool near(double value, double threshold, double slack) { return std::abs(value - threshold) < slack * threshold; }

}  // namespace

ReferencePicture render_slowly(const GaussianCloud& cloud, const Camera& camera, const Vec3f& background,
                               bool antialiased) {
  std::vector<Drawn> drawn;
  for (size_t i = 0; i < cloud.size(); ++i)
    if (Drawn d; prepare(cloud, i, camera, antialiased, d)) drawn.push_back(d);
  std::stable_sort(drawn.begin(), drawn.end(), [](const Drawn& a, const Drawn& b) { return a.z < b.z; });
  ReferencePicture out{{camera.width, camera.height, 3},
                       {camera.width, camera.height, 1},
                       {camera.width, camera.height, 1},
                       {camera.width, camera.height, 1}};
  for (int py = 0; py < camera.height; ++py) {
    for (int px = 0; px < camera.width; ++px) {
      double T = 1, depth = 0, previous_z = 0;
      Vector3d color = Vector3d::Zero();
      bool close = false;
      for (const Drawn& d : drawn) {
        const Vector2d offset(px + 0.5 - d.u, py + 0.5 - d.v);
        const double alpha = std::min(0.99, d.opacity * std::exp(-0.5 * offset.dot(d.inverse * offset)));
        close |= near(alpha, 1.0 / 255, 2e-4);
        if (alpha < 1.0 / 255) continue;
        close |= d.z - previous_z < 1e-6 * d.z;
        previous_z = d.z;
        const double after = T * (1 - alpha);
        close |= near(after, 1e-4, 1e-3);
        if (after < 1e-4) break;
        color += alpha * T * d.color;
        depth += alpha * T * d.z;
        T = after;
      }
      for (int c = 0; c < 3; ++c) out.color(px, py, c) = color[c] + T * background[c];
      out.depth(px, py) = depth;
      out.alpha(px, py) = 1 - T;
      out.close_call(px, py) = close;
    }
  }
  return out;
}

}  // namespace pliant
