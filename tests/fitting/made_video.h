#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "fitting/observe/reference_video.h"
#include "gaussians/base/random.h"

namespace pliant {

/// A textured disc that turns and travels before a textured wall, and points on it whose places are known.
struct MadeVideo {
  int width = 160, height = 120, frames = 20;
  double radius = 34, travel = 25, turn = 0.6;  ///< px, px, rad: amplitudes
  double noise = 0;                             ///< of colours, standard deviation
  double wall_shift = 0;                        ///< px a frame: the camera moves

  Eigen::Vector2d centre(int t) const { return rest() + travel * swing(t) * Eigen::Vector2d(1, 0.2); }
  Eigen::Vector2d rest() const { return {0.5 * width, 0.5 * height}; }
  double swing(int t) const { return std::sin(2 * M_PI * t / frames); }
  Eigen::Matrix2d rotation(int t) const { return Eigen::Rotation2Dd(turn * swing(t)).toRotationMatrix(); }
  /// Where a point of the disc is that lies at p in the first frame.
  Eigen::Vector2d moved(const Eigen::Vector2d& p, int t) const { return centre(t) + rotation(t) * (p - rest()); }

  /// Smooth noise that never repeats within a picture; its features are about 6 and 14 px across.
  static double texture(double x, double y, int channel, int kind) {
    static const std::vector<float> lattice = [] {
      std::vector<float> values(64 * 64 * 8);
      for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(Random(11, i).uniform());
      return values;
    }();
    double sum = 0;
    for (const double size : {6.0, 14.0}) {
      const double u = x / size + 1000 * 64, v = y / size + 1000 * 64;
      const int i = static_cast<int>(u), j = static_cast<int>(v);
      const auto ease = [](double f) { return f * f * f * (f * (6 * f - 15) + 10); };
      const double a = ease(u - i), b = ease(v - j);
      const auto at = [&](int k, int l) { return lattice[((k & 63) * 64 + (l & 63)) * 8 + (channel + 3 * kind) % 8]; };
      sum += 0.5 *
             ((1 - b) * ((1 - a) * at(i, j) + a * at(i + 1, j)) + b * ((1 - a) * at(i, j + 1) + a * at(i + 1, j + 1)));
    }
    return sum;
  }
  Eigen::Vector3d colour(const Eigen::Vector2d& p, int t) const {
    const Eigen::Vector2d local = rotation(t).transpose() * (p - centre(t));
    const bool disc = local.norm() < radius;
    Eigen::Vector3d out;
    for (int c = 0; c < 3; ++c)
      out[c] = disc ? 0.3 + 0.7 * texture(local.x(), local.y(), c, 1)
                    : 0.7 * texture(0.6 * (p.x() - wall_shift * t), 0.6 * p.y(), c, 5);
    return out;
  }
  ImageF frame(int t) const {
    ImageF picture(width, height, 3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int s = 0; s < 4; ++s) sum += 0.25 * colour({x + 0.25 + 0.5 * (s % 2), y + 0.25 + 0.5 * (s / 2)}, t);
        Random random(7, static_cast<uint64_t>(t) * width * height + static_cast<uint64_t>(y) * width + x);
        for (int c = 0; c < 3; ++c)
          picture(x, y, c) = static_cast<float>(std::clamp(sum[c] + noise * random.normal(), 0.0, 1.0));
      }
    return picture;
  }
  ReferenceVideo video() const {
    ReferenceVideo out;
    out.camera.name = "made";
    out.camera.width = width;
    out.camera.height = height;
    out.fps = 24;
    for (int t = 0; t < frames; ++t) out.frames.push_back(frame(t));
    return out;
  }
  /// The disc in the first frame.
  ImageU8 mask() const {
    ImageU8 out(width, height, 1);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        out(x, y) = (Eigen::Vector2d(x + 0.5, y + 0.5) - rest()).norm() < radius ? 255 : 0;
    return out;
  }
  /// Points on the disc, out to `share` of its radius.
  std::vector<Eigen::Vector2d> points(double share = 0.85) const {
    std::vector<Eigen::Vector2d> out;
    for (double y = -radius; y <= radius; y += 8)
      for (double x = -radius; x <= radius; x += 8)
        if (std::hypot(x, y) < share * radius) out.push_back(rest() + Eigen::Vector2d(x + 0.3, y - 0.2));
    return out;
  }
};

}  // namespace pliant
