#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "segmentation/models/ram.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

std::unique_ptr<NeuralModule> made_tagger(const TemporaryFolder& folder) {
  write_torch_module(folder / "ram.pt", "def forward(self, image):\n  return torch.mean(image, [2, 3])\n",
                     R"({"kind": "ram", "size": 8})");
  return std::make_unique<NeuralModule>(folder / "ram.pt", trusted());
}

}  // namespace

TEST(RamTorch, TagsAboveTheirOwnThresholdBestFirst) {
  TemporaryFolder folder;
  Ram ram(made_tagger(folder), TagList::read(folder.file("ram.txt", "rose\t0.6\ngrass\t0.9\nsky\n")));
  ImageF picture(20, 10, 3);
  for (size_t i = 0; i < picture.data.size(); i += 3) {
    picture.data[i] = 0.7f;
    picture.data[i + 1] = 0.9f;
    picture.data[i + 2] = 1;
  }
  const std::vector<Tag> tags = ram.tag(picture);
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[0].name, "sky");
  EXPECT_NEAR(tags[0].score, 1 / (1 + std::exp(-(1 - 0.406f) / 0.225f)), 1e-4);
  EXPECT_EQ(tags[1].name, "rose");
  EXPECT_NEAR(tags[1].score, 1 / (1 + std::exp(-(0.7f - 0.485f) / 0.229f)), 1e-4);
}

TEST(RamTorch, EveryPixelCountsInItsPlaceAndChannel) {
  TemporaryFolder folder;
  MadeTensor weights{"weights", {1, 3, 8, 8}, {}};
  for (int i = 0; i < 3 * 64; ++i) weights.values.push_back(0.001f * static_cast<float>(i * i % 97));
  write_torch_module(folder / "ram.pt", "def forward(self, image):\n  return torch.sum(image * self.weights, [2, 3])\n",
                     R"({"kind": "ram", "size": 8})", {weights});
  Ram ram(std::make_unique<NeuralModule>(folder / "ram.pt", trusted()),
          TagList::read(folder.file("ram.txt", "rose\t0\ngrass\t0\nsky\t0\n")));
  ImageF picture(8, 8, 3);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) {
      picture(x, y, 0) = 0.1f * static_cast<float>(x);
      picture(x, y, 1) = 0.08f * static_cast<float>(y);
      picture(x, y, 2) = 0.01f * static_cast<float>(x * y);
    }
  const float mean[] = {0.485f, 0.456f, 0.406f}, deviation[] = {0.229f, 0.224f, 0.225f};
  std::map<std::string, float> expected;
  for (int c = 0; c < 3; ++c) {
    float logit = 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        logit += (picture(x, y, c) - mean[c]) / deviation[c] * weights.values[(c * 8 + y) * 8 + x];
    expected[std::vector<std::string>{"rose", "grass", "sky"}[c]] = logit;
  }
  const std::vector<Tag> tags = ram.tag(picture);
  ASSERT_EQ(tags.size(), 3u);
  for (const Tag& tag : tags) EXPECT_NEAR(std::log(tag.score / (1 - tag.score)), expected[tag.name], 2e-3) << tag.name;
}

TEST(RamTorch, AListOfAnotherLengthBreaksTheContract) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"ram.pt", "is float32 [1,3]", "logits: float32 [1,2]", "tag list"},
               [&] { Ram ram(made_tagger(folder), TagList::read(folder.file("ram.txt", "rose\nsky\n"))); });
}

TEST(TagList, AThresholdThatIsNoShareIsRefused) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"ram.txt", "line 2", "'high'"},
               [&] { TagList::read(folder.file("ram.txt", "a\nb\thigh\n")); });
}

TEST(TagList, ANameThatIsNotUtf8IsRefused) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"ram.txt", "line 3", "is not UTF-8"}, [&] {
    TagList::read(folder.file("ram.txt",
                              "rose\n\nk\xe4"
                              "se\t0.5\n"));
  });
  EXPECT_EQ(TagList::read(folder.file("ram.txt", "k\xc3\xa4se\n")).names, std::vector<std::string>{"k\xc3\xa4se"});
}
