// Silhouettes of an object before a dark ground: silhouettes_study PHOTOS OUT_FOLDER [RGBA_FOLDER]
// 1 = object, 2 = the rest: grey above 0.19, closed by a 5 x 5 square, largest part, holes filled.  RGBA_FOLDER gets
// the photos with the silhouettes as alpha, for `pliant reconstruct` (put the cameras' file beside them).

#include <cstdio>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "gaussians/io/images/codecs.h"
#include "gaussians/io/images/image_io.h"

using namespace pliant;
namespace fs = std::filesystem;

namespace {

/// The largest part of a mask of 0 and 1.
cv::Mat largest_part(const cv::Mat& mask) {
  cv::Mat number, stats, centres;
  const int count = cv::connectedComponentsWithStats(mask, number, stats, centres);
  int best = 0;
  for (int k = 1; k < count; ++k)
    if (best == 0 || stats.at<int>(k, cv::CC_STAT_AREA) > stats.at<int>(best, cv::CC_STAT_AREA)) best = k;
  return (number == best) / 255;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s PHOTOS OUT_FOLDER [RGBA_FOLDER]\n", argv[0]), 2;
  fs::create_directories(argv[2]);
  for (const auto& entry : fs::directory_iterator(argv[1])) {
    if (entry.path().extension() != ".png" && entry.path().extension() != ".jpg") continue;
    const ImageF photo = read_image(entry.path());
    cv::Mat mask(photo.height, photo.width, CV_8U);
    for (int y = 0; y < photo.height; ++y)
      for (int x = 0; x < photo.width; ++x)
        mask.at<uint8_t>(y, x) = 0.299f * photo(x, y, 0) + 0.587f * photo(x, y, 1) + 0.114f * photo(x, y, 2) > 0.19f;
    cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::Mat::ones(5, 5, CV_8U));
    const cv::Mat outside = largest_part(1 - largest_part(mask));
    IdImage ids(photo.width, photo.height, 1);
    for (int y = 0; y < photo.height; ++y)
      for (int x = 0; x < photo.width; ++x) ids(x, y) = outside.at<uint8_t>(y, x) ? 2 : 1;
    const fs::path name = entry.path().stem().concat(".png");
    write_ids(argv[2] / name, ids);
    if (argc < 4) continue;
    cv::Mat cut_out;
    cv::cvtColor(codecs::imread(entry.path().string()), cut_out, cv::COLOR_BGR2BGRA);
    cut_out.forEach<cv::Vec4b>([&](cv::Vec4b& pixel, const int* at) { pixel[3] = ids(at[1], at[0]) == 1 ? 255 : 0; });
    fs::create_directories(argv[3]);
    codecs::imwrite((argv[3] / name).string(), cut_out);
  }
}
