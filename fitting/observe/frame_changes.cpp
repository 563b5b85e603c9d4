#include "fitting/observe/frame_changes.h"

#include <cmath>

#include "gaussians/base/portable.h"
#include "gaussians/vision/match_pictures.h"

namespace pliant {
namespace {

ImageU8 inverted(const ImageU8& mask) {
  ImageU8 out(mask.width, mask.height, 1);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = mask.data[i] == 0;
  return out;
}

/// Mean absolute difference of colours where `ignored` is 0.
double mean_difference(const ImageF& a, const ImageF& b, const ImageU8& ignored) {
  double sum = 0;
  size_t n = 0;
  for (size_t i = 0; i < a.pixels(); ++i) {
    if (ignored.data[i] != 0) continue;
    for (int c = 0; c < 3; ++c) sum += std::abs(a.data[3 * i + c] - b.data[3 * i + c]);
    n += 3;
  }
  return n > 0 ? sum / static_cast<double>(n) : 0;
}

double mean_colour(const ImageF& picture, const ImageU8& ignored) {
  double sum = 0;
  size_t n = 0;
  for (size_t i = 0; i < picture.pixels(); ++i)
    if (ignored.data[i] == 0)
      for (int c = 0; c < 3; ++c) {
        sum += picture.data[3 * i + c];
        ++n;
      }
  return n > 0 ? sum / static_cast<double>(n) : 0;
}

}  // namespace

FrameChanges frame_changes(std::span<const ImageF> frames, const ImageU8& surroundings, const HiddenPixels& hidden) {
  const size_t count = frames.size();
  FrameChanges out{std::vector<double>(count, 1), std::vector<double>(count, 0), std::vector<float>(count, 0),
                   std::vector<double>(count, 0)};
  const ImageU8 elsewhere = inverted(surroundings);
  parallel_for(static_cast<std::ptrdiff_t>(count) - 1, [&](std::ptrdiff_t k) {
    const ImageF &a = frames[k], &b = frames[k + 1];
    const int t = static_cast<int>(k);
    const ImageU8 ignored = hidden.beside(surroundings, t, t + 1);
    out.score[k + 1] = match_score(a, b, ignored);
    out.difference[k + 1] = mean_difference(a, b, ignored);
    out.moved[k + 1] = static_cast<float>(mean_difference(a, b, hidden.beside(elsewhere, t, t + 1)));
  });
  for (size_t t = 1; t < count; ++t) {
    const ImageU8 ignored = hidden.beside(surroundings, 0, static_cast<int>(t));
    const double first = mean_colour(frames[0], ignored);
    if (first > 0) out.light[t] = std::abs(mean_colour(frames[t], ignored) / first - 1);
  }
  return out;
}

}  // namespace pliant
