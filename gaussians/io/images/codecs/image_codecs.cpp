#include "gaussians/io/images/codecs/image_codecs.h"

#include <opencv2/imgcodecs.hpp>

extern "C" const pliant::codecs::ImageCodecs* pliant_image_codecs() {
  static const pliant::codecs::ImageCodecs table = {
      [](const std::string& file, int flags) { return cv::imread(file, flags); },
      [](const std::string& file, const cv::Mat& picture) { return cv::imwrite(file, picture); },
      [](const cv::Mat& bytes, int flags) { return cv::imdecode(bytes, flags); },
      [](const std::string& extension, const cv::Mat& picture, std::vector<uint8_t>& bytes,
         const std::vector<int>& parameters) { return cv::imencode(extension, picture, bytes, parameters); }};
  return &table;
}
