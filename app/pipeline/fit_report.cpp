#include "app/pipeline/fit_report.h"

#include <optional>

#include "gaussians/io/image_io.h"
#include "gaussians/io/video.h"
#include "gaussians/render/image_loss.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

constexpr int kGrow = 8;  // px by which the moving mask is grown for scores

double psnr_in(const ImageF& a, const ImageF& b, const ImageF& weight) { return psnr_of_mse(mse_loss(a, b, weight)); }

/// Seen, drawn, and half grey plus their difference.
ImageF side_by_side_picture(const ImageF& seen, const ImageF& drawn) {
  ImageF side(3 * seen.width, seen.height, 3);
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x)
      for (int c = 0; c < 3; ++c) {
        side(x, y, c) = seen(x, y, c), side(seen.width + x, y, c) = drawn(x, y, c);
        side(2 * seen.width + x, y, c) = 0.5f + seen(x, y, c) - drawn(x, y, c);
      }
  return side;
}

}  // namespace

MotionScores compare_motion(const FitScene& fit, const FittedMotion& motion, const fs::path& side_by_side) {
  const ImageF mask = motion_mask(fit, kGrow);
  const ImageF& first = fit.video.frames[0];
  MotionScores scores;
  scores.rest = psnr_in(fit.still, first, mask);
  std::optional<VideoWriter> writer;
  if (!side_by_side.empty()) writer.emplace(side_by_side, fit.video.fps, 3 * first.width, first.height);
  for (size_t k = 0; k < motion.frames.size(); ++k) {
    const int f = motion.first_frame + static_cast<int>(k);
    const ImageF& seen = fit.video.frames.at(f);
    const ImageF drawn = render(fit.drawn->at(motion.frames[k]), fit.video.camera, fit.drawn->render).color;
    if (writer) writer->write(side_by_side_picture(seen, drawn));
    const bool used = f < fit.used;
    (used ? scores.psnr_used : scores.psnr_later) += psnr_in(drawn, seen, mask);
    (used ? scores.still_used : scores.still_later) += psnr_in(first, seen, mask);
    ++(used ? scores.frames_used : scores.frames_later);
  }
  if (writer) writer->close();
  if (scores.frames_used) scores.psnr_used /= scores.frames_used, scores.still_used /= scores.frames_used;
  if (scores.frames_later) scores.psnr_later /= scores.frames_later, scores.still_later /= scores.frames_later;
  return scores;
}

}  // namespace pliant
