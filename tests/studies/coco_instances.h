#pragma once

#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <vector>

#include "gaussians/base/image.h"
#include "segmentation/labelling/mask_measures.h"

namespace pliant {

/// An object of a COCO photo.
struct CocoInstance {
  size_t category = 0;
  ImageF mask;          ///< 1 inside, -1 outside
  MaskPrompt::Box box;  ///< of the mask
  double pixels = 0;
};

/// Objects of one photo: class and corners of a polygon, as shares of the picture, on each line.
inline std::vector<CocoInstance> read_instances(const std::filesystem::path& labels, int width, int height) {
  std::vector<CocoInstance> instances;
  std::ifstream in(labels);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    CocoInstance instance;
    words >> instance.category;
    std::vector<cv::Point> corners;
    for (double x, y; words >> x >> y;) corners.emplace_back(cvRound(x * width), cvRound(y * height));
    cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
    cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{corners}, 1);
    instance.mask = ImageF(width, height, 1, -1);
    for (size_t i = 0; i < instance.mask.data.size(); ++i)
      if (mask.data[i]) {
        instance.mask.data[i] = 1;
        ++instance.pixels;
      }
    instance.box = box_of_mask(instance.mask);
    if (instance.pixels > 0) instances.push_back(std::move(instance));
  }
  return instances;
}

}  // namespace pliant
