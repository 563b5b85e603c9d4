#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "segmentation/lift/segmentation.h"

namespace pliant {

/// Pixels [H * W] of `id` within `band` pixels of its contour, inside it; the picture's border counts as contour.
std::vector<uint8_t> contour_band(const IdImage& ids, uint32_t id, int band);

/// Boundary IoU per id (Cheng et al. 2021): intersection over union of the contour bands, summed over all pictures;
/// unlabelled pixels of the truth are left out.
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
