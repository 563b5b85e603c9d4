// From pixels and tracks through deformation and MLS-MPM to what a body is made of and how it starts.

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

#include "fitting/fields/axes_field.h"
#include "fitting/fields/smooth_field.h"
#include "fitting/objective/flow_loss.h"
#include "tests/fitting/made_motion.h"

namespace pliant {
namespace {

using namespace fixture;

/// One number of a motion.
struct Input {
  const char* name;
  std::function<double&(Motion<double>&)> at;
  std::function<double(const MotionGradient<double>&)> derivative;
};

std::vector<Input> inputs(size_t particles) {
  std::vector<Input> all;
  for (const size_t i : {particles / 2, particles - 1, particles / 3}) {
    all.push_back({"E", [i](Motion<double>& m) -> double& { return m.particles.young[i]; },
                   [i](const MotionGradient<double>& g) { return double(g.by.young[i]); }});
    all.push_back({"nu", [i](Motion<double>& m) -> double& { return m.particles.poisson[i]; },
                   [i](const MotionGradient<double>& g) { return double(g.by.poisson[i]); }});
    for (int a = 0; a < 3; ++a)
      all.push_back({"v0", [i, a](Motion<double>& m) -> double& { return m.start.v[i][a]; },
                     [i, a](const MotionGradient<double>& g) { return double(g.by.start.v[i][a]); }});
  }
  all.push_back({"damping time", [](Motion<double>& m) -> double& { return m.options.simulate.damping_time; },
                 [](const MotionGradient<double>& g) { return g.by.damping_time; }});
  return all;
}

/// Central differences with one Richardson step.
double difference(Motion<double> motion, const Objective<double>& objective, const Input& input, double step) {
  const double x = input.at(motion);
  const auto slope = [&](double h) {
    input.at(motion) = x + h;
    const double plus = motion_loss(motion, objective);
    input.at(motion) = x - h;
    const double minus = motion_loss(motion, objective);
    return (plus - minus) / (2 * h);
  };
  return (4 * slope(step / 2) - slope(step)) / 3;
}

void compare(const Motion<double>& motion, const Objective<double>& objective, double tolerance) {
  const MotionGradient<double> gradient = motion_loss_adjoint(motion, objective);
  EXPECT_NEAR(gradient.loss, motion_loss(motion, objective), 1e-12 * gradient.loss);
  for (const Input& input : inputs(motion.particles.size())) {
    Motion<double> copy = motion;
    const double size = std::max(0.05, std::abs(input.at(copy)));
    const double expected = difference(motion, objective, input, 1e-3 * size), found = input.derivative(gradient);
    EXPECT_NEAR(found, expected, tolerance * std::abs(expected) + 1e-12 * gradient.loss / size) << input.name;
  }
}

TEST(MotionGradient, PixelsToMaterialAndVelocityAgreeWithDifferencesOverThreeFrames) {
  Motion<double> motion = swinging_block<double>(3), other = swinging_block<double>(3, 3e4, 0.5);
  for (const double metres_per_unit : {0.5, 0.1}) {
    const auto drawn = drawn_block<double>(motion.particles, 60, metres_per_unit);
    const Camera camera = block_camera(28, 24, metres_per_unit);
    Objective<double> objective;
    objective.terms.push_back({1, std::make_shared<PictureLoss<double, false>>(
                                      PictureLossOptions{}, drawn, film<double, false>(other, *drawn, camera))});
    compare(motion, objective, 1e-4);
  }
}

TEST(MotionGradient, TracksToMaterialAndVelocityAgreeWithDifferences) {
  const Motion<double> motion = swinging_block<double>(3), other = swinging_block<double>(3, 3e4, 0.5);
  std::vector<Vec3f> drivers;
  for (const Vec3d& x : motion.particles.position) drivers.push_back(x.cast<float>());
  const auto seen = rollout<double>(other.options, other.particles, other.interactions, other.start);
  for (const bool in_picture : {false, true}) {
    PointTracks tracks;
    if (in_picture) tracks.camera = block_camera(200, 160);
    for (int k = 0; k < 6; ++k) tracks.rest.push_back(Vec3f(0.005f + 0.002f * k, 0.0f, 0.012f + 0.005f * k));
    const BodyPoints<double> points(tracks.rest, drivers, 1);
    for (const auto& state : seen.frames) {
      tracks.weight.push_back({1, 0.5, 0, 2, 1, 1});
      for (tracks.place.emplace_back(); const Vec3d& X : points.positions(state)) {
        Vec3d place = X;
        if (in_picture) place << project_point<double>(*tracks.camera, X), 0;
        tracks.place.back().push_back(place);
      }
    }
    tracks.place[1].clear();  // not seen
    Objective<double> objective;
    const double outlier = in_picture ? 2.0 : 1e-3;  // of the size of the errors, so that its bend counts
    objective.terms.push_back({3, std::make_shared<TrackLoss<double>>(tracks, drivers, 1, outlier)});
    compare(motion, objective, 1e-5);
    EXPECT_LT(motion_loss(other, objective), 1e-20);
  }
}

TEST(MotionGradient, DrawnFlowToMaterialAndVelocityAgreesWithDifferences) {
  Motion<double> motion = swinging_block<double>(3), other = swinging_block<double>(3, 3e4, 0.5);
  const auto drawn = drawn_block<double>(motion.particles, 60, 0.1);
  SeenFlow<double> seen;
  seen.camera = block_camera(28, 24, 0.1);
  Random random(3);
  for (const auto& [from, to] : {std::pair<int, int>{0, 1}, {1, 2}, {0, 3}}) {
    auto& pair = seen.pairs.emplace_back();
    pair.from = from;
    pair.to = to;
    pair.flow = Image<double>(28, 24, 2);
    pair.weight = Image<double>(28, 24, 1);
    for (double& value : pair.flow.data) value = 0.3 * random.normal();
    for (double& value : pair.weight.data) value = random.uniform();
  }
  Objective<double> objective;
  const double outlier = 0.5;  // of the size of the errors, so that its bend counts
  objective.whole.push_back({2, std::make_shared<FlowLoss<double, false>>(drawn, seen, outlier)});
  compare(motion, objective, 1e-4);
  EXPECT_GT(motion_loss_adjoint(motion, objective).by.start.v.back().norm(), 1e-6);
}

/// PhysDreamer's first stage: v0(x) as a field, from the rendered frames 1 to 3 by 0.1 L1 + 0.9 D-SSIM.
TEST(MotionGradient, TheFieldOfAStartLearnsFromThreeFramesAsDifferencesSayUnlessTheWindowIsCut) {
  const Motion<double> other = swinging_block<double>(3, 3e4, 0.5);
  Motion<double> still = swinging_block<double>(3, 2e4, 0);
  const auto drawn = drawn_block<double>(still.particles, 60, 0.5);
  Objective<double> objective;
  objective.terms.push_back(
      {1, std::make_shared<PictureLoss<double, false>>(PictureLossOptions{}, drawn,
                                                       film<double, false>(other, *drawn, block_camera(28, 24, 0.5)))});

  std::vector<Vec3f> points;
  for (const Vec3d& x : still.particles.position) points.push_back(x.cast<float>());
  SmoothFieldOptions smooth;
  smooth.sigma = 1;
  smooth.modes = 3;
  smooth.length = 0.02;
  const AxesField field(std::make_shared<SmoothField>(smooth, points));
  const auto moving = [&](const std::vector<double>& parameters) {
    Motion<double> motion = still;
    const std::vector<double> v = field.values(parameters);
    for (size_t i = 0; i < points.size(); ++i) motion.start.v[i] = Vec3d(v[3 * i], v[3 * i + 1], v[3 * i + 2]);
    return motion;
  };
  const auto slopes = [&](const std::vector<double>& parameters, int window) {
    Motion<double> motion = moving(parameters);
    motion.options.gradient_window = window;
    std::vector<double> adj_v;
    for (const Vec3d& v : motion_loss_adjoint(motion, objective).by.start.v)
      adj_v.insert(adj_v.end(), v.begin(), v.end());
    return field.values_adjoint(parameters, adj_v);
  };

  std::vector<double> parameters(field.constant(std::vector<double>(3, 0.0)).size());
  Random random(11);
  for (double& p : parameters) p = 0.2 * random.normal();
  const std::vector<double> whole = slopes(parameters, 0), cut = slopes(parameters, 1);
  double largest = 0, missed = 0;
  for (const double slope : whole) largest = std::max(largest, std::abs(slope));
  for (size_t k = 0; k < parameters.size(); ++k) {
    const auto slope = [&](double h) {
      std::vector<double> plus = parameters, minus = parameters;
      plus[k] += h;
      minus[k] -= h;
      return (motion_loss(moving(plus), objective) - motion_loss(moving(minus), objective)) / (2 * h);
    };
    EXPECT_NEAR(whole[k], (4 * slope(5e-5) - slope(1e-4)) / 3, 1e-4 * largest) << k;
    missed = std::max(missed, std::abs(cut[k] - whole[k]));
  }
  EXPECT_GT(missed, 0.1 * largest);
}

TEST(MotionGradient, TheFlowOfGaussiansThatMoveAlikeIsTheirMotionInThePicture) {
  // Everything moves sideways by 1 mm, 120 mm away on the mean.
  Motion<double> motion = swinging_block<double>(1);
  const auto drawn = drawn_block<double>(motion.particles, 400, 0.1);
  for (double& logit : drawn->object.opacity_logit) logit = 4;
  std::vector<BasicSimulationState<double>> frames(2, initial_state(motion.particles));
  for (Vec3d& x : frames[1].x) x.x() += 1e-3;
  SeenFlow<double> seen;
  seen.camera = block_camera(28, 24, 0.1);
  const double expected = seen.camera.fx * 1e-3 / 0.13;
  auto& pair = seen.pairs.emplace_back();
  pair.to = 1;
  pair.flow = Image<double>(28, 24, 2);
  pair.weight = Image<double>(28, 24, 1);
  pair.weight(14, 12) = 1;
  pair.flow(14, 12, 0) = expected;
  EXPECT_LT((FlowLoss<double, false>(drawn, seen, 10).value(frames)), 0.01 * expected * expected);
  pair.flow(14, 12, 0) = 0;
  EXPECT_NEAR((FlowLoss<double, false>(drawn, seen, 10).value(frames)), expected * expected, 0.2 * expected * expected);
}

/// All derivatives by E and v0, log E as unknown.
template <class T>
std::vector<double> flat(const Motion<T>& motion, const MotionGradient<T>& g) {
  std::vector<double> out;
  for (size_t i = 0; i < motion.particles.size(); ++i) out.push_back(double(g.by.young[i] * motion.particles.young[i]));
  for (const Vec3<T>& v : g.by.start.v)
    for (int a = 0; a < 3; ++a) out.push_back(double(v[a]));
  return out;
}

TEST(MotionGradient, FloatWithCutOffsPointsWhereDoubleWithoutThemPointsOverEightFrames) {
  const Motion<double> motion = swinging_block<double>(8), other = swinging_block<double>(8, 3e4, 0.5);
  const Motion<float> single = swinging_block<float>(8);
  const auto drawn = drawn_block<double>(motion.particles, 60, 0.1);
  const auto drawn_single = drawn_block<float>(single.particles, 60, 0.1);
  const Camera camera = block_camera(56, 48, 0.1);
  const SeenFrames<double> seen = film<double, false>(other, *drawn, camera);
  SeenFrames<float> seen_single;
  seen_single.camera = camera;
  for (const Image<double>& frame : seen.frames) {
    seen_single.frames.emplace_back(frame.width, frame.height, 3);
    for (size_t k = 0; k < frame.data.size(); ++k)
      seen_single.frames.back().data[k] = static_cast<float>(frame.data[k]);
  }
  Objective<double> exact;
  exact.terms.push_back({1, std::make_shared<PictureLoss<double, false>>(PictureLossOptions{}, drawn, seen)});
  Objective<float> used;
  used.terms.push_back({1, std::make_shared<PictureLoss<float>>(PictureLossOptions{}, drawn_single, seen_single)});
  const auto a = flat(motion, motion_loss_adjoint(motion, exact)), b = flat(single, motion_loss_adjoint(single, used));
  for (const auto& [first, last] :
       {std::pair<size_t, size_t>{0, motion.particles.size()}, {motion.particles.size(), a.size()}}) {
    double ab = 0, aa = 0, bb = 0;
    for (size_t i = first; i < last; ++i) {
      ab += a[i] * b[i];
      aa += a[i] * a[i];
      bb += b[i] * b[i];
    }
    const double cosine = ab / std::sqrt(aa * bb);
    EXPECT_GT(cosine, 0.999);
    printf("1 - cosine by %s: %.2e\n", first == 0 ? "log E" : "v0", 1 - cosine);
  }
}

TEST(MotionGradient, WeightsOfPixelsCutOutWhatIsNotCompared) {
  const Motion<float> motion = swinging_block<float>(2), other = swinging_block<float>(2, 3e4, 0.5);
  const auto drawn = drawn_block<float>(motion.particles, 60, 0.1);
  SeenFrames<float> seen = film<float, true>(other, *drawn, block_camera(28, 24, 0.1));
  seen.weight = {ImageF(28, 24, 1, 0.0f)};
  PictureLossOptions options;
  options.photometric = {0, 0};
  options.weight_mse = 1;
  Objective<float> objective;
  objective.terms.push_back({1, std::make_shared<PictureLoss<float>>(options, drawn, seen)});
  EXPECT_EQ(motion_loss(motion, objective), 0);
  seen.weight[0].data.assign(28 * 24, 1.0f);
  objective.terms[0].loss = std::make_shared<PictureLoss<float>>(options, drawn, seen);
  EXPECT_GT(motion_loss(motion, objective), 0);
  EXPECT_LT(motion_loss(other, objective), 1e-12);
}

}  // namespace
}  // namespace pliant
