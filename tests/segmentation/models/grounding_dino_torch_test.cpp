#include <gtest/gtest.h>

#include <cmath>

#include "segmentation/models/grounding_dino.h"
#include "segmentation/models/picture.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

const char* const kVocabulary = "[PAD]\n[UNK]\n[CLS]\n[SEP]\n.\nred\nflower\nvase\nchair\n##s\n";

// Box q likes the piece whose number is 6 + q; its logits tell of all inputs of the text, its box of those of the
// picture.
const char* const kModule = R"(
def forward(self, image, padding, input_ids, attention_mask, position_ids, token_type_ids, text_self_attention_masks):
    rows = []
    for q in range(3):
        hit = torch.mul(input_ids == 6 + q, attention_mask)
        rows.append(hit * 8.0 - 4.0 + position_ids * 0.1 + torch.sum(text_self_attention_masks, [2]) * 0.01 + token_type_ids)
    logits = torch.stack(rows, 1)
    where = torch.sigmoid(torch.mean(image, [2, 3]))
    seen = 1.0 - torch.mean(padding * 1.0, [1, 2])
    size = torch.stack([seen[0], where[0, 2]], 0)
    boxes = torch.cat([where[0, :2], size * 0.5], 0)
    return logits, torch.reshape(boxes, [1, 1, 4]).repeat([1, 3, 1]) * torch.reshape(self.shrink, [1, 3, 1])
)";

float sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

std::unique_ptr<GroundingDino> made_dino(const TemporaryFolder& folder) {
  write_torch_module(folder / "dino.pt", kModule,
                     R"({"kind": "grounding-dino", "height": 24, "width": 32, "tokens": 10})",
                     {{"shrink", {3}, {1.f, 0.75f, 0.5f}}});
  return std::make_unique<GroundingDino>(std::make_unique<NeuralModule>(folder / "dino.pt", trusted()),
                                         WordPiece(folder.file("vocab.txt", kVocabulary)), GroundingDino::Options());
}

}  // namespace

TEST(GroundingPrompts, NamesArePartedByPointsAndSeeOnlyThemselves) {
  TemporaryFolder folder;
  const WordPiece tokenizer(folder.file("vocab.txt", kVocabulary));
  const std::vector<GroundingPrompt> prompts = grounding_prompts(tokenizer, {"Red flower", "vases"}, 10);
  ASSERT_EQ(prompts.size(), 1u);
  const GroundingPrompt& prompt = prompts[0];
  EXPECT_EQ(prompt.ids, (std::vector<int64_t>{2, 5, 6, 4, 7, 9, 4, 3, 0, 0}));
  EXPECT_EQ(prompt.attention, (std::vector<int64_t>{1, 1, 1, 1, 1, 1, 1, 1, 0, 0}));
  EXPECT_EQ(prompt.positions, (std::vector<int64_t>{0, 0, 1, 2, 0, 1, 2, 0, 0, 0}));
  const std::vector<int64_t> group = {0, 1, 1, 1, 2, 2, 2, 3, 4, 5};
  for (size_t i = 0; i < 10; ++i)
    for (size_t j = 0; j < 10; ++j) EXPECT_EQ(prompt.pairs[i * 10 + j], group[i] == group[j]) << i << " " << j;
  ASSERT_EQ(prompt.spans.size(), 2u);
  EXPECT_EQ(prompt.spans[1].name, 1u);
  EXPECT_EQ(prompt.spans[1].begin, 4u);
  EXPECT_EQ(prompt.spans[1].end, 6u);
}

TEST(GroundingPrompts, MoreNamesThanFitGoIntoFurtherPrompts) {
  TemporaryFolder folder;
  const WordPiece tokenizer(folder.file("vocab.txt", kVocabulary));
  const std::vector<GroundingPrompt> prompts =
      grounding_prompts(tokenizer, {"red", "flower", "vase", "chair", "red chair"}, 8);
  ASSERT_EQ(prompts.size(), 2u);
  EXPECT_EQ(prompts[0].spans.size(), 3u);
  EXPECT_EQ(prompts[1].spans[0].name, 3u);
  EXPECT_EQ(prompts[1].ids, (std::vector<int64_t>{2, 8, 4, 5, 8, 4, 3, 0}));
  expect_error(Failure::kUsage, {"'...'"}, [&] { grounding_prompts(tokenizer, {"..."}, 8); });
}

TEST(GroundingDinoTorch, BoxesAndNamesFollowFromEveryInput) {
  TemporaryFolder folder;
  const auto dino = made_dino(folder);
  ImageF picture(16, 16, 3);  // 24 of 32 columns of the network are picture
  for (size_t i = 0; i < picture.data.size(); i += 3) {
    picture.data[i] = 0.75f;
    picture.data[i + 1] = 0.5f;
    picture.data[i + 2] = 0.25f;
  }
  const std::vector<Detection> found = dino->detect(picture, {"red flower", "vase"});
  ASSERT_EQ(found.size(), 2u);  // the third box likes a piece that is not there
  EXPECT_EQ(found[0].label, "red flower");
  EXPECT_EQ(found[1].label, "vase");
  EXPECT_NEAR(found[0].score, sigmoid(4 + 0.1f + 0.03f), 1e-5);  // position 1, three pieces see each other
  EXPECT_NEAR(found[1].score, sigmoid(4 + 0.02f), 1e-5);
  const float cx = sigmoid(0.75f * (0.75f - 0.485f) / 0.229f) * 16, cy = sigmoid(0.75f * (0.5f - 0.456f) / 0.224f) * 16;
  const float width = 0.75f * 0.5f * 16, height = sigmoid(0.75f * (0.25f - 0.406f) / 0.225f) * 0.5f * 16;
  EXPECT_NEAR(found[0].x0, cx - width / 2, 1e-3);
  EXPECT_NEAR(found[0].x1, std::min(16.f, cx + width / 2), 1e-3);
  EXPECT_NEAR(found[0].y0, cy - height / 2, 1e-3);
  EXPECT_NEAR(found[0].y1, cy + height / 2, 1e-3);
  EXPECT_NEAR(found[1].x1 - found[1].x0, 0.75f * width, 1e-3);
  expect_error(Failure::kUsage, {"names"}, [&] { dino->detect(picture, {}); });
}
