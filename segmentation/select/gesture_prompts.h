#pragma once

#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/types.h"

namespace pliant {

/// The object lies inside this rectangle of a camera's picture (px).
struct BoxPrompt {
  int camera = -1;
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  bool operator==(const BoxPrompt&) const = default;
};

/// What a person drew over a camera's picture: the surfaces under a polyline belong to the object, or do not.  A click
/// is a stroke of one point.
struct StrokePrompt {
  int camera = -1;
  bool foreground = true;
  std::vector<Vec2f> points;  ///< px
  float width = 8;            ///< px

  bool operator==(const StrokePrompt&) const = default;
};

struct Gesture {
  std::vector<BoxPrompt> boxes;
  std::vector<StrokePrompt> strokes;  ///< a later one counts over an earlier one at the same place
  static constexpr int kMaxGrow = 100;
  int grow = 0;  ///< rounds of neighbors that the selection takes in at last, or gives up where negative

  bool empty() const { return boxes.empty() && strokes.empty(); }
};

/// Prompts from the texts of the options.  Cameras are given by name, also one with commas, or by number from 0: #2, or
/// 2 where no camera has that name.  Throw Error{kUsage} naming the option, the text and what to give: an unknown
/// camera, a wrong count of numbers, a point outside the picture, a box without area, a second box in one camera.
void add_box(const std::string& text, const std::vector<Camera>& cameras, Gesture& gesture);  ///< --box V,x0,y0,x1,y1
void add_click(const std::string& text, const std::vector<Camera>& cameras, float width,
               Gesture& gesture);  ///< --click V,x,y
/// --stroke fg|bg,V,x0,y0[,x1,y1...]
void add_stroke(const std::string& text, const std::vector<Camera>& cameras, float width, Gesture& gesture);

}  // namespace pliant
