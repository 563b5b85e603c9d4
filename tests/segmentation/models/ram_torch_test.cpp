#include "segmentation/models/ram.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

std::unique_ptr<NeuralModule> made(const TemporaryFolder& folder) {
  write_torch_module(folder / "ram.pt", "def forward(self, image):\n  return torch.mean(image, [2, 3])\n", R"({"kind": "ram", "size": 8})");
  ModuleOptions trusted;
  trusted.trust_torchscript = true;
  return std::make_unique<NeuralModule>(folder / "ram.pt", trusted);
}

}  // namespace

TEST(RamTorch, TagsAboveTheirOwnThresholdBestFirst) {
  TemporaryFolder folder;
  Ram ram(made(folder), TagList::read(folder.file("ram.txt", "rose\t0.6\ngrass\t0.9\nsky\n")));
  ImageF picture(20, 10, 3);
  for (size_t i = 0; i < picture.data.size(); i += 3) picture.data[i] = 0.7f, picture.data[i + 1] = 0.9f, picture.data[i + 2] = 1;
  const std::vector<Tag> tags = ram.tag(picture);
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[0].name, "sky");
  EXPECT_NEAR(tags[0].score, 1 / (1 + std::exp(-(1 - 0.406f) / 0.225f)), 1e-4);
  EXPECT_EQ(tags[1].name, "rose");
  EXPECT_NEAR(tags[1].score, 1 / (1 + std::exp(-(0.7f - 0.485f) / 0.229f)), 1e-4);
}

TEST(RamTorch, AListOfAnotherLengthBreaksTheContract) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"ram.pt", "is float32 [1,3]", "logits: float32 [1,2]", "tag list"},
               [&] { Ram ram(made(folder), TagList::read(folder.file("ram.txt", "rose\nsky\n"))); });
}

TEST(TagList, AThresholdThatIsNoShareIsRefused) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"ram.txt", "line 2", "'high'"}, [&] { TagList::read(folder.file("ram.txt", "a\nb\thigh\n")); });
}
