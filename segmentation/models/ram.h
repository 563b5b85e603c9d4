#pragma once

#include "segmentation/model_interfaces/tagger.h"
#include "segmentation/models/neural_module.h"

namespace pliant {

/// Words that a tagger knows, one per line, each with the least score at which it counts after a tab (0.68 without).
struct TagList {
  std::vector<std::string> names;
  std::vector<float> thresholds;

  static TagList read(const std::filesystem::path& file);
};

/// RAM, Recognize Anything (Zhang et al. 2023), as export/export_ram.py writes it; *never run with the official
/// weights*.
///   in   image: float32 [1,3,S,S], ImageNet mean and deviation, both sides scaled to S
///   out  logits: float32 [1,K], one per line of the tag list
/// S is "size" of the description (384).
class Ram : public Tagger {
 public:
  Ram(std::unique_ptr<NeuralModule> module, TagList tags);

  /// The contract for a list of `tags`, a number or a letter.
  static Contract contract(const std::string& tags);

  std::vector<Tag> tag(const ImageF& picture) override;

 private:
  std::unique_ptr<NeuralModule> module_;
  TagList tags_;
  Contract contract_;
  int size_ = 0;
};

}  // namespace pliant
