// Image losses: closed forms, a direct 11 x 11 reference, derivatives against differences, equal bits for any number of
// threads.

#include "gaussians/render/image_loss.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "gaussians/base/portable.h"
#include "tests/check_adjoint.h"

namespace pliant {
namespace {

using Values = std::vector<double>;
using ImageD = Image<double>;

template <class T>
Image<T> noise(int width, int height, int channels, uint64_t seed, double low = 0, double high = 1) {
  Image<T> image(width, height, channels);
  for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<T>(Random(seed, i).uniform(low, high));
  return image;
}

/// Weights of which some, never the first, are 0.
ImageD weight_with_holes(int width, int height) {
  ImageD weight = noise<double>(width, height, 1, 20, 0.1, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if ((3 * x + 5 * y) % 7 == 3 || (x > 4 && y > 6)) weight(x, y) = 0;
  return weight;
}

// SSIM by the definition, window by window; every = the image goes on with zeros; unknown = windows leave out weight 0.
double direct_ssim(const ImageD& a, const ImageD& b, const ImageD& weight, bool every, bool unknown = false) {
  double sum = 0, total = 0;
  for (int c = 0; c < a.channels; ++c) {
    for (int y = 0; y < a.height; ++y) {
      for (int x = 0; x < a.width; ++x) {
        if (!every && (x < 5 || y < 5 || x + 5 >= a.width || y + 5 >= a.height)) continue;
        if (unknown && weight(x, y) == 0) continue;
        double norm = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
        for (int dy = -5; dy <= 5; ++dy) {
          for (int dx = -5; dx <= 5; ++dx) {
            const double w = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
            const bool inside = x + dx >= 0 && y + dy >= 0 && x + dx < a.width && y + dy < a.height;
            if (unknown && inside && weight(x + dx, y + dy) == 0) continue;
            norm += w;
            if (!inside) continue;
            const double p = a(x + dx, y + dy, c), q = b(x + dx, y + dy, c);
            ma += w * p;
            mb += w * q;
            aa += w * p * p;
            bb += w * q * q;
            ab += w * p * q;
          }
        }
        ma /= norm;
        mb /= norm;
        aa /= norm;
        bb /= norm;
        ab /= norm;
        const double c1 = 0.0001, c2 = 0.0009, w = weight.empty() ? 1 : weight(x, y);
        sum += w * (2 * ma * mb + c1) * (2 * (ab - ma * mb) + c2) /
               ((ma * ma + mb * mb + c1) * (aa - ma * ma + bb - mb * mb + c2));
        total += w;
      }
    }
  }
  return sum / total;
}

TEST(Ssim, AgreesWithTheDefinitionForAllSizesChannelsAndWeights) {
  const int sizes[][3] = {{23, 17, 3}, {4, 7, 3}, {1, 1, 1}, {64, 1, 2}, {1, 20, 3}, {33, 120, 1}, {12, 11, 4}};
  for (const auto& [width, height, channels] : sizes) {
    const ImageD a = noise<double>(width, height, channels, 1), b = noise<double>(width, height, channels, 2);
    const ImageD weight = noise<double>(width, height, 1, 3);
    EXPECT_NEAR(ssim(a, b), direct_ssim(a, b, {}, true), 1e-13);
    EXPECT_NEAR(ssim(a, b, weight), direct_ssim(a, b, weight, true), 1e-13);
    if (width < 11 || height < 11) continue;
    EXPECT_NEAR(ssim(a, b, {}, SsimWindows::kInside), direct_ssim(a, b, {}, false), 1e-13);
    EXPECT_NEAR(ssim(a, b, weight, SsimWindows::kInside), direct_ssim(a, b, weight, false), 1e-13);
  }
}

TEST(Ssim, UnknownPixelsAreInNoWindow) {
  const int sizes[][3] = {{23, 17, 3}, {4, 7, 3}, {64, 1, 2}, {1, 20, 3}, {33, 120, 1}, {12, 12, 4}};
  for (const auto& [width, height, channels] : sizes) {
    const ImageD a = noise<double>(width, height, channels, 1), b = noise<double>(width, height, channels, 2),
                 weight = weight_with_holes(width, height), full = noise<double>(width, height, 1, 3, 0.1, 1);
    EXPECT_NEAR(ssim(a, b, weight, SsimWindows::kEveryPixel, ZeroWeight::kUnknown),
                direct_ssim(a, b, weight, true, true), 1e-12);
    EXPECT_EQ(ssim(a, b, full, SsimWindows::kEveryPixel, ZeroWeight::kUnknown), ssim(a, b, full)) << "without any";
    if (width < 11 || height < 11) continue;
    EXPECT_NEAR(ssim(a, b, weight, SsimWindows::kInside, ZeroWeight::kUnknown), direct_ssim(a, b, weight, false, true),
                1e-12);
  }
}

TEST(ImageLoss, OfUnknownPixelsNothingIsLearned) {
  const ImageF a = noise<float>(30, 61, 3, 21), b = noise<float>(30, 61, 3, 22);
  ImageF spoilt = b, weight(30, 61, 1), adj, adj_spoilt;
  const ImageD holes = weight_with_holes(30, 61);
  std::copy(holes.data.begin(), holes.data.end(), weight.data.begin());
  for (size_t i = 0; i < spoilt.data.size(); ++i)
    if (weight.data[i / 3] == 0) spoilt.data[i] = 7;
  const PhotometricOptions options{.zero_weight = ZeroWeight::kUnknown};
  const PhotometricLoss loss = photometric_loss_adjoint(options, a, b, weight, 1, adj);
  EXPECT_EQ(loss.total, photometric_loss_adjoint(options, a, spoilt, weight, 1, adj_spoilt).total);
  EXPECT_EQ(adj.data, adj_spoilt.data);
  for (size_t i = 0; i < adj.data.size(); ++i) EXPECT_EQ(adj.data[i] == 0, weight.data[i / 3] == 0) << i;
}

TEST(Ssim, OfAnImageWithItselfIsExactlyOne) {
  const ImageF a = noise<float>(70, 61, 3, 4);
  EXPECT_EQ(ssim(a, a), 1.0);
  EXPECT_EQ(ssim(a, a, noise<float>(70, 61, 1, 5)), 1.0);
  ImageF adj_a;
  ssim_adjoint(a, a, {}, SsimWindows::kEveryPixel, 1e6, adj_a);
  for (const float g : adj_a.data) EXPECT_NEAR(g, 0.0f, 0.1f) << "the maximum is stationary";
}

TEST(Ssim, OfConstantImagesIsTheLuminanceTermInsideAndScalesWithTheWindowAtTheBorder) {
  const ImageD a(30, 25, 3, 0.3), b(30, 25, 3, 0.6);
  const double c1 = 1e-4, expected = (2 * 0.3 * 0.6 + c1) / (0.3 * 0.3 + 0.6 * 0.6 + c1);
  EXPECT_NEAR(ssim(a, b, {}, SsimWindows::kInside), expected, 1e-12);
  ImageD middle(30, 25, 1);
  for (int y = 5; y < 20; ++y)
    for (int x = 5; x < 25; ++x) middle(x, y) = 2.5;
  EXPECT_NEAR(ssim(a, b, middle), expected, 1e-12) << "a weight chooses the same windows";
}

TEST(Ssim, InFloatAgreesWithDouble) {
  const ImageF a = noise<float>(200, 90, 3, 6, 0.4, 0.6), b = noise<float>(200, 90, 3, 7, 0.4, 0.6);
  ImageD a_double(200, 90, 3), b_double = a_double, adj_double;
  std::copy(a.data.begin(), a.data.end(), a_double.data.begin());
  std::copy(b.data.begin(), b.data.end(), b_double.data.begin());
  EXPECT_NEAR(ssim(a, b), ssim(a_double, b_double), 2e-6);
  ImageF adj;
  ssim_adjoint(a, b, {}, SsimWindows::kEveryPixel, 1, adj);
  ssim_adjoint(a_double, b_double, {}, SsimWindows::kEveryPixel, 1, adj_double);
  double largest = 0, worst = 0;
  for (size_t i = 0; i < adj.data.size(); ++i) {
    largest = std::max(largest, std::abs(adj_double.data[i]));
    worst = std::max(worst, std::abs(adj_double.data[i] - adj.data[i]));
  }
  EXPECT_LT(worst / largest, 1e-4);
}

TEST(ImageLoss, ShiftOfTheMeanHasKnownL1MseAndPsnr) {
  const ImageD a = noise<double>(31, 14, 3, 8);
  ImageD b = a;
  for (double& value : b.data) value += 0.1;
  EXPECT_NEAR(l1_loss(a, b), 0.1, 1e-14);
  EXPECT_NEAR(mse_loss(a, b), 0.01, 1e-14);
  EXPECT_NEAR(psnr_of_mse(mse_loss(a, b)), 20, 1e-10);
  EXPECT_EQ(psnr_of_mse(mse_loss(a, a)), INFINITY);
  EXPECT_NEAR(photometric_loss({}, a, b).l1, 0.1, 1e-14);
}

TEST(ImageLoss, WeightsLeavePixelsOut) {
  const ImageD a = noise<double>(20, 16, 3, 9);
  ImageD b = a, weight(20, 16, 1, 1.0), adj;
  for (int c = 0; c < 3; ++c) b(3, 4, c) += 0.5;
  weight(3, 4) = 0;
  EXPECT_EQ(l1_loss(a, b, weight), 0);
  EXPECT_EQ(mse_loss(a, b, weight), 0);
  weight(3, 4) = 2;
  EXPECT_NEAR(l1_loss(a, b, weight), 2 * 0.5 / (20 * 16 + 1), 1e-14);
  EXPECT_NEAR(photometric_loss({}, a, b, weight).l1, 2 * 0.5 / (20 * 16 + 1), 1e-14);
  // Nothing counts: no loss, no derivative, no NaN.
  const PhotometricLoss none = photometric_loss_adjoint({}, a, b, ImageD(20, 16, 1), 1, adj);
  EXPECT_EQ(none.total, 0);
  EXPECT_EQ(ssim(a, b, ImageD(20, 16, 1)), 1);
  EXPECT_EQ(adj.data, Values(a.data.size(), 0.0));
}

TEST(ImageLoss, CombinedLossIsTheSumOfItsParts) {
  const ImageD a = noise<double>(40, 33, 3, 10), b = noise<double>(40, 33, 3, 11),
               weight = noise<double>(40, 33, 1, 12);
  const PhotometricOptions options{0.7, 0.4};
  ImageD adj, adj_l1, adj_ssim;
  const PhotometricLoss loss = photometric_loss_adjoint(options, a, b, weight, 3, adj);
  EXPECT_NEAR(loss.l1, l1_loss(a, b, weight), 1e-14);
  EXPECT_NEAR(loss.dssim, 1 - ssim(a, b, weight), 1e-14);
  EXPECT_NEAR(loss.total, 0.7 * loss.l1 + 0.4 * loss.dssim, 1e-14);
  EXPECT_EQ(loss.total, photometric_loss(options, a, b, weight).total);
  l1_loss_adjoint(a, b, weight, 3 * 0.7, adj_l1);
  ssim_adjoint(a, b, weight, SsimWindows::kEveryPixel, -3 * 0.4, adj_ssim);
  for (size_t i = 0; i < adj.data.size(); ++i) EXPECT_NEAR(adj.data[i], adj_l1.data[i] + adj_ssim.data[i], 1e-16);
}

// Every loss as a function of the values of its first image, at a size that exceeds a block of rows in one case.
struct Case {
  const char* name;
  int width, height, channels;
};

class LossAdjoint : public testing::TestWithParam<Case> {};

TEST_P(LossAdjoint, AgreesWithDifferences) {
  const auto [name, width, height, channels] = GetParam();
  const ImageD b = noise<double>(width, height, channels, 13), weight = noise<double>(width, height, 1, 14);
  ImageD start = b;  // at least 0.02 from b, so that no difference changes its sign
  for (size_t i = 0; i < start.data.size(); ++i) {
    Random random(15, i);
    start.data[i] += (random.uniform() < 0.5 ? -1 : 1) * random.uniform(0.02, 0.4);
  }
  const auto image = [&](const Values& x) {
    ImageD a(width, height, channels);
    a.data = x;
    return a;
  };
  AdjointCheckOptions options;
  options.inputs = 150;
  options.step = 0.005;
  const auto check = [&](auto&& f, auto&& adjoint) {
    const AdjointCheck result = check_adjoint([&](const Values& x) { return Values{f(image(x))}; },
                                              [&](const Values& x, const Values& y) {
                                                ImageD adj_a;
                                                adjoint(image(x), y[0], adj_a);
                                                return adj_a.data;
                                              },
                                              start.data, options);
    EXPECT_LT(result.worst, 1e-6) << result.message;
    return result.worst;
  };
  check([&](const ImageD& a) { return l1_loss(a, b, weight); },
        [&](const ImageD& a, double y, ImageD& adj) { l1_loss_adjoint(a, b, weight, y, adj); });
  check([&](const ImageD& a) { return mse_loss(a, b, weight); },
        [&](const ImageD& a, double y, ImageD& adj) { mse_loss_adjoint(a, b, weight, y, adj); });
  double worst =
      check([&](const ImageD& a) { return ssim(a, b); },
            [&](const ImageD& a, double y, ImageD& adj) { ssim_adjoint(a, b, {}, SsimWindows::kEveryPixel, y, adj); });
  worst = std::max(worst, check([&](const ImageD& a) { return photometric_loss({}, a, b, weight).total; },
                                [&](const ImageD& a, double y, ImageD& adj) {
                                  photometric_loss_adjoint({}, a, b, weight, y, adj);
                                }));
  const PhotometricOptions unknown{.zero_weight = ZeroWeight::kUnknown};
  const ImageD holes = weight_with_holes(width, height);
  worst = std::max(worst, check([&](const ImageD& a) { return photometric_loss(unknown, a, b, holes).total; },
                                [&](const ImageD& a, double y, ImageD& adj) {
                                  photometric_loss_adjoint(unknown, a, b, holes, y, adj);
                                }));
  if (width >= 11 && height >= 11) {
    worst = std::max(worst, check([&](const ImageD& a) { return ssim(a, b, weight, SsimWindows::kInside); },
                                  [&](const ImageD& a, double y, ImageD& adj) {
                                    ssim_adjoint(a, b, weight, SsimWindows::kInside, y, adj);
                                  }));
  }
  RecordProperty("worst_relative_error", testing::PrintToString(worst));
}

INSTANTIATE_TEST_SUITE_P(Sizes, LossAdjoint,
                         testing::Values(Case{"SmallerThanTheWindow", 6, 4, 3}, Case{"OnePixel", 1, 1, 3},
                                         Case{"OneChannel", 15, 13, 1}, Case{"TwoBlocks", 12, 57, 3},
                                         Case{"FiveChannels", 13, 12, 5}),
                         [](const auto& info) { return info.param.name; });

TEST(ImageLoss, EqualBitForBitForOneToFourThreads) {
  const ImageF a = noise<float>(97, 211, 3, 16), b = noise<float>(97, 211, 3, 17),
               weight = noise<float>(97, 211, 1, 18);
  const int before = omp_get_max_threads();
  ImageF first, adj;
  std::vector<double> values;
  for (int threads = 1; threads <= 4; ++threads) {
    omp_set_num_threads(threads);
    const PhotometricLoss loss = photometric_loss_adjoint({}, a, b, weight, 1, adj);
    const std::vector<double> now = {loss.l1, loss.dssim, ssim(a, b), l1_loss(a, b, weight), mse_loss(a, b, weight)};
    if (threads == 1) {
      values = now;
      first = adj;
    }
    EXPECT_EQ(now, values) << threads;
    EXPECT_EQ(adj.data, first.data) << threads;
  }
  omp_set_num_threads(before);
}

TEST(ImageLoss, ImagesThatDoNotFitThrow) {
  const ImageF a(12, 12, 3), wider(13, 12, 3), grey(12, 12, 1), small(12, 10, 3);
  EXPECT_THROW(l1_loss(a, wider), std::logic_error);
  EXPECT_THROW(mse_loss(a, grey), std::logic_error);
  EXPECT_THROW(ssim(a, wider), std::logic_error);
  EXPECT_THROW(ssim(a, a, a), std::logic_error);
  EXPECT_THROW(ssim(small, small, {}, SsimWindows::kInside), std::logic_error);
  EXPECT_THROW(photometric_loss<float>({}, ImageF(), ImageF()), std::logic_error);
}

}  // namespace
}  // namespace pliant
