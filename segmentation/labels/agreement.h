#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Pixels [H * W] within `band` pixels of the contour of what they belong to, for all ids at once; the picture's border
/// counts as contour.
std::vector<uint8_t> contour_bands(const IdImage& ids, int band);

/// Pixels that one or both of two sets hold.
struct OverlapCount {
  size_t both = 0, either = 0;
  double iou() const { return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 1.0; }
};

/// Adds the overlaps of the contour bands of every id in a picture, those that only the prediction holds too;
/// unlabelled pixels of the truth are left out.
void count_boundaries(const IdImage& predicted, const IdImage& truth, int band,
                      std::map<uint32_t, OverlapCount>& overlap);

/// Boundary IoU per id of the truth (Cheng et al. 2021): intersection over union of the contour bands, summed over all
/// pictures; unlabelled pixels of the truth are left out.
IdAgreement boundary_agreement(std::span<const IdImage> predicted, std::span<const IdImage> truth, int band);

/// Which predicted id stands for which true one when ids have no meaning: one to one, largest IoU first.
class OverlapMatch {
 public:
  /// Adds a picture or a labelling; unlabelled positions of either do not count.
  void add(std::span<const uint32_t> predicted, std::span<const uint32_t> truth);
  std::map<uint32_t, uint32_t> match() const;

 private:
  std::map<std::pair<uint32_t, uint32_t>, size_t> both_;
  std::map<uint32_t, size_t> predicted_, truth_;
};

}  // namespace pliant
