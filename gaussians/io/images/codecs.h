#pragma once

#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

/// OpenCV's functions of these names.  Its decoders bring more than 200 libraries, which take .3 s to load; so they are
/// modules that the first image and the first video open.
namespace pliant::codecs {

cv::Mat imread(const std::string& file, int flags = cv::IMREAD_COLOR);
bool imwrite(const std::string& file, const cv::Mat& picture);
cv::Mat imdecode(const cv::Mat& bytes, int flags);
bool imencode(const std::string& extension, const cv::Mat& picture, std::vector<uint8_t>& bytes,
              const std::vector<int>& parameters = {});

/// The video decoded by ffmpeg; its functions are virtual, so that callers need no library.
std::unique_ptr<cv::VideoCapture> open_video(const std::string& file);

}  // namespace pliant::codecs
