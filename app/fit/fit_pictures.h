#pragma once

#include <vector>

#include "app/fit/fit_scene.h"

namespace pliant {

/// The object as the video's camera sees it, coloured by a value of its driving particles on a logarithmic scale,
/// before the scene in grey; rigid parts stay grey.  Below it a bar with round numbers from `low` to `high` > 0 and
/// `label`.
ImageF picture_of_drivers(const FitScene& fit, const std::vector<double>& value, double low, double high,
                          const std::string& label);

/// Two lines of pixels, over time, side by side in the video and in the fitted motion: the row and the column in which
/// the video changes most within the object.
class SpaceTimeSlices {
 public:
  explicit SpaceTimeSlices(const FitView& fit);
  void add(const ImageF& seen, const ImageF& drawn);
  /// Time runs downwards for the row, to the right for the column.
  ImageF picture() const;

 private:
  int row_ = 0, column_ = 0, width_ = 0, height_ = 0;
  std::vector<float> seen_row_, drawn_row_, seen_column_, drawn_column_;  // [T, W or H, 3]
  int frames_ = 0;
};

}  // namespace pliant
