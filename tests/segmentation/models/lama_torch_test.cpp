#include <gtest/gtest.h>

#include "segmentation/models/lama.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

// Fills the hole with the mean colour of what is known, by a discrete Fourier transform as LaMa uses it.
const char* const kMean = R"(
def forward(self, image, mask):
    known = torch.sum(1.0 - mask, [2, 3], True)
    mean = torch.real(torch.fft_fft2(image))[:, :, :1, :1] / known
    return (image * (1.0 - mask) + mean * mask) * self.range
)";

Lama made_inpainter(const TemporaryFolder& folder, const std::string& description, float range,
                    Lama::Options options = {}) {
  write_torch_module(folder / "lama.pt", kMean, description, {{"range", {1}, {range}}});
  return Lama(std::make_unique<NeuralModule>(folder / "lama.pt", trusted()), options);
}

ImageF plain(int width, int height) {
  ImageF picture(width, height, 3, 0.25f);
  for (size_t i = 0; i < picture.data.size(); i += 3) picture.data[i] = 0.75f;
  return picture;
}

ImageU8 hole(int width, int height, int x0, int y0, int x1, int y1) {
  ImageU8 mask(width, height, 1);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) mask(x, y) = 1;
  return mask;
}

/// The picture with the hole painted over must come back as it was, the rest bit for bit.
void expect_mended(Lama& lama, int width, int height, const ImageU8& mask) {
  const ImageF whole = plain(width, height);
  ImageF damaged = whole;
  for (size_t i = 0; i < mask.data.size(); ++i)
    if (mask.data[i]) {
      damaged.data[i * 3] = 0;
      damaged.data[i * 3 + 1] = 1;
    }
  damaged(0, 0, 1) = 0.3f;
  const ImageF mended = lama.inpaint(damaged, mask);
  for (size_t i = 0; i < mask.data.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      if (mask.data[i])
        ASSERT_NEAR(mended.data[i * 3 + c], whole.data[i * 3 + c], 2e-3) << i;
      else
        ASSERT_EQ(mended.data[i * 3 + c], damaged.data[i * 3 + c]) << i;
    }
}

}  // namespace

TEST(LamaTorch, OnlyTheHoleChangesWhateverTheSides) {
  TemporaryFolder folder;
  Lama lama = made_inpainter(folder, R"({"kind": "lama"})", 1);
  expect_mended(lama, 37, 50, hole(37, 50, 10, 12, 20, 40));
  expect_mended(lama, 300, 301, hole(300, 301, 150, 200, 180, 210));
  EXPECT_EQ(lama.inpaint(plain(20, 20), ImageU8(20, 20, 1)).data, plain(20, 20).data);
}

TEST(LamaTorch, AFileOfOneSizeAndOfTheRange255) {
  TemporaryFolder folder;
  Lama lama = made_inpainter(folder, R"({"kind": "lama", "height": 64, "range": 255})", 255);
  expect_mended(lama, 50, 40, hole(50, 40, 10, 12, 20, 30));
}

TEST(LamaTorch, SurroundingsLargerThanATileAreFilledByTiles) {
  TemporaryFolder folder;
  Lama::Options options;
  options.tile = 64;
  options.overlap = 16;
  Lama lama = made_inpainter(folder, R"({"kind": "lama"})", 1, options);
  expect_mended(lama, 200, 150, hole(200, 150, 20, 20, 180, 90));
}

TEST(LamaTorch, ValuesOfAnotherRangeBreakTheContract) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"lama.pt", "out of range", "inpainted: float32 [1,3,h,w]"},
               [&] { made_inpainter(folder, R"({"kind": "lama"})", 255); });
}
