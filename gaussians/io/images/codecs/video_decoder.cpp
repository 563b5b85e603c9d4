#include <opencv2/videoio.hpp>

extern "C" cv::VideoCapture* pliant_open_video(const std::string& file) {
  return new cv::VideoCapture(file, cv::CAP_FFMPEG);
}
