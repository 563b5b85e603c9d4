// Masks of a promptable segmenter from the boxes of COCO's instances, against their polygons:
//   coco_study DATA_FOLDER OUT_FOLDER [KEY=VALUE...]
// DATA_FOLDER/masks_coco64: images/train2017/*.jpg and labels/train2017/*.txt, each line of which is a class and the
// corners of a polygon in shares of the picture.  Beside the segmenter: the box itself and the ellipse inscribed in it.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gaussians/base/portable.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/labelling/grab_cut_segmenter.h"
#include "segmentation/labelling/mask_measures.h"
#include "tests/studies/coco_instances.h"

using namespace pliant;
namespace fs = std::filesystem;

namespace {

struct Measured : CocoInstance {
  int photo = 0;
  double iou[3] = {}, seconds = 0, predicted = 0;  // of: box, ellipse, segmenter
};

ImageF filled(const MaskPrompt::Box& box, int width, int height, bool ellipse) {
  ImageF mask(width, height, 1, -1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float u = (x + 0.5f - box.x0) / (box.x1 - box.x0) * 2 - 1,
                  v = (y + 0.5f - box.y0) / (box.y1 - box.y0) * 2 - 1;
      if (ellipse ? u * u + v * v <= 1 : std::max(std::abs(u), std::abs(v)) <= 1) mask(x, y) = 1;
    }
  return mask;
}

GrabCutSegmenterOptions options_of(int argc, char** argv) {
  GrabCutSegmenterOptions options;
  for (int k = 3; k < argc; ++k) {
    const std::string word = argv[k], key = word.substr(0, word.find('='));
    const float value = std::strtof(word.c_str() + key.size() + 1, nullptr);
    if (key == "window") options.window = static_cast<int>(value);
    if (key == "gamma") options.cut.gamma = value;
    if (key == "data") options.cut.data = value;
    if (key == "iterations") options.cut.iterations = static_cast<int>(value);
    if (key == "components") options.cut.color.components = static_cast<int>(value);
    if (key == "core") options.core = value;
    if (key == "shape") options.shape = value;
    if (key == "part") options.least_part = value;
    if (key == "hole") options.least_hole = value;
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s DATA_FOLDER OUT_FOLDER [KEY=VALUE...]\n", argv[0]), 2;
  const fs::path data = fs::path(argv[1]) / "masks_coco64", out = argv[2];
  fs::create_directories(out);
  const GrabCutSegmenterOptions options = options_of(argc, argv);
  std::vector<fs::path> photos;
  for (const auto& entry : fs::directory_iterator(data / "images/train2017")) photos.push_back(entry.path());
  std::sort(photos.begin(), photos.end());
  std::vector<std::vector<Measured>> found(photos.size());
  parallel_for(static_cast<std::ptrdiff_t>(photos.size()), [&](std::ptrdiff_t k) {
    const ImageF photo = read_image(photos[k]);
    GrabCutSegmenter segmenter(options);
    segmenter.encode(photo);
    for (CocoInstance& read :
         read_instances(data / "labels/train2017" / photos[k].stem().concat(".txt"), photo.width, photo.height)) {
      Measured instance{std::move(read)};
      instance.photo = static_cast<int>(k);
      const double start = omp_get_wtime();
      const SegmentedMask mask = segmenter.segment({instance.box, {}}).front();
      instance.seconds = omp_get_wtime() - start;
      instance.predicted = mask.predicted_iou;
      for (int m = 0; m < 2; ++m)
        instance.iou[m] = mask_iou(instance.mask, filled(instance.box, photo.width, photo.height, m));
      instance.iou[2] = mask_iou(instance.mask, mask.logits);
      instance.mask = {};
      found[k].push_back(std::move(instance));
    }
  });
  std::vector<Measured> all;
  for (auto& of_photo : found) all.insert(all.end(), of_photo.begin(), of_photo.end());
  nlohmann::ordered_json rows;
  const char* names[3] = {"box", "ellipse", "segmenter"};
  // Photos with odd numbers check what was chosen on even ones.
  for (const std::string part : {"all", "even", "odd"}) {
    std::printf("%-6s", part.c_str());
    for (const int side : {0, 32, 64, 96}) {
      double sum[3] = {}, seconds = 0, predicted = 0;
      size_t count = 0;
      for (const Measured& instance : all) {
        if (instance.pixels <= side * side || (part == "even" && instance.photo % 2) ||
            (part == "odd" && instance.photo % 2 == 0))
          continue;
        for (int m = 0; m < 3; ++m) sum[m] += instance.iou[m];
        seconds += instance.seconds;
        predicted += std::abs(instance.predicted - instance.iou[2]);
        ++count;
      }
      auto& row = rows[part][">" + std::to_string(side) + "^2"];
      row["instances"] = count;
      row["seconds"] = seconds / count;
      row["predicted_iou_error"] = predicted / count;
      for (int m = 0; m < 3; ++m) row[names[m]] = sum[m] / count;
      std::printf(" | >%2d^2 %3zu ellipse %.3f segmenter %.3f", side, count, sum[1] / count, sum[2] / count);
      if (side == 0) std::printf(" (%.3f s, predicted off by %.3f)", seconds / count, predicted / count);
    }
    std::printf("\n");
  }
  std::ofstream(out / "coco.json") << rows.dump(1) << "\n";
}
