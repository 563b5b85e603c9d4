#include "app/page/clip_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/morton.h"
#include "gaussians/render/blend_weights.h"
#include "gaussians/render/deform.h"

namespace pliant {
namespace {

constexpr double kMostPixels = 400;  // of the longer side of a view that weighs Gaussians

Binding select(const Binding& binding, std::span<const int> order) {
  Binding out;
  for (const int i : order)
    for (int k = 0; k < Binding::kCount; ++k) {
      out.driver.push_back(binding.driver[i * Binding::kCount + k]);
      out.weight.push_back(binding.weight[i * Binding::kCount + k]);
    }
  return out;
}

/// Background Gaussians by the sum of their blend weights over the views, largest first.
std::vector<int> by_importance(const GaussianCloud& background, const std::vector<Camera>& views, bool antialiased) {
  std::vector<double> seen(background.size(), 0.0);
  RenderOptions options;
  options.antialiased = antialiased;
  for (const Camera& view : views) {
    const BlendWeights weights =
        blend_weights(background, view.scaled(std::min(1.0, kMostPixels / std::max(view.width, view.height))), options);
    for (size_t k = 0; k < weights.gaussian.size(); ++k) seen[weights.gaussian[k]] += weights.weight[k];
  }
  std::vector<int> order(background.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return seen[a] > seen[b]; });
  return order;
}

/// Weights in 255ths; the page divides by their sum.
std::vector<uint8_t> rounded_weights(const Binding& binding) {
  std::vector<uint8_t> out;
  for (size_t k = 0; k < binding.weight.size(); ++k)
    out.push_back(binding.driver[k] < 0 ? 0 : static_cast<uint8_t>(std::max(1L, std::lround(255 * binding.weight[k]))));
  return out;
}

}  // namespace

GaussianCloud CodedClip::decoded_frame(size_t t) const {
  const std::vector<Vec3f>& rest = level.driving_position;
  const DriverFrame frame = decoded(motion, rest, t);
  Binding rounded = binding;
  const std::vector<uint8_t> weights = rounded_weights(binding);
  for (size_t g = 0; g < binding.size(); ++g) {
    float sum = 0;
    for (int k = 0; k < Binding::kCount; ++k) sum += weights[g * Binding::kCount + k];
    for (int k = 0; k < Binding::kCount; ++k)
      rounded.weight[g * Binding::kCount + k] = weights[g * Binding::kCount + k] / std::max(sum, 1.0f);
  }
  GaussianCloud all = decoded(background), moved;
  deform({}, decoded(object), rounded, rest, frame.position, frame.F, moved);
  all.append(moved);
  return all;
}

ClipCoder::ClipCoder(MovingScene moving, const Scene& scene, std::vector<Camera> views)
    : moving_(std::move(moving)), scene_(scene), views_(std::move(views)) {
  const std::vector<int> order = morton_order(moving_.object.position);
  moving_.object = moving_.object.select(order);
  moving_.binding = select(moving_.binding, order);
  moving_.background = moving_.background.select(morton_order(moving_.background.position));
}

/// The share of the background that is seen most.
GaussianCloud ClipCoder::background_of(double share) {
  if (share >= 1) return moving_.background;
  if (by_importance_.empty()) by_importance_ = by_importance(moving_.background, views_, moving_.antialiased);
  const auto kept = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(moving_.background.size())));
  std::vector<int> places(by_importance_.begin(), by_importance_.begin() + kept);
  std::sort(places.begin(), places.end());
  return moving_.background.select(places);
}

CodedClip ClipCoder::code(const ClipChoice& choice, CodedClip before) {
  CodedClip clip = std::move(before);
  const ClipChoice had = clip.choice;
  const bool fresh = clip.object.size() == 0;
  clip.choice = choice;
  if (fresh || !(had.object == choice.object)) clip.object = code_splats(choice.object, moving_.object);
  if (fresh || !(had.background == choice.background) || had.background_share != choice.background_share) {
    clip.background = code_splats(choice.background, background_of(choice.background_share));
  }
  if (fresh || had.drivers != choice.drivers || !(had.motion == choice.motion)) {
    clip.level = choice.drivers > 0 ? with_drivers(moving_.particles, scene_, choice.drivers) : moving_.particles;
    clip.binding = choice.drivers > 0 ? bind_object(scene_, clip.level, moving_.object) : moving_.binding;
    clip.motion = code_motion(choice.motion, clip.level.driving_position, motion_of(moving_, clip.level));
  }
  return clip;
}

ClipFile ClipCoder::file_of(const CodedClip& clip) const {
  ClipFile file;
  add_splats(file, "object", clip.object);
  add_splats(file, "background", clip.background);
  const size_t n = clip.object.size(), m = clip.level.driving_position.size();
  std::vector<uint8_t> bound;
  for (size_t g = 0; g < n; ++g) bound.push_back(clip.binding.driver[g * Binding::kCount] >= 0);
  file.add("object", "object.bound", {n}, std::span<const uint8_t>(bound));
  add_level(file, "motion", 0, clip.level.driving_position, clip.binding);
  file.header["levels"] = nlohmann::json::array({{{"drivers", m}, {"clustered_to", clip.choice.drivers}}});
  add_motion(file, clip.motion);
  return file;
}

void add_binding(ClipFile& file, const std::string& section, const std::string& prefix, const Binding& binding) {
  constexpr uint16_t kUnused = 65535;
  std::vector<uint16_t> driver;
  for (const int d : binding.driver) {
    CHECK(d < kUnused);
    driver.push_back(d < 0 ? kUnused : static_cast<uint16_t>(d));
  }
  file.add(section, prefix + "driver", {binding.size(), Binding::kCount}, std::span<const uint16_t>(driver));
  const std::vector<uint8_t> weight = rounded_weights(binding);
  file.add(section, prefix + "weight", {binding.size(), Binding::kCount}, std::span<const uint8_t>(weight));
}

void add_level(ClipFile& file, const std::string& section, size_t l, const std::vector<Vec3f>& rest,
               const Binding& binding) {
  const std::string prefix = "level" + std::to_string(l) + ".";
  std::vector<float> places;
  for (const Vec3f& x : rest) places.insert(places.end(), x.data(), x.data() + 3);
  file.add(section, prefix + "rest", {rest.size(), 3}, std::span<const float>(places));
  add_binding(file, section, prefix, binding);
}

CodedClip fit_to_size(ClipCoder& coder, size_t bytes, const SolverShare& solver, ClipFile& file, SectionPacker& packer,
                      std::vector<std::string>& given_up, size_t& size) {
  constexpr std::array<int, 4> kMotionLevels = {6000, 4000, 2500, 1500};
  constexpr int kMostDrivers = 65534;  // numbers of 16 bits
  ClipChoice choice;
  const MovingScene& moving = coder.moving();
  const float extent = moving.object.bounds().size().maxCoeff();
  choice.object.sh_degree = moving.object.sh_degree;
  choice.background.sh_degree = moving.background.sh_degree;
  choice.motion = {2e-5 * extent, 2e-3};
  if (static_cast<int>(moving.particles.driving_position.size()) > kMostDrivers) choice.drivers = kMostDrivers;
  CodedClip clip;
  size_t of_solver = 0;
  const auto fits = [&] {
    clip = coder.code(choice, std::move(clip));
    // Clustering gives only about as many as it is asked for.
    for (int found; (found = static_cast<int>(clip.level.driving_position.size())) > kMostDrivers;) {
      choice.drivers = std::min(choice.drivers - 1, static_cast<int>(1.0 * choice.drivers * kMostDrivers / found));
      clip = coder.code(choice, std::move(clip));
    }
    file = coder.file_of(clip);
    of_solver = solver.bytes(clip);
    size = packer.pack(file) + of_solver;
    return size <= bytes;
  };
  if (fits()) return clip;

  // What each step gives up is seen less than what the next one does; of a kind, the last step counts.
  struct Step {
    int kind;
    std::string words;
    std::function<bool(ClipChoice&)> apply;  ///< false where there is nothing to give up
    int drivers = 0;                         ///< after it; 0 = as before
  };
  enum Kind { kBits, kMotion, kBackgroundSh, kDrivers, kShare, kObjectSh, kSolver };
  const auto lower_sh = [](SplatCoding& coding, int degree) {
    const bool lower = coding.sh_degree > degree;
    coding.sh_degree = std::min(coding.sh_degree, degree);
    return lower;
  };
  std::vector<Step> steps;
  steps.push_back({kBits, "scales, colors and opacities have 8 bits",
                   [](ClipChoice& c) { return c.object.fine = c.background.fine = false, true; }});
  steps.push_back({kMotion, "the motion is rounded to 1e-4 of the object's size", [=](ClipChoice& c) {
                     return c.motion = {1e-4 * extent, 1e-2}, true;
                   }});
  const auto background_sh = [&](int degree, const std::string& words) {
    steps.push_back({kBackgroundSh, words, [=](ClipChoice& c) { return lower_sh(c.background, degree); }});
  };
  background_sh(2, "the background has spherical harmonics of degree 2");
  background_sh(1, "the background has spherical harmonics of degree 1");
  for (const int drivers : kMotionLevels)
    steps.push_back({kDrivers, fmt::format("the motion is that of {} driving particles", drivers),
                     [=, &moving](ClipChoice& c) {
                       const bool fewer = static_cast<int>(moving.particles.driving_position.size()) > drivers;
                       if (fewer) c.drivers = drivers;
                       return fewer;
                     },
                     drivers});
  background_sh(0, "the background has no view-dependent color");
  const auto background_share = [&](double share) {
    steps.push_back({kShare, fmt::format("{:.0f} % of the background's Gaussians are left out", 100 * (1 - share)),
                     [=, &moving](ClipChoice& c) {
                       c.background_share = share;
                       return moving.background.size() > 0;
                     }});
  };
  const auto solver_levels = [&](size_t most, const std::string& words) {
    steps.push_back({kSolver, words, [=, &solver, &clip](ClipChoice& c) {
                       c.solver_levels = most;
                       return solver.levels(clip) > most;
                     }});
  };
  for (const double share : {0.8, 0.6}) background_share(share);
  solver_levels(2, "slow devices have the choice of two simpler bodies");
  solver_levels(1, "slow devices have one simpler body");
  for (const double share : {0.45, 0.3, 0.2, 0.1, 0.03}) background_share(share);
  for (const int degree : {1, 0})
    steps.push_back({kObjectSh, fmt::format("the object has spherical harmonics of degree {}", degree),
                     [=](ClipChoice& c) { return lower_sh(c.object, degree); }});
  solver_levels(0, "slow devices have no simpler body");
  steps.push_back({kSolver, "playback only, without the solver", [&](ClipChoice& c) {
                     c.solver = solver.needed;
                     return !solver.needed && of_solver > 0;
                   }});
  std::map<int, std::string> lost;
  for (const Step& step : steps) {
    if (!step.apply(choice)) continue;
    lost[step.kind] = step.words;
    // The motion and the solver shrink with the drivers: what will not be enough is not even clustered, but for the
    // last.
    const size_t motion = packer.packed("motion").size();
    const double fewer =
        static_cast<double>(motion) * step.drivers / static_cast<double>(clip.level.driving_position.size());
    if (step.drivers > kMotionLevels.back() &&
        static_cast<double>(size - of_solver - motion) + fewer > static_cast<double>(bytes))
      continue;
    if (fits()) break;
  }
  for (const auto& [kind, words] : lost) given_up.push_back(words);
  return clip;
}

}  // namespace pliant
