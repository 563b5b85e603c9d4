#pragma once

#include "segmentation/field/vote.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// A segmentation that is certain of `label`.
inline Segmentation certain(const std::vector<uint32_t>& label, const std::vector<uint32_t>& ids) {
  Segmentation s;
  s.class_id = ids;
  s.class_name.assign(ids.size(), "thing");
  s.classifier_bias.assign(ids.size(), 0.0f);
  s.classifier = class_codes(static_cast<int>(ids.size()), 1);
  for (float& w : s.classifier) w *= 12;
  s.attribute.assign(label.size() * kSemanticChannels, 0.0f);
  for (size_t p = 0; p < label.size(); ++p) {
    const int c = class_of_id(s, label[p]);
    for (int k = 0; k < kSemanticChannels; ++k)
      s.attribute[p * kSemanticChannels + k] = s.classifier[c * kSemanticChannels + k] / 12;
  }
  s.seen.assign(label.size(), 1);
  update_labels(s);
  return s;
}

}  // namespace pliant
