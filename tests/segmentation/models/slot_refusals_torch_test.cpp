// Networks with a wrong shape or with numbers that are none are refused when they are made, in every slot, by the
// broken line of the contract (LaMa and RAM: lama_torch_test.cpp, ram_torch_test.cpp).

#include <gtest/gtest.h>

#include "segmentation/models/grounding_dino.h"
#include "segmentation/models/sam.h"
#include "segmentation/models/xmem.h"
#include "segmentation/models/yolox.h"
#include "tests/segmentation/models/made_yolox.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

std::unique_ptr<NeuralModule> module_of(const TemporaryFolder& folder, const std::string& methods,
                                        const std::string& description) {
  write_torch_module(folder / "net.pt", methods, description);
  return std::make_unique<NeuralModule>(folder / "net.pt", trusted());
}

void expect_sam_refused(const std::string& embeddings, const std::string& masks,
                        const std::vector<std::string>& words) {
  TemporaryFolder folder;
  const std::string methods =
      "def encode(self, image):\n    return " + embeddings +
      "\ndef decode(self, image_embeddings, point_coords, point_labels, mask_input, has_mask_input, orig_im_size):\n"
      "    return torch.zeros([1, 4]), " +
      masks + "\n";
  auto module = module_of(folder, methods, R"({"kind": "sam", "size": 64})");
  expect_error(Failure::kInput, words, [&] { Sam(std::move(module), nullptr); });
}

void expect_xmem_refused(const std::string& shrinkage, const std::string& value, const std::string& probabilities,
                         const std::vector<std::string>& words) {
  TemporaryFolder folder;
  const std::string methods =
      "def encode_key(self, frame):\n    f16 = torch.avg_pool2d(frame, [16, 16])\n    return f16, " + shrinkage +
      ", f16, f16, torch.avg_pool2d(frame, [8, 8]), torch.avg_pool2d(frame, [4, 4])\n"
      "def encode_value(self, frame, f16, hidden, masks):\n    return " +
      value +
      ", hidden\n"
      "def segment(self, f16, f8, f4, readout, hidden, last_masks):\n    return hidden, " +
      probabilities + "\n";
  auto module = module_of(folder, methods, R"({"kind": "xmem", "hidden": 2})");
  expect_error(Failure::kInput, words, [&] { Xmem(std::move(module), {}); });
}

void expect_dino_refused(const std::string& logits, const std::string& boxes, const std::vector<std::string>& words) {
  TemporaryFolder folder;
  const std::string methods =
      "def forward(self, image, padding, input_ids, attention_mask, position_ids, token_type_ids, "
      "text_self_attention_masks):\n    return " +
      logits + ", " + boxes + "\n";
  auto module = module_of(folder, methods, R"({"kind": "grounding-dino", "height": 24, "width": 32, "tokens": 10})");
  const WordPiece tokenizer(folder.file("vocab.txt", "[PAD]\n[UNK]\n[CLS]\n[SEP]\n.\nred\n"));
  expect_error(Failure::kInput, words, [&] { GroundingDino(std::move(module), tokenizer, {}); });
}

const std::string kEmbeddings = "torch.zeros([1, 256, 4, 4])", kMasks = "torch.zeros([1, 4, 16, 16])";
const std::string kShrinkage = "f16[:, :1]", kValue = "torch.unsqueeze(torch.avg_pool2d(masks, [16, 16]), 2)";
const std::string kProbabilities = "torch.cat([last_masks[:, :1], last_masks], 1)";
const std::string kLogits = "torch.zeros([1, 3, 10])", kBoxes = "torch.zeros([1, 3, 4])";

}  // namespace

TEST(SlotRefusalsTorch, SamOfAnotherShape) {
  expect_sam_refused("torch.zeros([1, 128, 4, 4])", kMasks,
                     {"net.pt", "'image_embeddings' of encode", "[1,128,4,4]", "[1,256,h,w]"});
  expect_sam_refused(kEmbeddings, "torch.zeros([1, 4, 64, 64])",
                     {"'low_res_masks' of decode", "[1,4,64,64]", "[1,M,16,16]"});
}

TEST(SlotRefusalsTorch, SamThatGivesNoNumbers) {
  expect_sam_refused(kEmbeddings + " + torch.log(torch.mean(image) * 0.0 - 1.0)", kMasks,
                     {"'image_embeddings' of encode", "4096 values out of range", "nan"});
  expect_sam_refused(kEmbeddings, kMasks + " / torch.zeros([1])",
                     {"'low_res_masks' of decode", "1024 values out of range", "nan"});
}

TEST(SlotRefusalsTorch, XmemOfAnotherShape) {
  expect_xmem_refused("f16", kValue, kProbabilities, {"net.pt", "'shrinkage' of encode_key", "[1,3,4,5]", "[1,1,h,w]"});
  expect_xmem_refused(kShrinkage, "masks", kProbabilities, {"'value' of encode_value", "[1,2,64,80]", "[1,K,V,h,w]"});
  expect_xmem_refused(kShrinkage, kValue, "last_masks",
                      {"'probabilities' of segment", "[1,2,64,80]", "[1,K+1,16h,16w]"});
}

TEST(SlotRefusalsTorch, XmemThatGivesNoNumbers) {
  expect_xmem_refused(kShrinkage + " * 0.0 / 0.0", kValue, kProbabilities,
                      {"'shrinkage' of encode_key", "20 values out of range", "nan"});
  expect_xmem_refused(kShrinkage, kValue + " * 0.0 / 0.0", kProbabilities,
                      {"'value' of encode_value", "40 values out of range", "nan"});
  expect_xmem_refused(kShrinkage, kValue, kProbabilities + " * 5.0",
                      {"'probabilities' of segment", "out of range, the first is 1.25", "0..1"});
}

TEST(SlotRefusalsTorch, GroundingDinoOfAnotherShape) {
  expect_dino_refused("torch.zeros([1, 3, 11])", kBoxes, {"net.pt", "'logits'", "[1,3,11]", "[1,Q,T]"});
  expect_dino_refused(kLogits, "torch.zeros([1, 2, 4])", {"'boxes'", "[1,2,4]", "[1,Q,4]"});
}

TEST(SlotRefusalsTorch, GroundingDinoThatGivesNoNumbers) {
  expect_dino_refused(kLogits + " / 0.0", kBoxes, {"'logits'", "30 values out of range", "nan"});
  expect_dino_refused(kLogits, kBoxes + " - 1.0", {"'boxes'", "12 values out of range, the first is -1", "0..1"});
}

TEST(SlotRefusals, YoloxOfAnotherShapeOrWithoutNumbers) {
  TemporaryFolder folder;
  const auto made = [&](int64_t rows, float weight) {  // says 21 rows of 7, gives `rows`
    OnnxWriter onnx;
    onnx.input("images", {1, 3, 32, 32});
    onnx.output("output", {1, 21, 7});
    onnx.weights("kernel", {7 * rows, 3, 32, 32}, std::vector<float>(7 * rows * 3 * 1024, weight));
    onnx.integers("shape", {1, rows, 7});
    onnx.node("Conv", {"images", "kernel"}, {"cells"}, {{"kernel_shape", {32, 32}}, {"strides", {32, 32}}});
    onnx.node("Reshape", {"cells", "shape"}, {"output"});
    return std::make_unique<NeuralModule>(folder.file("net.onnx", onnx.bytes(R"({"names": ["leaf", "sky"]})")),
                                          ModuleOptions());
  };
  const YoloxDetector::Options options;
  EXPECT_NO_THROW(YoloxDetector(made(21, 0), options));
  expect_error(Failure::kInput, {"net.onnx", "'output'", "[1,20,7]", "[1,21,7]"},
               [&] { YoloxDetector(made(20, 0), options); });
  expect_error(Failure::kInput, {"net.onnx", "'output'", "147 values out of range", "nan"},
               [&] { YoloxDetector(made(21, NAN), options); });
}
