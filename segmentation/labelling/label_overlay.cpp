#include "segmentation/labelling/label_overlay.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "segmentation/sheets/objects_sheet.h"

namespace pliant {

ImageF overlay_labels(const ImageF& picture, const LabelledPhoto& photo) {
  ImageF sheet = overlay_ids(picture, photo.ids);
  cv::Mat canvas(sheet.height, sheet.width, CV_32FC3, sheet.data.data());
  const double size = std::max(0.35, 0.0007 * std::max(sheet.width, sheet.height));
  for (const LabelledThing& thing : photo.things) {
    const Vec3f c = id_color(thing.id);
    cv::rectangle(canvas, cv::Point2f(thing.box.x0, thing.box.y0), cv::Point2f(thing.box.x1 - 1, thing.box.y1 - 1),
                  {c[0], c[1], c[2]});
    char text[80];
    std::snprintf(text, sizeof(text), "%.60s %.2f", thing.name.c_str(), thing.score);
    int base = 0;
    const cv::Size extent = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &base);
    const cv::Point at(static_cast<int>(thing.box.x0) + 2,
                       std::max<int>(extent.height + 2, static_cast<int>(thing.box.y0) - 3));
    cv::rectangle(canvas, at + cv::Point(-2, base), at + cv::Point(extent.width + 2, -extent.height - 2),
                  cv::Scalar::all(0), cv::FILLED);
    cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar::all(1), 1, cv::LINE_AA);
  }
  return sheet;
}

}  // namespace pliant
