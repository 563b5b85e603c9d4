#include "segmentation/models/neural_module.h"

#include <gtest/gtest.h>

#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/models/worker_process.h"
#include "tests/segmentation/models/made_yolox.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

/// y = scale x + offset, [1,2,2].
std::string line_network(float scale, float offset, const std::string& operation = "Add") {
  OnnxWriter onnx;
  onnx.input("x", {1, 2, 2});
  onnx.output("y", {1, 2, 2});
  onnx.weights("scale", {1, 2, 2}, std::vector<float>(4, scale));
  onnx.weights("offset", {1, 2, 2}, std::vector<float>(4, offset));
  onnx.node("Mul", {"x", "scale"}, {"scaled"});
  onnx.node(operation, {"scaled", "offset"}, {"y"});
  return onnx.bytes();
}

Contract line_contract(const std::string& out_shape, double high = 1e30) {
  Contract contract;
  contract.inputs = {{"x", Tensor::Type::kFloat32, "1,2,n"}};
  contract.outputs = {{"y", Tensor::Type::kFloat32, out_shape, -1e30, high}};
  return contract;
}

}  // namespace

TEST(NeuralModule, AnOnnxFileComputesWhatItSays) {
  TemporaryFolder folder;
  NeuralModule module(folder.file("line.onnx", line_network(3, -1)), {});
  const Contract contract = line_contract("1,2,n");
  module.verify(contract, {{"n", 2}});
  const Tensor y = module.run(contract, {Tensor::floats({1, 2, 2}, {0, 1, 2, 10})})[0];
  EXPECT_EQ(y.values, (std::vector<float>{-1, 2, 5, 29}));
}

TEST(NeuralModule, AnotherShapeIsRefusedWithTheLineAndWhatWasFound) {
  TemporaryFolder folder;
  NeuralModule module(folder.file("line.onnx", line_network(1, 0)), {});
  expect_error(Failure::kInput, {"line.onnx", "output 'y'", "is float32 [1,2,2]", "y: float32 [1,n+1,2]"}, [&] {
    module.verify(line_contract("1,n+1,2"), {{"n", 2}});
  });
}

TEST(NeuralModule, NotANumberIsRefused) {
  TemporaryFolder folder;
  NeuralModule module(folder.file("line.onnx", line_network(NAN, 0)), {});
  expect_error(Failure::kInput, {"4 values out of range", "nan"}, [&] {
    module.verify(line_contract("1,2,n"), {{"n", 2}});
  });
}

TEST(NeuralModule, ValuesOutOfTheRangeOfTheContractAreRefused) {
  TemporaryFolder folder;
  NeuralModule module(folder.file("line.onnx", line_network(0, 5)), {});
  expect_error(Failure::kInput, {"4 values out of range, the first is 5"}, [&] {
    module.verify(line_contract("1,2,n", 4), {{"n", 2}});
  });
}

TEST(NeuralModule, AnUnknownOperatorIsNamed) {
  TemporaryFolder folder;
  const auto file = folder.file("line.onnx", line_network(1, 0, "FoldSpacetime"));
  expect_error(Failure::kInput, {"line.onnx", "FoldSpacetime"}, [&] { NeuralModule module(file, {}); });
}

TEST(NeuralModule, AFileCutOffAnywhereIsAnError) {
  TemporaryFolder folder;
  const std::string whole = made_yolox();
  for (size_t length = 1; length < whole.size(); length += whole.size() / 40) {
    const auto file = folder.file("cut.onnx", whole.substr(0, length));
    EXPECT_THROW(read_model_file(file), Error) << length;
  }
}

TEST(NeuralModule, FilesThatAreNoNetworkSayWhatTheyAre) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"cannot be read"}, [&] { read_model_file(folder / "absent.onnx"); });
  for (const std::string& bytes : {std::string(1000, '\0'), std::string(1000, '\xff')})
    expect_error(Failure::kInput, {"not ONNX"}, [&] { read_model_file(folder.file("garbage", bytes)); });
  write_image(folder / "picture.png", ImageF(4, 3, 3));
  write_image(folder / "picture.jpg", ImageF(4, 3, 3));
  const auto refused = [&](const std::string& name, const std::string& bytes, const std::string& kind) {
    if (!bytes.empty()) folder.file(name, bytes);
    expect_error(Failure::kInput, {name, "is " + kind + ", not a network", "give an ONNX or TorchScript file"},
                 [&] { read_model_file(folder / name); });
  };
  for (const char* name : {"sam.onnx", "sam.pt"}) {
    refused(name, read_text(folder / "picture.png"), "a PNG image");
    refused(name, read_text(folder / "picture.jpg"), "a JPEG image");
    refused(name, "weights: see the release page\n", "a text");
    refused(name, "{\"kind\": \"sam\"}\n", "a text file (JSON)");
    refused(name, "  <!DOCTYPE HTML><html><title>404</title>", "a web page");
    refused(name, "version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 3\n",
            "a Git LFS pointer, whose file has not been downloaded");
    refused(name, std::string("\x0a\0\0\0\0\0\0\0{\"a\":\"b\" }", 18),
            "a safetensors file: weights without the network");
    refused(name, std::string("\x80\x02\x8a\x0al\xfc", 6),
            "a Python pickle, as written by old versions of torch.save: weights without the network");
  }
  folder.file("empty.onnx", "");
  refused("empty.onnx", "", "an empty file");
}

TEST(NeuralModule, AWorkerThatEndsIsAnErrorAndNotTheEndOfThisProgram) {
  WorkerProcess worker("/bin/false");
  try {
    worker.ask({}, 10, 1000);
    ADD_FAILURE() << "no error was raised";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("exit code 1"), std::string::npos) << error.what();
  }
}

TEST(NeuralModule, AWorkerThatIsNotThereIsAnError) {
  expect_error(Failure::kInput, {"/nowhere/worker"}, [] { WorkerProcess worker("/nowhere/worker"); });
}

TEST(Contract, LettersStandForOneLengthEverywhere) {
  Lengths lengths;
  EXPECT_EQ(breach_of_shape({"f", Tensor::Type::kFloat32, "1,4h,K+1,*"}, Tensor::floats({1, 8, 3, 9}), lengths), "");
  EXPECT_EQ(lengths, (Lengths{{"h", 2}, {"K", 2}}));
  EXPECT_NE(breach_of_shape({"g", Tensor::Type::kFloat32, "h,K"}, Tensor::floats({2, 3}), lengths), "");
  EXPECT_NE(breach_of_shape({"g", Tensor::Type::kInt64, "h,K"}, Tensor::floats({2, 2}), lengths), "");
  EXPECT_NE(breach_of_shape({"g", Tensor::Type::kFloat32, "4w"}, Tensor::floats({6}), lengths), "");
}

TEST(Contract, ExampleInputsCoverTheirRange) {
  Contract contract;
  contract.inputs = {{"image", Tensor::Type::kFloat32, "1,3,8h,w", 0, 255},
                     {"words", Tensor::Type::kInt64, "1,T", 0, 99}};
  const std::vector<Tensor> inputs = example_inputs(contract, {{"h", 4}, {"w", 16}, {"T", 50}});
  EXPECT_EQ(inputs[0].shape, (std::vector<int64_t>{1, 3, 32, 16}));
  const auto [low, high] = std::minmax_element(inputs[0].values.begin(), inputs[0].values.end());
  EXPECT_GE(*low, 0);
  EXPECT_LT(*low, 10);
  EXPECT_LE(*high, 255);
  EXPECT_GT(*high, 245);
  EXPECT_EQ(breach_of_range(contract.inputs[1], inputs[1]), "");
}
