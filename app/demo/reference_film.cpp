// The film of the reference motion: a mesh of the object over the still rest of the stage.

#include <algorithm>
#include <atomic>
#include <cmath>

#include "app/demo/raycast.h"
#include "app/demo/reference.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/bind.h"
#include "gaussians/render/deform.h"

namespace pliant {
namespace {

using Eigen::Vector2d;
constexpr double kEdge = 0.0016;  // m, of the mesh: less than a pixel

/// Painted triangles of everything that moves, at rest in the world.
struct PaintedMesh {
  std::vector<Vec3f> vertex, colour;
  std::vector<Eigen::Vector3i> triangle;
};

PaintedMesh mesh_of_object(const Stage& stage) {
  PaintedMesh mesh;
  for (const StagePart& part : stage.parts()) {
    if (!part.moves) continue;
    const TriangleMesh piece = part.shape->mesh(kEdge);
    const int base = static_cast<int>(mesh.vertex.size());
    for (size_t i = 0; i < piece.vertex.size(); ++i) {
      mesh.vertex.push_back((part.world_from_local * piece.vertex[i]).cast<float>());
      mesh.colour.push_back(part.colour(piece.vertex[i], piece.normal[i]).cast<float>());
    }
    for (const Eigen::Vector3i& t : piece.triangle) mesh.triangle.push_back(t + Eigen::Vector3i::Constant(base));
  }
  return mesh;
}

/// Colour and depth of samples, kSamplesAcross times as fine as the picture.
struct Samples {
  int width = 0, height = 0;
  std::vector<Vec3f> colour;
  std::vector<float> inverse_depth;  ///< 1 / z; 0 = nothing
};

Samples still_view(const Stage& stage, const Camera& camera) {
  const int width = camera.width * kSamplesAcross, height = camera.height * kSamplesAcross;
  Samples samples{width, height, std::vector<Vec3f>(static_cast<size_t>(width) * height, Vec3f::Zero()),
                  std::vector<float>(static_cast<size_t>(width) * height, 0.0f)};
  const Vec3d eye = camera.centre(), forward = camera.forward();
  parallel_for(
      height,
      [&](std::ptrdiff_t y) {
        for (int x = 0; x < width; ++x) {
          const Ray ray{eye, camera.ray((x + 0.5) / kSamplesAcross, (y + 0.5) / kSamplesAcross)};
          const StageHit hit = stage.cast(ray, false);
          if (hit.part < 0) continue;
          const size_t i = static_cast<size_t>(y) * width + x;
          samples.colour[i] = stage.colour(ray, hit).cast<float>();
          samples.inverse_depth[i] = static_cast<float>(1 / (hit.t * ray.direction.dot(forward)));
        }
      },
      8);
  return samples;
}

/// Fills one triangle; colour over depth and 1/depth are linear in the picture.
void draw(const Vec3d (&corner)[3], const Vec3f (&colour)[3], Samples& out) {
  const double area = (corner[1] - corner[0]).head<2>().x() * (corner[2] - corner[0]).y() -
                      (corner[1] - corner[0]).y() * (corner[2] - corner[0]).x();
  if (std::abs(area) < 1e-12) return;
  const auto [left, right] = std::minmax({corner[0].x(), corner[1].x(), corner[2].x()});
  const auto [top, bottom] = std::minmax({corner[0].y(), corner[1].y(), corner[2].y()});
  const int x0 = std::max(0, static_cast<int>(std::ceil(left - 0.5))),
            x1 = std::min(out.width - 1, static_cast<int>(right - 0.5));
  const int y0 = std::max(0, static_cast<int>(std::ceil(top - 0.5))),
            y1 = std::min(out.height - 1, static_cast<int>(bottom - 0.5));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      double weight[3];
      for (int k = 0; k < 3; ++k) {
        const Vec3d &a = corner[(k + 1) % 3], &b = corner[(k + 2) % 3];
        weight[k] = ((b.x() - a.x()) * (y + 0.5 - a.y()) - (b.y() - a.y()) * (x + 0.5 - a.x())) / area;
      }
      if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
      const double inverse = weight[0] * corner[0].z() + weight[1] * corner[1].z() + weight[2] * corner[2].z();
      const size_t i = static_cast<size_t>(y) * out.width + x;
      if (static_cast<float>(inverse) <= out.inverse_depth[i]) continue;
      out.inverse_depth[i] = static_cast<float>(inverse);
      Vec3f sum = Vec3f::Zero();
      for (int k = 0; k < 3; ++k) sum += static_cast<float>(weight[k] * corner[k].z() / inverse) * colour[k];
      out.colour[i] = sum;
    }
}

ImageF averaged(const Samples& samples, int width, int height) {
  ImageF image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Vec3f sum = Vec3f::Zero();
      for (int s = 0; s < kSamplesAcross * kSamplesAcross; ++s)
        sum += samples.colour[static_cast<size_t>(y * kSamplesAcross + s / kSamplesAcross) * samples.width +
                              x * kSamplesAcross + s % kSamplesAcross];
      for (int c = 0; c < 3; ++c) image(x, y, c) = sum[c] / (kSamplesAcross * kSamplesAcross);
    }
  return image;
}

/// Image point and 1/z of a world point, in samples.
Vec3d project(const Camera& camera, const Vec3d& world, double scale) {
  const Vec3d x = camera.cam_from_world * world;
  return {scale * (camera.fx * x.x() / x.z() + camera.cx), scale * (camera.fy * x.y() / x.z() + camera.cy), 1 / x.z()};
}

}  // namespace

ReferenceFilm film_reference(const Stage& stage, const ReferenceMotion& motion, const Camera& camera,
                             const Interrupted& interrupted) {
  const PaintedMesh mesh = mesh_of_object(stage);
  const Samples still = still_view(stage, camera);
  // The particles carry the vertices; the last point is the object's tip.
  GaussianCloud points;
  points.resize(mesh.vertex.size() + 1);
  std::copy(mesh.vertex.begin(), mesh.vertex.end(), points.position.begin());
  points.position.back() = stage.tip().cast<float>();
  BindOptions bind_options;
  bind_options.spacing = motion.samples.spacing;
  const Binding binding = pliant::bind(bind_options, points.position, motion.samples.position);

  ReferenceFilm film;
  film.frames.resize(motion.frames.size());
  film.tip.resize(motion.frames.size());
  film.pixel.resize(motion.frames.size());
  std::atomic<bool> stopped = false;
  parallel_for(static_cast<std::ptrdiff_t>(motion.frames.size()), [&](std::ptrdiff_t f) {
    if (stopped || is_interrupted(interrupted)) {
      stopped = true;
      return;
    }
    GaussianCloud now;
    deform({}, points, binding, motion.samples.position, motion.frames[f].x, motion.frames[f].F, now);
    std::vector<Vec3d> image_point(mesh.vertex.size());
    for (size_t i = 0; i < image_point.size(); ++i)
      image_point[i] = project(camera, now.position[i].cast<double>(), kSamplesAcross);
    Samples samples = still;
    for (const Eigen::Vector3i& t : mesh.triangle) {
      const Vec3d corner[3] = {image_point[t[0]], image_point[t[1]], image_point[t[2]]};
      const Vec3f colour[3] = {mesh.colour[t[0]], mesh.colour[t[1]], mesh.colour[t[2]]};
      draw(corner, colour, samples);
    }
    film.frames[f] = averaged(samples, camera.width, camera.height);
    film.tip[f] = now.position.back().cast<double>();
    film.pixel[f] = project(camera, film.tip[f], 1).head<2>();
  });
  stop_demo_if(stopped);
  return film;
}

}  // namespace pliant
