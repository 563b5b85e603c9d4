#include "fitting/observe/find_camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"
#include "gaussians/render/image_loss.h"
#include "gaussians/vision/resize.h"

namespace pliant {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kShapeTolerance = 0.02;
constexpr double kLongestStep = 3;  // px
constexpr int kHalvings = 8;
constexpr int kRoughSize = 64;         // px of the longer side of the coarse view
constexpr double kRoughReach = 0.25;   // of the shorter side, over which shifts are tried
constexpr double kRoughRoll = 0.06;    // rad
constexpr double kRoughMargin = 0.02;  // by which a turned camera must be better

Camera fitted_to(const Camera& camera, int longer_side) {
  const double scale = static_cast<double>(longer_side) / std::max(camera.width, camera.height);
  return camera.resized(std::max(1, static_cast<int>(std::lround(camera.width * scale))),
                        std::max(1, static_cast<int>(std::lround(camera.height * scale))));
}

/// Median of the depth where the scene is opaque.
double middle_depth(const RenderResult& picture) {
  std::vector<float> depths;
  for (size_t i = 0; i < picture.alpha.data.size(); ++i)
    if (picture.alpha.data[i] > 0.5f) depths.push_back(picture.depth.data[i] / picture.alpha.data[i]);
  return depths.empty() ? 1 : quantile(std::move(depths), 0.5);
}

/// The picture with the mean of each colour as the scene has it.
ImageF with_colours_of(ImageF picture, const ImageF& scene) {
  for (int c = 0; c < 3; ++c) {
    double of_picture = 0, of_scene = 0;
    for (size_t i = 0; i < picture.pixels(); ++i) {
      of_picture += picture.data[3 * i + c];
      of_scene += scene.data[3 * i + c];
    }
    const float gain = of_picture > 0 ? static_cast<float>(std::clamp(of_scene / of_picture, 0.5, 2.0)) : 1.0f;
    for (size_t i = 0; i < picture.pixels(); ++i) picture.data[3 * i + c] *= gain;
  }
  return picture;
}

/// Correlation of a with b shifted by (du, dv), colour by colour, over what both show.
double shifted_correlation(const ImageF& a, const ImageF& b, int du, int dv) {
  const int left = std::max(0, -du), right = std::min(a.width, a.width - du), top = std::max(0, -dv),
            bottom = std::min(a.height, a.height - dv);
  double ab = 0, aa = 0, bb = 0;
  const double n = static_cast<double>(right - left) * (bottom - top);
  for (int c = 0; c < 3; ++c) {
    double sum_a = 0, sum_b = 0;
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        const double va = a(x, y, c), vb = b(x + du, y + dv, c);
        sum_a += va;
        sum_b += vb;
        ab += va * vb;
        aa += va * va;
        bb += vb * vb;
      }
    ab -= sum_a * sum_b / n;
    aa -= sum_a * sum_a / n;
    bb -= sum_b * sum_b / n;
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

/// The camera turned so that a coarse view correlates best with the picture: a small turn shifts the view, and shifts
/// are tried one by one, so that no repeated pattern holds the refinement back.
Camera turned_roughly(const GaussianCloud& cloud, const RenderOptions& rendering, const Camera& camera,
                      const ImageF& picture) {
  const Camera small = fitted_to(camera, std::min(kRoughSize, std::max(picture.width, picture.height)));
  const ImageF seen = resized(picture, small.width, small.height);
  const int reach = static_cast<int>(kRoughReach * std::min(small.width, small.height));
  Camera best = camera;
  double highest = -2;
  for (const double roll : {0.0, -kRoughRoll, kRoughRoll}) {
    Camera rolled = small;
    rolled.cam_from_world = Eigen::AngleAxisd(roll, Vec3d::UnitZ()) * small.cam_from_world;
    const ImageF view = render(cloud, rolled, rendering).color;
    for (int dv = -reach; dv <= reach; ++dv)
      for (int du = -reach; du <= reach; ++du) {
        const double score =
            shifted_correlation(view, seen, du, dv) - (du == 0 && dv == 0 && roll == 0 ? 0 : kRoughMargin);
        if (score <= highest) continue;
        highest = score;
        const Vec3d turn(-dv / small.fy, du / small.fx, 0);
        best.cam_from_world = Eigen::AngleAxisd(turn.norm(), turn.norm() > 0 ? turn.normalized() : Vec3d::UnitX()) *
                              rolled.cam_from_world;
      }
  }
  return best;
}

/// Loss of poses around a camera at one size.  Steps are in pixels, about: turn about the pivot, shift, each x, y, z.
class PoseLoss {
 public:
  PoseLoss(const GaussianCloud& cloud, const RenderOptions& rendering, const Camera& camera, const ImageF& picture)
      : cloud_(cloud), rendering_(rendering) {
    const RenderResult now = render(cloud, camera, rendering);
    picture_ = with_colours_of(resized(picture, camera.width, camera.height), now.color);
    const double depth = middle_depth(now), across = 0.3 * std::max(camera.width, camera.height);
    pivot_ = Vec3d(0, 0, depth);
    unit_ << 1 / (0.3 * camera.fx), 1 / (0.3 * camera.fx), 1 / across, depth / camera.fx, depth / camera.fx,
        depth / across;
  }

  Camera moved(const Camera& camera, const Vector6& step) const {
    const Vector6 x = unit_.cwiseProduct(step);
    const Vec3d turn = x.head<3>();
    const double angle = turn.norm();
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    motion.translation() = pivot_ - motion.linear() * pivot_ + x.tail<3>();
    Camera out = camera;
    out.cam_from_world = motion * camera.cam_from_world;
    return out;
  }

  double value(const Camera& camera) {
    ++renders;
    return photometric_loss({}, render(cloud_, camera, rendering_).color, picture_).total;
  }

  /// Loss and its derivatives by a step from `camera`.
  double value(const Camera& camera, Vector6& gradient) {
    renders += 3;
    RenderTape<float> tape;
    const RenderResult now = render(cloud_, camera, rendering_, {}, 0, &tape);
    RenderResult adj;
    const double loss = photometric_loss_adjoint({}, now.color, picture_, {}, 1.0, adj.color).total;
    const RenderGradient<float> g = render_adjoint(cloud_, camera, rendering_, {}, 0, now, adj, &tape);
    const Vec3d turn = g.rotation.cast<double>(), shift = g.translation.cast<double>();
    gradient << turn - pivot_.cross(shift), shift;
    gradient = gradient.cwiseProduct(unit_);
    return loss;
  }

  int renders = 0;

 private:
  const GaussianCloud& cloud_;
  const RenderOptions& rendering_;
  ImageF picture_;
  Vec3d pivot_;
  Vector6 unit_;
};

/// Nocedal and Wright (2006), algorithm 6.1, with a line search that halves.
Camera minimise(const CameraRefineOptions& options, PoseLoss& loss, Camera camera) {
  Vector6 gradient;
  double value = loss.value(camera, gradient);
  Matrix6 inverse = Matrix6::Identity();
  bool scaled = false;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    if (!(gradient.norm() > 0)) break;
    Vector6 step = -inverse * gradient;
    if (!scaled) step *= 0.5 / step.norm();
    if (step.norm() > kLongestStep) step *= kLongestStep / step.norm();
    if (step.dot(gradient) >= 0) {
      step = -0.5 * gradient.normalized();
      inverse.setIdentity();
      scaled = false;
    }
    Camera trial;
    double there = 0, share = 1;
    int halvings = 0;
    for (; halvings < kHalvings; ++halvings, share *= 0.5) {
      trial = loss.moved(camera, share * step);
      there = loss.value(trial);
      if (there < value + 1e-4 * share * step.dot(gradient)) break;
    }
    if (halvings == kHalvings) {
      if (!scaled) break;
      inverse.setIdentity();
      scaled = false;
      continue;
    }
    step *= share;
    Vector6 gradient_there;
    value = loss.value(trial, gradient_there);
    const Vector6 change = gradient_there - gradient;
    camera = trial;
    gradient = gradient_there;
    if (step.norm() < options.smallest_step) break;
    const double curvature = change.dot(step);
    if (curvature <= 1e-10 * change.norm() * step.norm()) continue;
    if (!scaled) {
      inverse = curvature / change.squaredNorm() * Matrix6::Identity();
      scaled = true;
    }
    const Matrix6 left = Matrix6::Identity() - step * change.transpose() / curvature;
    inverse = left * inverse * left.transpose() + step * step.transpose() / curvature;
  }
  return camera;
}

/// Refines at the sizes up to `largest` px.
Camera refine_up_to(const CameraRefineOptions& options, const GaussianCloud& cloud, const RenderOptions& rendering,
                    Camera camera, const ImageF& picture, int smallest, int largest, int& renders) {
  const int own = std::max(picture.width, picture.height);
  for (const int size : options.sizes) {
    if (size < smallest || (size > largest && size != options.sizes.front())) continue;
    const Camera at_size = fitted_to(camera, std::min(size, own));
    PoseLoss loss(cloud, rendering, at_size, picture);
    camera.cam_from_world = minimise(options, loss, at_size).cam_from_world;
    renders += loss.renders;
    if (size >= own) break;
  }
  return camera;
}

void compare(RefinedCamera& refined, const Camera& start) {
  const Eigen::Matrix3d turn = refined.camera.cam_from_world.linear() * start.cam_from_world.linear().transpose();
  refined.turned = Eigen::AngleAxisd(turn).angle() * 180 / M_PI;
  refined.moved = (refined.camera.centre() - start.centre()).norm();
}

}  // namespace

RefinedCamera refine_camera(const CameraRefineOptions& options, const GaussianCloud& cloud,
                            const RenderOptions& rendering, const Camera& start, const ImageF& picture) {
  CHECK(!options.sizes.empty() && std::is_sorted(options.sizes.begin(), options.sizes.end()));
  RefinedCamera out;
  const Camera from = start.resized(picture.width, picture.height);
  out.before = match_pictures(picture, render(cloud, from, rendering).color);
  out.camera = refine_up_to(options, cloud, rendering, turned_roughly(cloud, rendering, from, picture), picture, 0,
                            options.sizes.back(), out.renders);
  out.after = match_pictures(picture, render(cloud, out.camera, rendering).color);
  compare(out, from);
  return out;
}

FoundCamera find_camera(const FindCameraOptions& options, const GaussianCloud& cloud, const RenderOptions& rendering,
                        const std::vector<Camera>& cameras, const ImageF& picture) {
  FoundCamera out;
  const double shape = static_cast<double>(picture.width) / picture.height;
  std::vector<int> order;
  for (size_t i = 0; i < cameras.size(); ++i) {
    out.scores.push_back(-1);
    if (std::abs(cameras[i].width / (shape * cameras[i].height) - 1) > kShapeTolerance) continue;
    const Camera small = fitted_to(cameras[i].resized(picture.width, picture.height), options.search_size);
    out.scores[i] = match_score(resized(picture, small.width, small.height), render(cloud, small, rendering).color);
    order.push_back(static_cast<int>(i));
  }
  if (order.empty()) {
    throw input_error("reference video", "",
                      fmt::format("has frames of {} x {}, and none of the {} known cameras has this shape",
                                  picture.width, picture.height, cameras.size()),
                      "crop the video to the shape of the scene's cameras, or give a file with its camera");
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return out.scores[a] > out.scores[b]; });
  order.resize(std::min<size_t>(order.size(), options.candidates));

  // The candidates are compared after a coarse refinement, because a view beside a known camera hardly matches it.
  const int coarse = options.refine.sizes.size() > 1 ? options.refine.sizes[1] : options.refine.sizes[0];
  double best = -2;
  int renders = 0;
  for (const int i : order) {
    const Camera from = turned_roughly(cloud, rendering, cameras[i].resized(picture.width, picture.height), picture);
    const Camera camera = refine_up_to(options.refine, cloud, rendering, from, picture, 0, coarse, renders);
    const Camera small = fitted_to(camera, options.search_size);
    const double score =
        match_score(resized(picture, small.width, small.height), render(cloud, small, rendering).color);
    if (score > best) {
      best = score;
      out.nearest = i;
      out.refined.camera = camera;
    }
  }
  const Camera start = cameras[out.nearest].resized(picture.width, picture.height);
  out.refined.camera = refine_up_to(options.refine, cloud, rendering, out.refined.camera, picture, coarse + 1,
                                    options.refine.sizes.back(), renders);
  out.refined.renders = renders;
  out.refined.before = match_pictures(picture, render(cloud, start, rendering).color);
  out.refined.after = match_pictures(picture, render(cloud, out.refined.camera, rendering).color);
  compare(out.refined, start);
  out.found = out.refined.after.score >= options.least_score;
  const std::string& name = cameras[out.nearest].name;
  out.sentence = out.found ? fmt::format(
                                 "The video's camera is {:.2g} units from '{}' and rotated by {:.2g} degrees; its "
                                 "first frame matches the scene with score {:.2f}.",
                                 out.refined.moved, name, out.refined.turned, out.refined.after.score)
                           : fmt::format(
                                 "The first frame shows the scene from none of the {} known cameras: the best, '{}', "
                                 "matches with score {:.2f} ({:.2f} is needed).  Give a file with the video's camera, "
                                 "or check that the video shows this scene.",
                                 cameras.size(), name, out.refined.after.score, options.least_score);
  return out;
}

}  // namespace pliant
