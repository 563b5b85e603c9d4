#include <gtest/gtest.h>

#include "segmentation/models/make_models.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

Contract line_contract() {
  Contract contract;
  contract.inputs = {{"x", Tensor::Type::kFloat32, "1,n"}, {"k", Tensor::Type::kInt64, "1", 0, 5}};
  contract.outputs = {{"y", Tensor::Type::kFloat32, "1,n"}};
  return contract;
}

void expect_refused(const std::string& body, const std::vector<std::string>& words, ModuleOptions options = trusted()) {
  TemporaryFolder folder;
  write_torch_module(folder / "made.pt", "def forward(self, x, k):\n" + body);
  expect_error(Failure::kInput, words, [&] {
    NeuralModule(folder / "made.pt", options).verify(line_contract(), {{"n", 3}});
  });
}

}  // namespace

TEST(TorchModule, TorchScriptComputesWhatItSays) {
  TemporaryFolder folder;
  write_torch_module(folder / "made.pt", "def forward(self, x, k):\n  return x * self.a + k\n", "",
                     {{"a", {1, 2}, {10, 20}}});
  NeuralModule module(folder / "made.pt", trusted());
  const Contract contract = line_contract();
  module.verify(contract, {{"n", 2}});
  const Tensor y = module.run(contract, {Tensor::floats({1, 2}, {1, 2}), Tensor::whole({1}, {3})})[0];
  EXPECT_EQ(y.values, (std::vector<float>{13, 43}));
}

TEST(TorchModule, WithoutTrustItIsRefusedByName) {
  TemporaryFolder folder;
  write_torch_module(folder / "made.pt", "def forward(self, x):\n  return x\n");
  expect_error(Failure::kUsage, {"--detector", "made.pt", "--trust-torchscript"}, [&] {
    ModelChoice choice;
    choice.detector = folder / "made.pt";
    make_detector(choice);
  });
}

TEST(TorchModule, ADescriptionIsReadWithoutRunningAnything) {
  TemporaryFolder folder;
  write_torch_module(folder / "made.pt", "def forward(self, x):\n  return x\n", R"({"kind": "lama", "side": 512})");
  EXPECT_EQ(read_model_file(folder / "made.pt").kind(), "lama");
}

TEST(TorchModule, AnotherTypeOrShapeIsRefused) {
  expect_refused("  return x.to(7)\n", {"is float64 [1,3]", "y: float32 [1,n]"});
  expect_refused("  return x[0]\n", {"is float32 [3]", "y: float32 [1,n]"});
  expect_refused("  return 3\n", {"returns a Int"});
}

TEST(TorchModule, AnotherNumberOfInputsOrMethodsIsRefused) {
  TemporaryFolder folder;
  write_torch_module(folder / "made.pt", "def encode(self, x):\n  return x\n");
  Contract contract = line_contract();
  expect_error(Failure::kInput, {"has no method 'forward'"}, [&] {
    NeuralModule(folder / "made.pt", trusted()).verify(contract, {{"n", 3}});
  });
  contract.method = "encode";
  expect_error(Failure::kInput, {"takes 1 inputs in 'encode'"}, [&] {
    NeuralModule(folder / "made.pt", trusted()).verify(contract, {{"n", 3}});
  });
}

TEST(TorchModule, OneThatNeverReturnsIsStopped) {
  ModuleOptions options = trusted();
  options.load_seconds = 3;
  expect_refused("  while bool(k[0] > -1):\n    x = x + 1\n  return x\n", {"gave no answer within 3.0 s"}, options);
}

TEST(TorchModule, OneThatWantsTooMuchMemoryIsStopped) {
  ModuleOptions options = trusted();
  options.memory = 1ull << 30;
  expect_refused("  y = torch.ones([1, 2500000000])\n  return x + y[:, :3]\n", {"needs more than 1024 MB"}, options);
}

TEST(TorchModule, OneThatCrashesIsAnError) {
  expect_refused(
      "  i = torch.full([1, 1], 1 << 45, dtype=4)\n"
      "  return x + torch._sparse_coo_tensor_unsafe(i, torch.ones([1]), [4]).to_dense()[:3]\n",
      {"signal 11"});
}

TEST(TorchModule, AnErrorInsideTellsItsReason) {
  expect_refused("  return torch.reshape(x, [7])\n", {"shape '[7]' is invalid"});
}

TEST(TorchModule, AllOperatorsThatLibtorchLacksAreNamed) {
  TemporaryFolder folder;
  const auto made = [&](const std::string& name) {
    write_torch_module(folder / name,
                       "def forward(self, x, k):\n  return torch.sin(torch.cos(x)) + torch.roll(x, [1], [0]) + k\n");
    return folder / name;
  };
  const auto load = [](const std::filesystem::path& file) { NeuralModule(file, trusted()); };
  replace_in_code(made("one.pt"), "torch.sin(", "torch.fold_spacetime(");
  expect_error(Failure::kInput, {"one.pt", "needs the operator aten::fold_spacetime, which libtorch"},
               [&] { load(folder / "one.pt"); });
  replace_in_code(made("two.pt"), "torch.sin(", "torch.fold_spacetime(");
  replace_in_code(folder / "two.pt", "torch.cos(", "ops.vision.unfold(");
  expect_error(Failure::kInput, {"two.pt", "needs the operators aten::fold_spacetime, vision::unfold, which libtorch"},
               [&] { load(folder / "two.pt"); });
  replace_in_code(made("form.pt"), "torch.sin(", "torch.sin(3, ");
  expect_error(Failure::kInput, {"form.pt", "needs the operator aten::sin in a form that libtorch"},
               [&] { load(folder / "form.pt"); });
  replace_in_code(made("whole.pt"), "torch.sin(", "torch.tan(");
  EXPECT_NO_THROW(load(folder / "whole.pt"));
}

TEST(TorchModule, AFileCutOffOrDamagedIsAnError) {
  TemporaryFolder folder;
  write_torch_module(folder / "made.pt", "def forward(self, x, k):\n  return x\n");
  std::ifstream in(folder / "made.pt", std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  EXPECT_THROW(NeuralModule(folder.file("cut.pt", whole.substr(0, whole.size() / 2)), trusted()), Error);
  std::string damaged = whole;
  for (size_t i = 200; i < damaged.size() / 2; i += 17) damaged[i] ^= 0x55;
  EXPECT_THROW(NeuralModule(folder.file("damaged.pt", damaged), trusted()).verify(line_contract(), {{"n", 3}}), Error);
}
