#include "gaussians/io/images/codecs.h"

#include "gaussians/io/files/module.h"
#include "gaussians/io/images/codecs/image_codecs.h"

namespace pliant::codecs {
namespace {

constexpr const char* kAdvice = "it is built and installed with the program: build or install that again";

const ImageCodecs& image_codecs() {
  using Table = const ImageCodecs* (*)();
  static const ImageCodecs& table =
      *reinterpret_cast<Table>(module_function("pliant_images.so", "pliant_image_codecs", kAdvice))();
  return table;
}

}  // namespace

cv::Mat imread(const std::string& file, int flags) { return image_codecs().imread(file, flags); }
bool imwrite(const std::string& file, const cv::Mat& picture) { return image_codecs().imwrite(file, picture); }
cv::Mat imdecode(const cv::Mat& bytes, int flags) { return image_codecs().imdecode(bytes, flags); }
bool imencode(const std::string& extension, const cv::Mat& picture, std::vector<uint8_t>& bytes,
              const std::vector<int>& parameters) {
  return image_codecs().imencode(extension, picture, bytes, parameters);
}

std::unique_ptr<cv::VideoCapture> open_video(const std::string& file) {
  using Open = cv::VideoCapture* (*)(const std::string&);
  static const auto open = reinterpret_cast<Open>(module_function("pliant_video.so", "pliant_open_video", kAdvice));
  return std::unique_ptr<cv::VideoCapture>(open(file));
}

}  // namespace pliant::codecs
