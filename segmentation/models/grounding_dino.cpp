#include "segmentation/models/grounding_dino.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "segmentation/models/boxes.h"
#include "segmentation/models/picture.h"

namespace pliant {
namespace {

/// Positions count anew after every separator, and only the pieces between two of them see each other.
void link_pieces(const WordPiece& tokenizer, GroundingPrompt& prompt) {
  const size_t length = prompt.ids.size();
  prompt.positions.assign(length, 0);
  prompt.pairs.assign(length * length, 0);
  for (size_t i = 0; i < length; ++i) prompt.pairs[i * length + i] = 1;
  size_t begin = 0;
  for (size_t end = 0; end < length; ++end) {
    const int64_t id = prompt.ids[end];
    const bool separator = id == tokenizer.id("[CLS]") || id == tokenizer.id("[SEP]") || id == tokenizer.id(".");
    if (!prompt.attention[end] || !separator) continue;
    for (size_t i = begin; i <= end; ++i) {
      prompt.positions[i] = static_cast<int64_t>(i - begin);
      for (size_t j = begin; j <= end; ++j) prompt.pairs[i * length + j] = 1;
    }
    begin = end + 1;
  }
}

float sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

}  // namespace

std::vector<GroundingPrompt> grounding_prompts(const WordPiece& tokenizer, const std::vector<std::string>& names,
                                               size_t length) {
  std::vector<GroundingPrompt> prompts;
  const auto finish = [&](GroundingPrompt& prompt) {
    prompt.ids.push_back(tokenizer.id("[SEP]"));
    prompt.attention.assign(prompt.ids.size(), 1);
    prompt.ids.resize(length, 0);
    prompt.attention.resize(length, 0);
    link_pieces(tokenizer, prompt);
  };
  for (size_t n = 0; n < names.size(); ++n) {
    std::string name = names[n];
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '.' || c == '?'; }, ' ');  // they end a name
    const std::vector<std::string> pieces = tokenizer.tokenize(name);
    if (pieces.empty() || pieces.size() + 3 > length)
      throw usage_error("name", "", "'" + names[n] + "' has " + std::to_string(pieces.size()) + " tokens",
                        "give names of 1 to " + std::to_string(length - 3) + " tokens");
    if (prompts.empty() || prompts.back().ids.size() + pieces.size() + 2 > length) {
      if (!prompts.empty()) finish(prompts.back());
      prompts.push_back({{}, {tokenizer.id("[CLS]")}, {}, {}, {}});
    }
    GroundingPrompt& prompt = prompts.back();
    prompt.spans.push_back({n, prompt.ids.size(), prompt.ids.size() + pieces.size()});
    for (const std::string& piece : pieces) prompt.ids.push_back(tokenizer.id(piece));
    prompt.ids.push_back(tokenizer.id("."));
  }
  if (!prompts.empty()) finish(prompts.back());
  return prompts;
}

GroundingDino::GroundingDino(std::unique_ptr<NeuralModule> module, WordPiece tokenizer, const Options& options)
    : module_(std::move(module)), tokenizer_(std::move(tokenizer)), options_(options) {
  const ModelFile& file = module_->file();
  height_ = file.size_of("height", 800);
  width_ = file.size_of("width", 1200);
  tokens_ = file.size_of("tokens", 256);
  const double last = static_cast<double>(tokenizer_.size()) - 1;
  const auto type = Tensor::Type::kInt64, flag = Tensor::Type::kBool;
  contract_.inputs = {{"image", Tensor::Type::kFloat32, "1,3,H,W", -2.2, 2.7, "ImageNet mean and deviation, red first"},
                      {"padding", flag, "1,H,W", 0, 1, "true outside the image"},
                      {"input_ids", type, "1,T", 0, last, "IDs of the tokens"},
                      {"attention_mask", flag, "1,T", 0, 1, "true except for padding"},
                      {"position_ids", type, "1,T", 0, 1, "counted from the last separator"},
                      {"token_type_ids", type, "1,T", 0, 0, "zero"},
                      {"text_self_attention_masks", flag, "1,T,T", 0, 1, "tokens that attend to each other"}};
  contract_.outputs = {{"logits", Tensor::Type::kFloat32, "1,Q,T", -INFINITY, 1e30, "of each token"},
                       {"boxes", Tensor::Type::kFloat32, "1,Q,4", 0, 1, "center x, y, width, height"}};
  module_->verify(contract_, {{"H", height_}, {"W", width_}, {"T", tokens_}});
}

std::vector<Detection> GroundingDino::detect(const ImageF& picture, const std::vector<std::string>& names) {
  if (names.empty()) throw usage_error(module_->file().file.string(), "names", "are missing", "say what to look for");
  const Fitted fitted = fit_picture(picture, width_, height_, 0);
  Tensor image = to_planes(fitted.picture, Normalisation::imagenet());
  const int64_t length = tokens_;
  std::vector<int64_t> padding(static_cast<size_t>(width_) * height_, 1);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const size_t i = static_cast<size_t>(y) * width_ + x;
      if (x < fitted.width && y < fitted.height)
        padding[i] = 0;
      else
        for (size_t c = 0; c < 3; ++c) image.values[c * padding.size() + i] = 0;
    }
  std::vector<Detection> boxes;
  for (const GroundingPrompt& prompt : grounding_prompts(tokenizer_, names, tokens_)) {
    const std::vector<Tensor> out = module_->run(
        contract_,
        {image, Tensor::whole({1, height_, width_}, padding, Tensor::Type::kBool),
         Tensor::whole({1, length}, prompt.ids), Tensor::whole({1, length}, prompt.attention, Tensor::Type::kBool),
         Tensor::whole({1, length}, prompt.positions), Tensor::whole({1, length}, std::vector<int64_t>(length, 0)),
         Tensor::whole({1, length, length}, prompt.pairs, Tensor::Type::kBool)});
    for (int64_t q = 0; q < out[0].shape[1]; ++q) {
      const float* logits = out[0].values.data() + q * length;
      const float* shares = out[1].values.data() + q * 4;
      Detection box;
      float best = -1;  // mean over the pieces of a name of those that speak for it
      for (const GroundingPrompt::Span& span : prompt.spans) {
        float sum = 0;
        for (size_t t = span.begin; t < span.end; ++t) {
          const float probability = sigmoid(logits[t]);
          box.score = std::max(box.score, probability);
          if (probability > options_.text_threshold) sum += probability;
        }
        const float mean = sum / static_cast<float>(span.end - span.begin);
        if (mean > best) {
          best = mean;
          box.label = names[span.name];
        }
      }
      if (box.score <= options_.box_threshold) continue;
      box.x0 = (shares[0] - shares[2] / 2) * picture.width;
      box.x1 = (shares[0] + shares[2] / 2) * picture.width;
      box.y0 = (shares[1] - shares[3] / 2) * picture.height;
      box.y1 = (shares[1] + shares[3] / 2) * picture.height;
      if (clip_box(box, picture.width, picture.height)) boxes.push_back(std::move(box));
    }
  }
  return suppress_overlaps(std::move(boxes), options_.overlap);
}

}  // namespace pliant
