#include <gtest/gtest.h>

#include "segmentation/models/make_models.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

TEST(MakeModelsTorch, NothingGivenIsNothingMade) {
  EXPECT_EQ(make_detector({}), nullptr);
  EXPECT_EQ(make_tagger({}), nullptr);
  EXPECT_EQ(make_segmenter({}), nullptr);
  EXPECT_EQ(make_tracker({}), nullptr);
  EXPECT_EQ(make_inpainter({}), nullptr);
  EXPECT_TRUE(ModelChoice().empty());
}

TEST(MakeModelsTorch, AFileInTheWrongSlotIsSentToItsOwn) {
  TemporaryFolder folder;
  write_torch_module(folder / "net.pt", "def forward(self, image):\n  return image\n", R"({"kind": "lama"})");
  ModelChoice choice;
  choice.trust_torchscript = true;
  choice.tagger = folder / "net.pt";
  expect_error(Failure::kUsage, {"--tagger", "net.pt", "'lama'", "--inpainter"}, [&] { make_tagger(choice); });
}

TEST(MakeModelsTorch, ListsOfWordsAreFoundBesideTheNetworkOrByTheOption) {
  TemporaryFolder folder;
  write_torch_module(folder / "ram.pt", "def forward(self, image):\n  return torch.mean(image, [2, 3])\n",
                     R"({"kind": "ram", "size": 8})");
  ModelChoice choice;
  choice.trust_torchscript = true;
  choice.tagger = folder / "ram.pt";
  expect_error(Failure::kUsage, {"--vocabulary", "ram.pt", "tag list", "ram.txt"}, [&] { make_tagger(choice); });
  choice.vocabularies = {folder.file("words.txt", "[PAD]\n[UNK]\n[CLS]\n[SEP]\n"),
                         folder.file("tags.txt", "a\nb\nc\n")};
  EXPECT_NE(make_tagger(choice), nullptr);
  EXPECT_EQ(choice.files().size(), 3u);
}

TEST(MakeModelsTorch, EachNetworkOfAChoiceGetsItsShareOfTheMemory) {
  TemporaryFolder folder;
  write_torch_module(folder / "ram.pt",
                     "def forward(self, image):\n  return torch.ones([1, 1 << 48]) + image[0, 0, 0, 0]\n",
                     R"({"kind": "ram", "size": 8})");
  ModelChoice choice;
  choice.trust_torchscript = true;
  choice.tagger = folder / "ram.pt";
  choice.vocabularies = {folder.file("tags.txt", "a\nb\nc\n")};
  for (const char* detector : {"", "another.onnx"}) {
    choice.detector = detector;
    const std::string share = " " + std::to_string(memory_share(*detector ? 2 : 1) >> 20) + " MB";
    expect_error(Failure::kInput, {"ram.pt", "needs more than" + share}, [&] { make_tagger(choice); });
  }
}
