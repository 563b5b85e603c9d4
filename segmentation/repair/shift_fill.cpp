#include "segmentation/repair/shift_fill.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

struct Shift {
  float x = 0, y = 0;
  float error = INFINITY;  ///< mean squared difference around the target
};

/// Known pixels around a target, with every picture and mask that the steps need.
struct Surroundings {
  const ImageF& picture;
  const ImageU8 &known, &target;
  std::vector<Offset> band;  ///< known pixels near the target
  float variance = 0;        ///< of their colour, summed over channels

  bool is_known(int x, int y) const {
    return x >= 0 && y >= 0 && x < picture.width && y < picture.height && known(x, y);
  }
  /// Bilinear colour at (x, y) counted from pixel centres; false unless all four pixels are known.
  bool sample(float x, float y, float* out) const {
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
    const int i1 = a > 0 ? i + 1 : i, j1 = b > 0 ? j + 1 : j;
    if (!is_known(i, j) || !is_known(i1, j) || !is_known(i, j1) || !is_known(i1, j1)) return false;
    for (int k = 0; k < 3; ++k)
      out[k] = (1 - b) * ((1 - a) * picture(i, j, k) + a * picture(i1, j, k)) +
               b * ((1 - a) * picture(i, j1, k) + a * picture(i1, j1, k));
    return true;
  }
};

Surroundings look_around(const ImageF& picture, const ImageU8& known, const ImageU8& target) {
  Surroundings around{picture, known, target, {}, 0};
  cv::Mat outside(picture.height, picture.width, CV_8U), distance;
  size_t area = 0;
  for (size_t i = 0; i < target.data.size(); ++i) {
    outside.data[i] = !target.data[i];
    area += target.data[i];
  }
  cv::distanceTransform(outside, distance, cv::DIST_L2, 5);
  const float width = std::max(6.0f, 0.5f * std::sqrt(static_cast<float>(area) / static_cast<float>(M_PI)));
  double sum[3] = {0, 0, 0}, square = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (!known(x, y) || distance.at<float>(y, x) > width) continue;
      around.band.push_back({x, y});
      for (int k = 0; k < 3; ++k) {
        sum[k] += picture(x, y, k);
        square += picture(x, y, k) * picture(x, y, k);
      }
    }
  const double n = std::max<double>(1, static_cast<double>(around.band.size()));
  around.variance = static_cast<float>((square - (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / n) / n);
  return around;
}

/// Mean squared difference of the band under a translation; infinite when less than 40 % of it lands on known pixels.
/// The mean difference does not count: light varies slowly, and the membrane takes it up.
float error_of(const Surroundings& around, float dx, float dy) {
  const size_t step = std::max<size_t>(1, around.band.size() / 1500);
  size_t tried = 0, met = 0;
  double square = 0, sum[3] = {0, 0, 0};
  for (size_t i = 0; i < around.band.size(); i += step, ++tried) {
    const Offset& at = around.band[i];
    float there[3];
    if (!around.sample(static_cast<float>(at.x) + dx, static_cast<float>(at.y) + dy, there)) continue;
    ++met;
    for (int k = 0; k < 3; ++k) {
      const float d = there[k] - around.picture(at.x, at.y, k);
      square += d * d;
      sum[k] += d;
    }
  }
  if (5 * met < 2 * tried || met == 0) return INFINITY;
  const double n = static_cast<double>(met);
  return static_cast<float>((square - (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / n) / n);
}

/// The lowest error near an integer offset: whole pixels first, then halves, quarters and eighths.
Shift refined(const Surroundings& around, const Offset& start) {
  Shift best{static_cast<float>(start.x), static_cast<float>(start.y), 0};
  best.error = error_of(around, best.x, best.y);
  for (float step = 2; step >= 0.125f; step /= 2)
    for (bool better = true; better;) {
      better = false;
      for (const auto& [sx, sy] : {std::pair{step, 0.0f}, {-step, 0.0f}, {0.0f, step}, {0.0f, -step}}) {
        // Blur by interpolation hides noise, so a fraction must earn its place.
        const float error = error_of(around, best.x + sx, best.y + sy);
        if (error < 0.98f * best.error) {
          best = {best.x + sx, best.y + sy, error};
          better = true;
        }
      }
    }
  return best;
}

/// Adds to the target the harmonic function whose values at the rim are the smoothed differences between the known
/// pixels there and what the translation would have put in their place.
void add_membrane(const Surroundings& around, const ImageU8& label, const std::vector<Shift>& shifts, ImageF& filled) {
  constexpr int kRim = 4;
  const int width = filled.width, height = filled.height;
  cv::Mat target(height, width, CV_8U, const_cast<uint8_t*>(around.target.data.data())), rim;
  cv::dilate(target, rim, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kRim + 3, 2 * kRim + 3}));
  // The label of the nearest target pixel tells which translation a rim pixel is compared under.
  cv::Mat inverse = target == 0, distance, nearest;
  cv::distanceTransform(inverse, distance, nearest, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<uint8_t> label_of(static_cast<size_t>(width) * height + 1, 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (around.target(x, y)) label_of[nearest.at<int>(y, x)] = label(x, y);
  cv::Mat difference = cv::Mat::zeros(height, width, CV_32FC3), weight = cv::Mat::zeros(height, width, CV_32F);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!rim.at<uint8_t>(y, x) || !around.known(x, y)) continue;
      const Shift& s = shifts[label_of[nearest.at<int>(y, x)]];
      float there[3];
      if (!around.sample(static_cast<float>(x) + s.x, static_cast<float>(y) + s.y, there)) continue;
      weight.at<float>(y, x) = 1;
      for (int k = 0; k < 3; ++k) difference.at<cv::Vec3f>(y, x)[k] = around.picture(x, y, k) - there[k];
    }
  cv::GaussianBlur(difference, difference, {}, 2 * kRim);
  cv::GaussianBlur(weight, weight, {}, 2 * kRim);
  // Jacobi iterations over the target; around it the smoothed difference stands.
  cv::Mat value = cv::Mat::zeros(height, width, CV_32FC3);
  std::vector<Offset> inner;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float w = weight.at<float>(y, x);
      if (w > 1e-3f) value.at<cv::Vec3f>(y, x) = difference.at<cv::Vec3f>(y, x) / w;
      if (around.target(x, y)) inner.push_back({x, y});
    }
  const int rounds = std::clamp(static_cast<int>(inner.size()), 50, 800);
  for (int round = 0; round < rounds; ++round) {
    const cv::Mat old = value.clone();
    for (const Offset& at : inner) {
      cv::Vec3f sum(0, 0, 0);
      float n = 0;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int i = at.x + dx, j = at.y + dy;
        if (i >= 0 && j >= 0 && i < width && j < height) {
          sum += old.at<cv::Vec3f>(j, i);
          ++n;
        }
      }
      value.at<cv::Vec3f>(at.y, at.x) = sum / n;
    }
  }
  for (const Offset& at : inner)
    for (int k = 0; k < 3; ++k) filled(at.x, at.y, k) += value.at<cv::Vec3f>(at.y, at.x)[k];
}

}  // namespace

std::optional<ShiftFill> shift_fill(const ShiftOptions& options, const ImageF& picture, const ImageU8& known,
                                    const ImageU8& target) {
  CHECK(picture.channels == 3 && known.pixels() == picture.pixels() && target.pixels() == picture.pixels());
  ImageU8 usable = known;
  for (size_t i = 0; i < known.data.size(); ++i) usable.data[i] = known.data[i] && !target.data[i];
  const Surroundings around = look_around(picture, usable, target);
  if (around.band.size() < 50) return {};
  ImageU8 band(picture.width, picture.height, 1);
  for (const Offset& at : around.band) band(at.x, at.y) = 1;
  std::vector<Shift> shifts;
  for (const Offset& o : repeated_offsets(picture, usable, band, options.offsets)) {
    const Shift s = refined(around, o);
    if (s.error <= options.most_error * around.variance) shifts.push_back(s);
  }
  std::stable_sort(shifts.begin(), shifts.end(), [](const Shift& a, const Shift& b) { return a.error < b.error; });

  ShiftFill fill{picture, target};
  ImageF& filled = fill.picture;
  size_t wanted = 0, reached = 0;
  ImageU8 label(picture.width, picture.height, 1);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (!target(x, y)) continue;
      ++wanted;
      for (size_t s = 0; s < shifts.size() && fill.left(x, y); ++s)
        if (around.sample(static_cast<float>(x) + shifts[s].x, static_cast<float>(y) + shifts[s].y, filled.at(x, y))) {
          label(x, y) = static_cast<uint8_t>(s);
          fill.left(x, y) = 0;
          ++reached;
        }
    }
  if (reached == 0 || static_cast<double>(reached) < options.least_reached * static_cast<double>(wanted)) return {};
  add_membrane(around, label, shifts, filled);
  for (size_t i = 0; i < fill.left.data.size(); ++i)
    if (fill.left.data[i]) std::copy_n(picture.data.data() + 3 * i, 3, filled.data.data() + 3 * i);
  return fill;
}

}  // namespace pliant
