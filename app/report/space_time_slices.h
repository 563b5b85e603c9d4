#pragma once

#include <span>
#include <string>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

/// A row and a column of pixels, px.
struct SliceLines {
  int row = 0, column = 0;
};
/// The lines in which the frames change most from the first one, over pixels with `moving` [H, W, 1] above 0.5 (empty:
/// all).
SliceLines most_changed_lines(const std::vector<ImageF>& frames, const ImageF& moving = {});

/// Two lines of pixels over time, of several clips of one size side by side: motion becomes a curve that can be
/// compared by eye (as PhysDreamer shows it, Zhang et al. 2024).
class SpaceTimeSlices {
 public:
  SpaceTimeSlices(std::vector<std::string> names, SliceLines lines) : names_(std::move(names)), lines_(lines) {
    clips_.resize(names_.size());
  }

  /// The pictures of all clips at one instant.
  void add(std::span<const ImageF* const> pictures);
  /// Time runs downwards for the row, to the right for the column.
  ImageF picture() const;
  /// Root mean square difference from the first clip, of the row and of the column.
  std::pair<double, double> rmse(size_t clip) const;

 private:
  struct Lines {
    std::vector<float> row, column;  // [T, W or H, 3]
  };
  std::vector<std::string> names_;
  SliceLines lines_;
  std::vector<Lines> clips_;
  int frames_ = 0, width_ = 0, height_ = 0;
};

}  // namespace pliant
