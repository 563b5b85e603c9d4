// The detector of FILE on the photos of masks_coco64: coco_detector_study DATA_FOLDER/masks_coco64 FILE [SCORE]
// A detection is right when its name is that of a truth not yet taken and their boxes overlap by an IoU of 0.5, best first.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gaussians/io/image_io.h"
#include "segmentation/models/boxes.h"
#include "segmentation/models/make_models.h"

using namespace pliant;
namespace fs = std::filesystem;

namespace {

struct Truth {
  Detection box;
  float area = 0;  // of the mask, px^2
  bool taken = false;
};

/// Instances of one photo: class and corners of a polygon as shares of the picture on each line.
std::vector<Truth> read_truth(const fs::path& file, const ImageF& photo, const std::vector<std::string>& names) {
  std::vector<Truth> truths;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    size_t kind = 0;
    std::vector<float> x, y;
    words >> kind;
    for (float a, b; words >> a >> b;) x.push_back(a * photo.width), y.push_back(b * photo.height);
    Truth truth;
    truth.box.label = names.at(kind);
    truth.box.x0 = *std::min_element(x.begin(), x.end()), truth.box.x1 = *std::max_element(x.begin(), x.end());
    truth.box.y0 = *std::min_element(y.begin(), y.end()), truth.box.y1 = *std::max_element(y.begin(), y.end());
    for (size_t i = 0, j = x.size() - 1; i < x.size(); j = i++) truth.area += (x[j] * y[i] - x[i] * y[j]) / 2;
    truth.area = std::abs(truth.area);
    truths.push_back(truth);
  }
  return truths;
}

size_t size_class(float area) { return area < 32 * 32 ? 0 : area < 96 * 96 ? 1 : 2; }

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "coco_detector_study DATA_FOLDER/masks_coco64 FILE [SCORE]\n"), 2;
  const fs::path folder = argv[1];
  const float least = argc > 3 ? std::strtof(argv[3], nullptr) : 0.3f;
  ModelChoice choice;
  choice.detector = argv[2], choice.trust_torchscript = true;
  const auto detector = make_detector(choice);
  const std::vector<std::string> names = detector->vocabulary();
  std::vector<fs::path> photos;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "images"))
    if (entry.path().extension() == ".jpg") photos.push_back(entry.path());
  std::sort(photos.begin(), photos.end());

  size_t right = 0, found = 0, total = 0;
  std::array<size_t, 3> right_of{}, total_of{};
  double seconds = 0;
  for (const fs::path& file : photos) {
    const ImageF photo = read_image(file);
    fs::path labels = folder / "labels" / fs::relative(file, folder / "images");
    std::vector<Truth> truths = read_truth(labels.replace_extension(".txt"), photo, names);
    const auto start = std::chrono::steady_clock::now();
    const std::vector<Detection> detections = detector->detect(photo, {});
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const Truth& truth : truths) ++total, ++total_of[size_class(truth.area)];
    for (const Detection& detection : detections) {
      if (detection.score < least) continue;
      ++found;
      Truth* best = nullptr;
      for (Truth& truth : truths)
        if (!truth.taken && truth.box.label == detection.label && box_iou(truth.box, detection) >= 0.5f &&
            (!best || box_iou(truth.box, detection) > box_iou(best->box, detection)))
          best = &truth;
      if (!best) continue;
      best->taken = true;
      ++right, ++right_of[size_class(best->area)];
    }
  }
  const auto share = [](size_t part, size_t whole) { return whole ? static_cast<double>(part) / static_cast<double>(whole) : 0; };
  const nlohmann::ordered_json result = {
      {"photos", photos.size()}, {"instances", total}, {"detections", found}, {"recall", share(right, total)},
      {"precision", share(right, found)}, {"recall_below_32", share(right_of[0], total_of[0])},
      {"recall_32_to_96", share(right_of[1], total_of[1])}, {"recall_above_96", share(right_of[2], total_of[2])},
      {"seconds_per_photo", seconds / static_cast<double>(std::max<size_t>(photos.size(), 1))}};
  std::printf("%s\n", result.dump(2).c_str());
}
