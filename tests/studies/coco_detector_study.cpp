// The detector of FILE on the photos of masks_coco64: coco_detector_study DATA_FOLDER/masks_coco64 FILE [SCORE]
// A detection is right when its name is that of a truth not yet taken and their boxes overlap by an IoU of 0.5, best
// first. Every right one is then the prompt of the segmenter without weights: mean IoU of its masks, by size.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "gaussians/io/images/image_io.h"
#include "segmentation/labelling/grab_cut_segmenter.h"
#include "segmentation/models/boxes.h"
#include "segmentation/models/make_models.h"
#include "tests/studies/coco_instances.h"

using namespace pliant;
namespace fs = std::filesystem;

namespace {

struct Truth : CocoInstance {
  Detection detection;  // its box and name
  bool taken = false;
};

std::vector<Truth> read_truth(const fs::path& file, const ImageF& photo, const std::vector<std::string>& names) {
  std::vector<Truth> truths;
  for (CocoInstance& instance : read_instances(file, photo.width, photo.height)) {
    Truth truth{std::move(instance), {}, false};
    truth.detection.label = names.at(truth.category);
    truth.detection.x0 = truth.box.x0;
    truth.detection.x1 = truth.box.x1;
    truth.detection.y0 = truth.box.y0;
    truth.detection.y1 = truth.box.y1;
    truths.push_back(std::move(truth));
  }
  return truths;
}

size_t size_class(double area) { return area < 32 * 32 ? 0 : area < 96 * 96 ? 1 : 2; }

/// IoU of masks of the objects above so many pixels.
struct MaskScore {
  double least = 0, sum = 0;
  size_t count = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "coco_detector_study DATA_FOLDER/masks_coco64 FILE [SCORE]\n"), 2;
  const fs::path folder = argv[1];
  const float least = argc > 3 ? std::strtof(argv[3], nullptr) : 0.3f;
  ModelChoice choice;
  choice.detector = argv[2];
  choice.trust_torchscript = true;
  const auto detector = make_detector(choice);
  const std::vector<std::string> names = detector->vocabulary();
  std::vector<fs::path> photos;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "images"))
    if (entry.path().extension() == ".jpg") photos.push_back(entry.path());
  std::sort(photos.begin(), photos.end());

  size_t right = 0, found = 0, total = 0;
  std::array<size_t, 3> right_of{}, total_of{};
  double seconds = 0, segmenting = 0;
  std::array<MaskScore, 4> scores = {{{0}, {32}, {64}, {96}}};
  GrabCutSegmenter segmenter;
  for (const fs::path& file : photos) {
    const ImageF photo = read_image(file);
    fs::path labels = folder / "labels" / fs::relative(file, folder / "images");
    std::vector<Truth> truths = read_truth(labels.replace_extension(".txt"), photo, names);
    bool encoded = false;
    const auto start = std::chrono::steady_clock::now();
    const std::vector<Detection> detections = detector->detect(photo, {});
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const Truth& truth : truths) {
      ++total;
      ++total_of[size_class(truth.pixels)];
    }
    for (const Detection& detection : detections) {
      if (detection.score < least) continue;
      ++found;
      Truth* best = nullptr;
      for (Truth& truth : truths)
        if (!truth.taken && truth.detection.label == detection.label && box_iou(truth.detection, detection) >= 0.5f &&
            (!best || box_iou(truth.detection, detection) > box_iou(best->detection, detection)))
          best = &truth;
      if (!best) continue;
      best->taken = true;
      ++right;
      ++right_of[size_class(best->pixels)];
      const auto before = std::chrono::steady_clock::now();
      if (!encoded) {
        segmenter.encode(photo);
        encoded = true;
      }
      const double iou = mask_iou(
          best->mask, segmenter.segment({MaskPrompt::Box{detection.x0, detection.y0, detection.x1, detection.y1}, {}})
                          .front()
                          .logits);
      segmenting += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
      for (MaskScore& score : scores)
        if (best->pixels > score.least * score.least) {
          score.sum += iou;
          ++score.count;
        }
    }
  }
  const auto share = [](size_t part, size_t whole) {
    return whole ? static_cast<double>(part) / static_cast<double>(whole) : 0;
  };
  nlohmann::ordered_json result = {
      {"photos", photos.size()},
      {"instances", total},
      {"detections", found},
      {"recall", share(right, total)},
      {"precision", share(right, found)},
      {"recall_below_32", share(right_of[0], total_of[0])},
      {"recall_32_to_96", share(right_of[1], total_of[1])},
      {"recall_above_96", share(right_of[2], total_of[2])},
      {"seconds_per_photo", seconds / static_cast<double>(std::max<size_t>(photos.size(), 1))}};
  for (const MaskScore& score : scores) {
    auto& row = result["masks_of_matched"][">" + std::to_string(static_cast<int>(score.least)) + "^2"];
    row = {{"instances", score.count}, {"iou", score.sum / static_cast<double>(std::max<size_t>(score.count, 1))}};
  }
  result["seconds_per_mask"] = segmenting / static_cast<double>(std::max<size_t>(right, 1));
  std::printf("%s\n", result.dump(2).c_str());
}
