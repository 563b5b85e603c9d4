#pragma once

#include "segmentation/model_interfaces/detector.h"
#include "segmentation/models/neural_module.h"
#include "segmentation/models/text/wordpiece.h"

namespace pliant {

/// The words that are looked for as Grounding DINO reads them: "[CLS] red flower . vase . [SEP]", filled up with zeros.
struct GroundingPrompt {
  struct Span {
    size_t name, begin, end;  ///< index of the name and its pieces [begin, end)
  };
  std::vector<Span> spans;
  std::vector<int64_t> ids, attention, positions;  ///< [T]; attention 1 for what is not filling
  std::vector<int64_t> pairs;  ///< [T,T]; 1 where two pieces belong to one name, and on the diagonal
};

/// As many prompts of `length` pieces as the names need, in their order.  A name without a piece, or with more than
/// fit, is an Error{kUsage}.
std::vector<GroundingPrompt> grounding_prompts(const WordPiece& tokenizer, const std::vector<std::string>& names,
                                               size_t length);

/// Grounding DINO (Liu et al. 2023) as export/export_grounding_dino.py writes it; *never run with the official
/// weights*.
///   in   image: float32 [1,3,H,W], ImageNet mean and deviation, scaled to fit, upper left corner, the rest zero
///        padding: bool [1,H,W], true where there is no picture
///        input_ids, position_ids, token_type_ids: int64 [1,T]; attention_mask: bool [1,T]
///        text_self_attention_masks: bool [1,T,T]
///   out  logits: float32 [1,Q,T], how much each box is each piece of the text; -inf allowed
///        boxes: float32 [1,Q,4] in 0..1: centre x, y, width, height as shares of the picture without its padding
/// H, W and T are "height", "width" and "tokens" of the description (800, 1200, 256).
class GroundingDino : public Detector {
 public:
  struct Options {
    float box_threshold = 0.35f;   ///< least probability of the best piece
    float text_threshold = 0.25f;  ///< pieces below it do not speak for a name
    float overlap = 0.8f;          ///< of boxes of one name that are suppressed
  };

  GroundingDino(std::unique_ptr<NeuralModule> module, WordPiece tokenizer, const Options& options);

  std::vector<Detection> detect(const ImageF& picture, const std::vector<std::string>& names) override;
  std::vector<std::string> vocabulary() const override { return {}; }

 private:
  std::unique_ptr<NeuralModule> module_;
  WordPiece tokenizer_;
  Options options_;
  Contract contract_;
  int width_ = 0, height_ = 0, tokens_ = 0;
};

}  // namespace pliant
