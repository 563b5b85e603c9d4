#pragma once

#include <string>
#include <vector>

#include "gaussians/base/image.h"
#include "gaussians/base/types.h"

namespace pliant {

/// One line, or dots, of a chart; points that are not finite interrupt it.
struct Curve {
  std::string name;
  std::vector<double> x, y;
  bool dots = false;
  int color = -1;  ///< of the palette; -1 = by its place in the chart
};

struct Chart {
  std::string title, x_label, y_label;  ///< ASCII
  std::vector<Curve> curves;
  std::vector<double> marks;  ///< x of vertical lines
  bool from_zero = false;     ///< the y axis shows 0
  int width = 720, height = 420;
};

ImageF draw_chart(const Chart& chart);  ///< [height, width, 3]

/// Dark blue to yellow with evenly growing lightness, for t in [0, 1].
Vec3f map_color(double t);

/// Horizontal colour bar with round numbers of a logarithmic scale from `low` to `high` > 0, and what it shows.
ImageF draw_log_bar(double low, double high, const std::string& label, int width);

/// Lays a picture over another; what lies beyond the right and lower edges is cut.
void paste(ImageF& canvas, const ImageF& part, int left, int top);

/// Words at a place of a picture, `size` px high.
void draw_text(ImageF& picture, const std::string& text, int x, int baseline, const Vec3f& color, double size = 11);

}  // namespace pliant
