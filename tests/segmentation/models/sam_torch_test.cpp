#include <gtest/gtest.h>

#include "segmentation/models/sam.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

// Embeddings are means over squares of 16 pixels; mask k is their first channel, and every other input adds to it.
const char* const kEncode = R"(
    squares = torch.avg_pool2d(image, [16, 16])
    return squares.repeat([1, 86, 1, 1])[:, :256]
)";
const char* const kDecode = R"(
    shape = [16, 16]
    base = torch.upsample_nearest2d(image_embeddings[:, :1], shape)
    told = torch.sum(torch.sum(point_coords, [2]) * point_labels) * 0.01
    base = base + told + mask_input + has_mask_input + orig_im_size[0] * 0.001 + orig_im_size[1] * 0.0001
    masks = torch.cat([base, base + 1.0, base + 2.0, base + 3.0], 1)
    return self.iou, masks
)";

std::string decode_method(const std::string& name) {
  return "def " + name +
         "(self, image_embeddings, point_coords, point_labels, mask_input, has_mask_input, orig_im_size):" + kDecode;
}

Sam one_file(const TemporaryFolder& folder, const std::string& fit) {
  write_torch_module(folder / "sam.pt", std::string("def encode(self, image):") + kEncode + decode_method("decode"),
                     R"({"kind": "sam", "size": 64, "fit": ")" + fit + "\"}",
                     {{"iou", {1, 4}, {0.5f, 0.7f, 1.9f, 0.8f}}});
  return Sam(std::make_unique<NeuralModule>(folder / "sam.pt", trusted()), nullptr);
}

ImageF halves(int width, int height) {  // red on the left
  ImageF picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width / 2; ++x) picture(x, y, 0) = 1;
  return picture;
}

constexpr float kBright = (1 - 0.485f) / 0.229f, kDark = -0.485f / 0.229f;

}  // namespace

TEST(SamTorch, MasksOfAPointComeInTheOrderOfTheirPredictedOverlap) {
  TemporaryFolder folder;
  Sam sam = one_file(folder, "longest");
  const ImageF picture = halves(128, 64);  // scaled to 64 x 32
  sam.encode(picture);
  const std::vector<SegmentedMask> masks = sam.segment({std::nullopt, {{32, 16, true}}});
  ASSERT_EQ(masks.size(), 4u);
  const float told = 0.01f * (15.5f + 7.5f) + 0.064f + 0.0128f;
  const float steps[] = {2, 3, 1, 0};
  for (int m = 0; m < 4; ++m) {
    ASSERT_EQ(masks[m].logits.width, 128);
    ASSERT_EQ(masks[m].logits.height, 64);
    EXPECT_NEAR(masks[m].logits(8, 8), kBright + told + steps[m], 1e-4) << m;
    EXPECT_NEAR(masks[m].logits(120, 8), kDark + told + steps[m], 1e-4) << m;
    EXPECT_NEAR(masks[m].logits(120, 30), kDark + told + steps[m], 1e-4) << m;
  }
  EXPECT_FLOAT_EQ(masks[0].predicted_iou, 1);
  EXPECT_FLOAT_EQ(masks[1].predicted_iou, 0.8f);
}

TEST(SamTorch, ABoxHasOneMeaningAndItsCornersCount) {
  TemporaryFolder folder;
  Sam sam = one_file(folder, "longest");
  sam.encode(halves(128, 64));
  const std::vector<SegmentedMask> masks = sam.segment({MaskPrompt::Box{0, 0, 64, 64}, {}});
  EXPECT_FLOAT_EQ(masks[0].predicted_iou, 0.5f);
  EXPECT_NEAR(masks[0].logits(8, 8), kBright + 0.01f * (2 * -1.f + 3 * 63.f) + 0.064f + 0.0128f, 1e-4);
}

TEST(SamTorch, ASquareFitScalesBothSides) {
  TemporaryFolder folder;
  Sam sam = one_file(folder, "square");
  sam.encode(halves(128, 32));
  const std::vector<SegmentedMask> masks = sam.segment({std::nullopt, {{64, 16, true}}});
  const float told = 0.01f * (31.5f + 31.5f) + 0.032f + 0.0128f;
  EXPECT_NEAR(masks[0].logits(8, 30), kBright + told + 2, 1e-4);
  EXPECT_NEAR(masks[0].logits(120, 1), kDark + told + 2, 1e-4);
}

TEST(SamTorch, EncoderAndDecoderMayBeTwoFiles) {
  TemporaryFolder folder;
  write_torch_module(folder / "encoder.pt", std::string("def forward(self, image):") + kEncode, R"({"size": 64})");
  write_torch_module(folder / "decoder.pt", decode_method("forward"), "", {{"iou", {1, 4}, {0.5f, 0.7f, 0.9f, 0.8f}}});
  Sam sam(std::make_unique<NeuralModule>(folder / "encoder.pt", trusted()),
          std::make_unique<NeuralModule>(folder / "decoder.pt", trusted()));
  sam.encode(halves(64, 64));
  EXPECT_NEAR(sam.segment({std::nullopt, {{32, 32, false}}})[0].logits(4, 4), kBright + 2 + 0.064f + 0.0064f, 1e-4);
  expect_error(Failure::kUsage, {"no box and no point"}, [&] { sam.segment({}); });
  expect_error(Failure::kUsage, {"outside"}, [&] { sam.segment({std::nullopt, {{65, 3, true}}}); });
  expect_error(Failure::kUsage, {"outside"}, [&] { sam.segment({MaskPrompt::Box{70, 0, 80, 20}, {}}); });
}
