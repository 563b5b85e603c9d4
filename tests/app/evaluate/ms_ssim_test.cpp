// MS-SSIM against closed forms.

#include "app/evaluate/ms_ssim.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// Blocks of random grey of every size from 1 to 32 px: contrast at all scales, not far from 1 / 2.
Image<double> blocks(int width, int height, double contrast) {
  Image<double> out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int size = 1, k = 0; size <= 32; size *= 2, ++k) sum += Random(k, x / size, y / size).uniform() - 0.5;
      for (int c = 0; c < 3; ++c) out(x, y, c) = 0.5 + contrast * sum;
    }
  return out;
}

TEST(MsSsim, IsOneOfEqualPicturesAndSymmetric) {
  const Image<double> a = blocks(176, 180, 0.3), b = blocks(176, 180, 0.2);
  EXPECT_NEAR(ms_ssim(a, a), 1, 1e-12);
  EXPECT_NEAR(ms_ssim(a, b), ms_ssim(b, a), 1e-12);
}

TEST(MsSsim, OfContrastTimesKIsTheContrastTermOfAllScales) {
  // Where variances are far above C2 each scale has 2 k / (1 + k^2), and the exponents add up to 1.0001.
  for (const double k : {0.8, 0.5, 0.3})
    EXPECT_NEAR(ms_ssim(blocks(200, 176, 0.5), blocks(200, 176, 0.5 * k)), 2 * k / (1 + k * k), 0.02) << k;
}

TEST(MsSsim, NoiseOfSinglePixelsCountsLittle) {
  // The finest scale has an exponent of 0.0448, and means of 2 x 2 pixels halve the noise from scale to scale.
  const Image<double> a = blocks(192, 192, 0.4);
  Image<double> fine = a, coarse = a;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c) {
        fine(x, y, c) += 0.2 * (Random(50, x, y).uniform() - 0.5);
        coarse(x, y, c) += 0.2 * (Random(51, x / 16, y / 16).uniform() - 0.5);
      }
  EXPECT_GT(ms_ssim(a, fine), ms_ssim(a, coarse) + 0.02);
}

TEST(MsSsim, OfANegativeIsNothing) {
  Image<double> a = blocks(176, 176, 0.4), b = a;
  for (double& v : b.data) v = 1 - v;
  EXPECT_EQ(ms_ssim(a, b), 0);
}

}  // namespace
}  // namespace pliant
