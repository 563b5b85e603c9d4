#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace pliant::codecs {

/// What the module of image codecs gives.
struct ImageCodecs {
  cv::Mat (*imread)(const std::string& file, int flags);
  bool (*imwrite)(const std::string& file, const cv::Mat& picture);
  cv::Mat (*imdecode)(const cv::Mat& bytes, int flags);
  bool (*imencode)(const std::string& extension, const cv::Mat& picture, std::vector<uint8_t>& bytes,
                   const std::vector<int>& parameters);
};

}  // namespace pliant::codecs
