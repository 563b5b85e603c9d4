#include "app/fit/fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/fit/fit_pictures.h"
#include "app/report/chart.h"
#include "app/report/space_time_slices.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/render/image_loss.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kSurest = 0.01, kVaguest = 1;  // decades, ends of the scale of uncertainty
constexpr int kScoreGrow = 8;                   // px by which the moving mask is grown for scores

double psnr_in(const ImageF& a, const ImageF& b, const ImageF& weight) {
  return std::min(psnr_of_mse(mse_loss(a, b, weight)), kMostPsnr);
}

/// Seen, drawn, and half grey plus their difference.
ImageF side_by_side_picture(const ImageF& seen, const ImageF& drawn) {
  ImageF side(3 * seen.width, seen.height, 3);
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x)
      for (int c = 0; c < 3; ++c) {
        side(x, y, c) = seen(x, y, c);
        side(seen.width + x, y, c) = drawn(x, y, c);
        side(2 * seen.width + x, y, c) = 0.5f + seen(x, y, c) - drawn(x, y, c);
      }
  return side;
}

/// Which frames belong to each span.
MotionScores spans_of(const FitScene& fit, const FittedMotion& motion, int last_fitted) {
  const int end = motion.first_frame + static_cast<int>(motion.frames.size()) - 1, last_used = fit.used - 1;
  MotionScores scores;
  scores.fitted = {motion.first_frame, std::min({last_fitted, last_used, end})};
  scores.searched = {scores.fitted.last + 1, std::min(last_used, end)};
  scores.later = {last_used + 1, end};
  return scores;
}

/// Of one video; the names of pictures end in `suffix`.
MotionScores compare_view(const FitScene& fit, const FitView& view, const FittedMotion& motion, int last_fitted,
                          const fs::path& folder, const std::string& suffix) {
  ImageF mask = motion_mask(view, static_cast<int>(view.video.frames.size()), kScoreGrow);
  leave_out(mask, view, 0);  // which is held, and met by the scene at rest
  const ImageF& first = view.video.frames[0];
  MotionScores scores = spans_of(fit, motion, last_fitted);
  scores.rest = psnr_in(view.still, first, mask);
  const bool pictures = !folder.empty();
  SpaceTimeSlices slices({"video", "fit"}, most_changed_lines(view.video.frames, view.moving));
  std::optional<VideoWriter> writer;
  if (pictures)
    writer.emplace(folder / ("side_by_side" + suffix + ".mp4"), view.video.fps, 3 * first.width, first.height);
  for (size_t k = 0; k < motion.frames.size(); ++k) {
    const int f = motion.first_frame + static_cast<int>(k);
    if (f >= static_cast<int>(view.video.frames.size())) break;
    const ImageF& seen = view.video.frames.at(f);
    const ImageF drawn = render(fit.drawn->at(motion.frames[k]), view.video.camera, fit.drawn->render).color;
    if (pictures) {
      writer->write(side_by_side_picture(seen, drawn));
      slices.add(std::array{&seen, &drawn});
    }
    if (f == 0) continue;  // the first frame held is itself there, and `rest` says how well it is met
    ImageF compared = mask;
    if (!view.compared.empty()) leave_out(compared, view, f);
    if (std::none_of(compared.data.begin(), compared.data.end(), [](float w) { return w > 0; })) continue;
    MotionScores::Span& span = f <= scores.fitted.last     ? scores.fitted
                               : f <= scores.searched.last ? scores.searched
                                                           : scores.later;
    span.psnr += psnr_in(drawn, seen, compared);
    span.still += psnr_in(first, seen, compared);
    ++span.frames;
  }
  if (pictures) writer->close();
  if (pictures && !motion.frames.empty()) write_image(folder / ("slices" + suffix + ".png"), slices.picture());
  for (MotionScores::Span* span : {&scores.fitted, &scores.searched, &scores.later}) {
    span->psnr /= std::max(1, span->frames);
    span->still /= std::max(1, span->frames);
  }
  return scores;
}

}  // namespace

MotionScores compare_motion(const FitScene& fit, const FittedMotion& motion, int last_fitted, const fs::path& folder) {
  const std::vector<const FitView*> views = fit.views();
  MotionScores mean = spans_of(fit, motion, last_fitted);
  std::vector<MotionScores> all;
  for (size_t i = 0; i < views.size(); ++i) {
    all.push_back(compare_view(fit, *views[i], motion, last_fitted, folder, i == 0 ? "" : "_" + std::to_string(i + 1)));
    mean.rest += all[i].rest / static_cast<double>(views.size());
  }
  for (auto span : {&MotionScores::fitted, &MotionScores::searched, &MotionScores::later}) {
    const auto with_frames =
        std::count_if(all.begin(), all.end(), [&](const MotionScores& one) { return (one.*span).frames > 0; });
    const double share = 1.0 / static_cast<double>(std::max<std::ptrdiff_t>(1, with_frames));
    for (const MotionScores& one : all) {
      (mean.*span).psnr += share * (one.*span).psnr;
      (mean.*span).still += share * (one.*span).still;
      (mean.*span).frames = std::max((mean.*span).frames, (one.*span).frames);
    }
  }
  return mean;
}

json scores_to_json(const MotionScores& scores) {
  json out = {{"psnr_rest", scores.rest}};
  const std::pair<const char*, const MotionScores::Span*> spans[] = {
      {"fitted", &scores.fitted}, {"searched", &scores.searched}, {"later", &scores.later}};
  for (const auto& [name, span] : spans) {
    const std::string of = name;
    out["frames_" + of] = span->first <= span->last ? json{span->first, span->last} : json(nullptr);
    out["psnr_" + of] = span->frames > 0 ? json(span->psnr) : json(nullptr);
    out["still_" + of] = span->frames > 0 ? json(span->still) : json(nullptr);
  }
  return out;
}

void write_fit_pictures(const fs::path& folder, const FitScene& fit, const FitFindings& findings) {
  if (!findings.young_of_driver.empty()) {
    const auto [low, high] = std::minmax_element(findings.young_of_driver.begin(), findings.young_of_driver.end());
    write_image(folder / "young.png",
                picture_of_drivers(fit, findings.young_of_driver, *low, *high, "Young's modulus [Pa]"));
  }
  if (!findings.sigma_of_driver.empty()) {
    std::vector<double> sigma = findings.sigma_of_driver;
    for (double& s : sigma) s = std::clamp(s, kSurest, kVaguest);
    write_image(folder / "uncertainty.png",
                picture_of_drivers(fit, sigma, kSurest, kVaguest, "standard deviation of log10 E [decades]"));
  }
  if (!findings.search_young.empty()) {
    Curve curve{"", {}, findings.search_unexplained, false, 0};
    for (const double young : findings.search_young) curve.x.push_back(std::log10(young));
    Chart chart{"Search: unexplained motion for each stiffness",
                "log10 of Young's modulus [Pa]",
                "unexplained fraction",
                {curve},
                {},
                true};
    chart.marks = {std::log10(findings.young)};
    write_image(folder / "search.png", draw_chart(chart));
  }
  // Stages whose values mean the same share a chart.
  std::vector<Chart> charts;
  for (const FitFindings::Refinement& stage : findings.refinements) {
    if (stage.value.empty()) continue;
    if (charts.empty() || charts.back().y_label != stage.label)
      charts.push_back({"Refinement by simulation", "step", stage.label, {}, {}, true});
    const int color = static_cast<int>(charts.back().curves.size()) / 2;
    Curve curve{stage.name, {}, stage.value, false, color};
    for (size_t i = 0; i < stage.value.size(); ++i) curve.x.push_back(static_cast<double>(i));
    Curve dots{"", curve.x, curve.y, true, color};
    charts.back().curves.push_back(std::move(curve));
    charts.back().curves.push_back(std::move(dots));
  }
  for (size_t k = 0; k < charts.size(); ++k)
    write_image(folder / (k == 0 ? "loss.png" : fmt::format("loss_{}.png", k + 1)), draw_chart(charts[k]));
}

}  // namespace pliant
