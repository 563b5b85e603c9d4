// ONNX files that do not fit the slot they are given to are refused by what they say about themselves.

#include <gtest/gtest.h>

#include "segmentation/models/lama.h"
#include "segmentation/models/make_models.h"
#include "segmentation/models/ram.h"
#include "segmentation/models/sam.h"
#include "tests/segmentation/models/made_yolox.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

/// Gives its last input as each of `outputs`; every tensor is [1,3,64,64] unless `shape` is given.
std::string made(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                 const std::string& description = "", const std::vector<int64_t>& shape = {1, 3, 64, 64}) {
  OnnxWriter onnx;
  for (const std::string& name : inputs) onnx.input(name, shape);
  for (const std::string& name : outputs) {
    onnx.output(name, shape);
    onnx.node("Identity", {inputs.back()}, {name});
  }
  return onnx.bytes(description);
}

const std::vector<std::string> kOutlineOfYolox = {"images [1,3,32,32]", "output [1,21,7]", "YOLOX", "--detector"};

std::vector<std::string> with_outline(std::vector<std::string> words) {
  words.insert(words.end(), kOutlineOfYolox.begin(), kOutlineOfYolox.end());
  return words;
}

}  // namespace

TEST(OnnxSlots, ADetectorInAnotherSlotIsSentToItsOwnWithTheBrokenLine) {
  TemporaryFolder folder;
  const std::string file = folder.file("net.onnx", made_yolox());
  ModelChoice choice;
  choice.tagger = choice.segmenter = choice.tracker = choice.inpainter = file;
  expect_error(Failure::kInput, with_outline({"net.onnx", "no input 'image'", "image: float32 [1,3,S,S]"}),
               [&] { make_tagger(choice); });
  expect_error(Failure::kInput, with_outline({"an output 'output' of other dimensions", "float32 [1,256,h,w]"}),
               [&] { make_segmenter(choice); });
  expect_error(Failure::kUsage, with_outline({"--tracker", "encode_key", "frame"}), [&] { make_tracker(choice); });
  expect_error(Failure::kInput, with_outline({"no input 'image'", "image: float32 [1,3,h,w]"}),
               [&] { make_inpainter(choice); });
}

TEST(OnnxSlots, ATrackerInOnnxIsRefusedForItsMethods) {
  TemporaryFolder folder;
  ModelChoice choice;
  choice.tracker = folder.file("net.onnx", made({"frame"}, {"key"}));
  expect_error(Failure::kUsage,
               {"--tracker", "net.onnx", "encode_value", "segment", "takes frame [1,3,64,64]", "export_xmem.py"},
               [&] { make_tracker(choice); });
  NeuralModule module(choice.tracker, {});
  Contract contract{
      "encode_key", {{"frame", Tensor::Type::kFloat32, "1,3,h,w"}}, {{"key", Tensor::Type::kFloat32, "1,3,h,w"}}};
  expect_error(Failure::kInput, {"net.onnx", "no method 'encode_key'"}, [&] {
    module.verify(contract, {{"h", 64}, {"w", 64}});
  });
}

TEST(OnnxSlots, AnInputOfTheContractThatIsNotThereIsNamed) {
  TemporaryFolder folder;
  ModelChoice choice;
  choice.inpainter = folder.file("net.onnx", made({"image"}, {"inpainted"}));
  expect_error(Failure::kInput, {"net.onnx", "no input 'mask'", "mask: float32 [1,1,h,w]", "takes image [1,3,64,64]"},
               [&] { make_inpainter(choice); });
}

TEST(OnnxSlots, AnInputThatTheContractDoesNotHaveIsNamed) {
  TemporaryFolder folder;
  NeuralModule module(folder.file("net.onnx", made({"image", "depth"}, {"logits"})), {});
  Contract contract{
      "forward", {{"image", Tensor::Type::kFloat32, "1,3,h,w"}}, {{"logits", Tensor::Type::kFloat32, "1,3,h,w"}}};
  expect_error(Failure::kInput, {"expects the input 'depth'"}, [&] {
    module.verify(contract, {{"h", 64}, {"w", 64}});
  });
}

TEST(OnnxSlots, AnOutputThatIsNotThereAndAnInputOfAnotherLengthAreNamed) {
  TemporaryFolder folder;
  NeuralModule module(folder.file("net.onnx", made({"image"}, {"logits"})), {});
  Contract contract{
      "forward", {{"image", Tensor::Type::kFloat32, "1,3,S,S"}}, {{"logits", Tensor::Type::kFloat32, "1,3,S,S"}}};
  EXPECT_EQ(module.verify(contract, {{"S", 64}})[0].shape, (std::vector<int64_t>{1, 3, 64, 64}));
  expect_error(Failure::kInput,
               {"an input 'image' of other dimensions", "[1,3,S,S], finite, S = 48", "image [1,3,64,64]"}, [&] {
                 module.verify(contract, {{"S", 48}});
               });
  contract.outputs.push_back({"boxes", Tensor::Type::kFloat32, "1,4"});
  expect_error(Failure::kInput, {"no output 'boxes'", "boxes: float32 [1,4]", "gives logits"}, [&] {
    module.verify(contract, {{"S", 64}});
  });
}

TEST(OnnxSlots, AnEncoderAloneIsNoSegmenterAndAFolderNoNetwork) {
  TemporaryFolder folder;
  OnnxWriter onnx;
  onnx.input("image", {1, 3, 64, 64});
  onnx.output("embeddings", {1, 256, 64, 64});
  onnx.weights("kernel", {256, 3, 1, 1}, std::vector<float>(256 * 3, 1.f));
  onnx.node("Conv", {"image", "kernel"}, {"embeddings"}, {{"kernel_shape", {1, 1}}});
  ModelChoice choice;
  choice.segmenter = folder.file("encoder.onnx", onnx.bytes());
  expect_error(Failure::kUsage, {"--segmenter", "ENCODER,DECODER"}, [&] { make_segmenter(choice); });
  choice.segmenter =
      folder.file("decoder.onnx", made({"image_embeddings", "point_coords"}, {"iou_predictions", "low_res_masks"}));
  expect_error(Failure::kInput, {"decoder.onnx", "no input 'image'", "takes image_embeddings"},
               [&] { make_segmenter(choice); });
  choice.segmenter = folder.path();
  expect_error(Failure::kUsage, {"--segmenter", "is not a file"}, [&] { make_segmenter(choice); });
}

TEST(MemoryShare, ManyNetworksTogetherTakeNoMoreThanOneAlone) {
  for (int networks = 1; networks <= 6; ++networks)
    EXPECT_LE(memory_share(networks), memory_share(1) / networks) << networks;
  EXPECT_GE(memory_share(6), memory_share(1) / 6 - 1);
  ModelChoice choice;
  EXPECT_EQ(choice.networks(), 0);
  choice.detector = choice.tracker = "net";
  choice.segmenter = "encoder,decoder";
  EXPECT_EQ(choice.networks(), 4);
  choice.segmenter = "both";
  choice.vocabularies = {"words"};
  EXPECT_EQ(choice.networks(), 3);
}
