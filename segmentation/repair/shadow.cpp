#include "segmentation/repair/shadow.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "segmentation/repair/exemplar.h"

namespace pliant {
namespace {

constexpr float kLeastGain = 0.2f;

float log_light(float value) { return std::log(std::max(value, 0.02f)); }
float luminance(const float* c) { return 0.299f * c[0] + 0.587f * c[1] + 0.114f * c[2]; }

/// The largest connected part of the target: where the object stood.  Others are slits at the surface's far edges.
ImageU8 footprint_of(const PlanePicture& picture) {
  ImageU8 footprint = picture.target;
  cv::Mat mask(footprint.height, footprint.width, CV_8U, footprint.data.data()), part, stats, centres;
  const int parts = cv::connectedComponentsWithStats(mask, part, stats, centres, 8);
  int largest = 0;
  for (int k = 1; k < parts; ++k)
    if (largest == 0 || stats.at<int>(k, cv::CC_STAT_AREA) > stats.at<int>(largest, cv::CC_STAT_AREA)) largest = k;
  for (int y = 0; y < part.rows; ++y)
    for (int x = 0; x < part.cols; ++x) footprint(x, y) = largest > 0 && part.at<int>(y, x) == largest;
  return footprint;
}

/// Places of a picture relative to the footprint.
struct Layout {
  int width, height;
  ImageU8 footprint;  ///< 1 = where the object stood
  cv::Mat distance;   ///< to the footprint [texels]
  float radius = 0;   ///< of a disc of the footprint's area [texels]
  float reach = 0;    ///< [texels]
  float blur = 0;     ///< standard deviation of the smoothing [texels]
  ImageU8 reference;  ///< 1 = known and out of reach
};
Layout lay_out(const ShadowOptions& options, const PlanePicture& picture) {
  Layout layout{picture.target.width, picture.target.height, footprint_of(picture), {}, 0, 0, 0, picture.known};
  cv::Mat outside(layout.height, layout.width, CV_8U);
  size_t area = 0;
  for (size_t i = 0; i < layout.footprint.data.size(); ++i) {
    outside.data[i] = !layout.footprint.data[i];
    area += layout.footprint.data[i];
  }
  cv::distanceTransform(outside, layout.distance, cv::DIST_L2, 5);
  layout.radius = std::sqrt(static_cast<float>(area) / static_cast<float>(M_PI));
  layout.reach = options.reach * layout.radius;
  layout.blur = std::max(1.5f, 0.08f * layout.radius);
  for (int y = 0; y < layout.height; ++y)
    for (int x = 0; x < layout.width; ++x) layout.reference(x, y) &= layout.distance.at<float>(y, x) > layout.reach;
  return layout;
}

/// Log ratio of every known texel to places of equal texture out of reach, per channel and (last) luminance, smoothed.
/// `valid` = share of texels around that have one.
struct Light {
  cv::Mat ratio[4], valid;
};

/// Patches around two texels that differ by a factor.
struct Match {
  float residual = INFINITY;  ///< variance of the log ratio
  int dx = 0, dy = 0;         ///< from one to the other
};

/// Log ratios of a texel's patch to patches at repeated offsets.  Textures repeat only nearly, so that every patch is
/// shifted by a texel to where its log ratio is most constant: a seam is compared with a seam.
class PatchLight {
 public:
  PatchLight(const PlanePicture& picture, const Layout& layout, std::vector<Offset> offsets)
      : known_(picture.known),
        reference_(layout.reference),
        offsets_(std::move(offsets)),
        log_(layout.width, layout.height, 4) {
    for (int y = 0; y < layout.height; ++y)
      for (int x = 0; x < layout.width; ++x) {
        const float* c = picture.color.at(x, y);
        for (int k = 0; k < 3; ++k) log_(x, y, k) = log_light(c[k]);
        log_(x, y, 3) = log_light(luminance(c));
      }
  }

  /// False when fewer than two places can be compared with (x, y).
  bool measure(int x, int y, float* ratio) const {
    std::vector<Match> matches;
    for (size_t k = 0; k < offsets_.size() && matches.size() < kMatches; ++k)
      for (const int sign : {1, -1}) {
        const Offset& o = offsets_[k];
        Match best;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) {
            const Match m = match(x, y, sign * o.x + i, sign * o.y + j);
            if (m.residual < best.residual) best = m;
          }
        if (std::isfinite(best.residual)) matches.push_back(best);
      }
    if (matches.size() < 2) return false;
    // The better half speaks, and all that are as good.
    std::stable_sort(matches.begin(), matches.end(),
                     [](const Match& a, const Match& b) { return a.residual < b.residual; });
    const float most = std::max(matches[(matches.size() - 1) / 2].residual, kGood);
    while (matches.back().residual > most) matches.pop_back();
    for (int k = 0; k < 4; ++k) {
      std::vector<float> values;
      for (const Match& m : matches) values.push_back(mean(x, y, m, k));
      ratio[k] = quantile(values, 0.5);
    }
    return true;
  }

 private:
  static constexpr int kRadius = 2, kEnough = (2 * kRadius + 1) * (2 * kRadius + 1) / 2;
  static constexpr size_t kMatches = 10;  ///< places that a texel is compared with
  static constexpr float kGood = 0.01f;   ///< variance of the log ratio below which patches are alike

  template <class Visit>
  void each(int x, int y, int dx, int dy, Visit visit) const {
    for (int v = std::max({y - kRadius, 0, -dy}); v <= std::min({y + kRadius, log_.height - 1, log_.height - 1 - dy});
         ++v)
      for (int u = std::max({x - kRadius, 0, -dx}); u <= std::min({x + kRadius, log_.width - 1, log_.width - 1 - dx});
           ++u)
        if (known_(u, v) && reference_(u + dx, v + dy)) visit(log_.at(u, v), log_.at(u + dx, v + dy));
  }
  Match match(int x, int y, int dx, int dy) const {
    if (x + dx < 0 || y + dy < 0 || x + dx >= log_.width || y + dy >= log_.height || !reference_(x + dx, y + dy))
      return {};
    float sum = 0, square = 0;
    int n = 0;
    each(x, y, dx, dy, [&](const float* here, const float* there) {
      const float d = here[3] - there[3];
      sum += d;
      square += d * d;
      ++n;
    });
    if (n < kEnough) return {};
    const float count = static_cast<float>(n);
    return {std::max(0.0f, (square - sum * sum / count) / count), dx, dy};
  }
  float mean(int x, int y, const Match& m, int k) const {
    float sum = 0, n = 0;
    each(x, y, m.dx, m.dy, [&](const float* here, const float* there) {
      sum += here[k] - there[k];
      ++n;
    });
    return sum / n;
  }

  const ImageU8 &known_, &reference_;
  std::vector<Offset> offsets_;
  ImageF log_;
};

Light measure_light(const ShadowOptions& options, const PlanePicture& picture, const Layout& layout) {
  Light light;
  light.valid = cv::Mat::zeros(layout.height, layout.width, CV_32F);
  for (cv::Mat& ratio : light.ratio) ratio = cv::Mat::zeros(layout.height, layout.width, CV_32F);
  const PatchLight patches(picture, layout,
                           repeated_offsets(picture.color, layout.reference, layout.reference, options.offsets));
  parallel_for(
      layout.height,
      [&](std::ptrdiff_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < layout.width; ++x) {
          float ratio[4];
          if (!picture.known(x, y) || !patches.measure(x, y, ratio)) continue;
          for (int k = 0; k < 4; ++k) light.ratio[k].at<float>(y, x) = ratio[k];
          light.valid.at<float>(y, x) = 1;
        }
      },
      4);
  cv::Mat weight;
  cv::GaussianBlur(light.valid, weight, {}, layout.blur);
  for (cv::Mat& ratio : light.ratio) {
    cv::GaussianBlur(ratio, ratio, {}, layout.blur);
    cv::divide(ratio, cv::max(weight, 1e-3), ratio);
  }
  light.valid = weight;
  return light;
}

/// Takes a + b x + c y, fitted out of reach, from the light; returns the robust spread of what is left there.
float remove_trend(const Layout& layout, const cv::Mat& valid, cv::Mat& ratio) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity() * 1e-9;
  Vec3d b = Vec3d::Zero();
  auto row = [&](int x, int y) {
    return Vec3d(1, static_cast<double>(x) / layout.width, static_cast<double>(y) / layout.height);
  };
  auto used = [&](int x, int y) { return layout.reference(x, y) && valid.at<float>(y, x) > 0.5f; };
  for (int y = 0; y < layout.height; ++y)
    for (int x = 0; x < layout.width; ++x)
      if (used(x, y)) {
        A += row(x, y) * row(x, y).transpose();
        b += row(x, y) * ratio.at<float>(y, x);
      }
  const Vec3d trend = solve_symmetric(A, b);
  std::vector<float> left;
  for (int y = 0; y < layout.height; ++y)
    for (int x = 0; x < layout.width; ++x) {
      ratio.at<float>(y, x) -= static_cast<float>(trend.dot(row(x, y)));
      if (used(x, y)) left.push_back(std::abs(ratio.at<float>(y, x)));
    }
  return left.empty() ? INFINITY : 1.4826f * quantile(left, 0.5);
}

/// The part of `dark` that touches the footprint: 1 in it and in the footprint.
cv::Mat around_footprint(const ImageU8& footprint, const cv::Mat& dark) {
  cv::Mat both = dark.clone(), part;
  for (size_t i = 0; i < footprint.data.size(); ++i) both.data[i] |= footprint.data[i];
  // The rim of the footprint is not known well enough to be dark or not.
  cv::Mat target(both.rows, both.cols, CV_8U, const_cast<uint8_t*>(footprint.data.data())), grown;
  cv::dilate(target, grown, cv::Mat::ones(5, 5, CV_8U));
  both |= grown;
  const int parts = cv::connectedComponents(both, part, 8);
  std::vector<uint8_t> keep(parts, 0);
  for (int y = 0; y < both.rows; ++y)
    for (int x = 0; x < both.cols; ++x)
      if (grown.at<uint8_t>(y, x)) keep[part.at<int>(y, x)] = 1;
  for (int y = 0; y < both.rows; ++y)
    for (int x = 0; x < both.cols; ++x) both.at<uint8_t>(y, x) = both.at<uint8_t>(y, x) && keep[part.at<int>(y, x)];
  return both;
}

}  // namespace

float Shadow::gain_at(const Vec3f& x) const {
  if (gain.empty()) return 1;
  const Vec2f at = picture.coordinates(x) - Vec2f(0.5f, 0.5f);
  const int i = static_cast<int>(std::floor(at[0])), j = static_cast<int>(std::floor(at[1]));
  if (i < 0 || j < 0 || i + 1 >= gain.width || j + 1 >= gain.height) return 1;
  const float a = at[0] - static_cast<float>(i), b = at[1] - static_cast<float>(j);
  return (1 - b) * ((1 - a) * gain(i, j) + a * gain(i + 1, j)) +
         b * ((1 - a) * gain(i, j + 1) + a * gain(i + 1, j + 1));
}

Shadow find_shadow(const ShadowOptions& options, const PlanePicture& picture) {
  Shadow shadow;
  if (picture.empty()) return shadow;
  shadow.picture = picture;
  const Layout layout = lay_out(options, picture);
  if (layout.radius < 3) return shadow;
  Light light = measure_light(options, picture, layout);
  float spread = 0;
  for (int k = 0; k < 4; ++k) spread = remove_trend(layout, light.valid, light.ratio[k]);
  const cv::Mat& ratio = light.ratio[3];

  // Dark at the rim, and from there on while it is darker than the light varies elsewhere.
  const float threshold = std::max(options.min_darkening, 4 * spread),
              low = std::max(0.25f * options.min_darkening, spread);
  cv::Mat dark = cv::Mat::zeros(layout.height, layout.width, CV_8U);
  size_t rim = 0, dark_rim = 0;
  for (int y = 0; y < layout.height; ++y)
    for (int x = 0; x < layout.width; ++x) {
      const float d = layout.distance.at<float>(y, x);
      if (d == 0 || d > layout.reach || light.valid.at<float>(y, x) < 0.1f) continue;
      dark.at<uint8_t>(y, x) = ratio.at<float>(y, x) < -low;
      if (d > 2 * layout.blur + 3) continue;
      ++rim;
      dark_rim += ratio.at<float>(y, x) < -threshold;
    }
  if (rim == 0 || static_cast<float>(dark_rim) < options.min_rim * static_cast<float>(rim)) return shadow;
  const cv::Mat region = around_footprint(layout.footprint, dark);

  // Size, hue and where it ends.
  double sum[4] = {0, 0, 0, 0};
  size_t count = 0, deep_end = 0;
  shadow.gain = ImageF(layout.width, layout.height, 1, 1.0f);
  for (int y = 0; y < layout.height; ++y)
    for (int x = 0; x < layout.width; ++x) {
      const float d = layout.distance.at<float>(y, x);
      if (!region.at<uint8_t>(y, x) || light.valid.at<float>(y, x) < 0.1f) continue;
      shadow.gain(x, y) = std::clamp(std::exp(ratio.at<float>(y, x)), kLeastGain, 1.0f);
      if (d == 0) continue;
      ++count;
      deep_end += d > 0.9f * layout.reach && ratio.at<float>(y, x) < -threshold;
      for (int k = 0; k < 4; ++k) sum[k] += light.ratio[k].at<float>(y, x);
      shadow.darkest = std::min(shadow.darkest, shadow.gain(x, y));
    }
  shadow.area = static_cast<float>(count) * picture.texel * picture.texel;
  shadow.verdict = Shadow::Verdict::kPlain;
  for (int k = 0; k < 3; ++k)
    if (std::abs(sum[k] - sum[3]) > options.max_tint * std::abs(sum[3])) {
      shadow.verdict = Shadow::Verdict::kDoubtful;
      shadow.doubt = "its hue differs";
    }
  if (static_cast<double>(deep_end) > 0.02 * static_cast<double>(count)) {
    shadow.verdict = Shadow::Verdict::kDoubtful;
    shadow.doubt = "it extends farther than a contact shadow";
  }
  // Steps of the region's border are smoothed away.
  cv::Mat gain(layout.height, layout.width, CV_32F, shadow.gain.data.data()), soft;
  cv::GaussianBlur(gain, soft, {}, 0.5 * layout.blur);
  for (int y = 0; y < layout.height; ++y)
    for (int x = 0; x < layout.width; ++x)
      if (layout.distance.at<float>(y, x) > 2 * layout.blur) gain.at<float>(y, x) = soft.at<float>(y, x);
  return shadow;
}

size_t lift_shadow(const Shadow& shadow, GaussianCloud& background) {
  if (shadow.gain.empty()) return 0;
  size_t changed = 0;
  const int coefficients = background.sh_count();
  for (int p : shadow.picture.members) {
    const float gain = shadow.gain_at(background.position[p]);
    if (gain > 0.999f) continue;
    float* sh = background.sh_of(p);
    // Colour = 1/2 + sum of the harmonics, so the half is scaled too.
    for (int i = 0; i < 3 * coefficients; ++i) sh[i] /= gain;
    for (int k = 0; k < 3; ++k) sh[k] += 0.5f * (1 / gain - 1) / kSh0;
    ++changed;
  }
  return changed;
}

}  // namespace pliant
