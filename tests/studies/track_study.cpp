// A mask carried through a video: track_study DATA_FOLDER OUT_FOLDER [KEY=VALUE...]
// DATA_FOLDER/video_bmx: bmx-trees/*.jpg and bmx-trees_mask/*.png.  The tracker gets the mask of picture 0; written are
// the overlap with the true mask in every picture, where it said that the rider is lost, and overlays of some pictures.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gaussians/io/images/image_io.h"
#include "segmentation/labelling/flow_tracker.h"
#include "segmentation/sheets/objects_sheet.h"

using namespace pliant;
namespace fs = std::filesystem;

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s DATA_FOLDER OUT_FOLDER\n", argv[0]), 2;
  const fs::path data = fs::path(argv[1]) / "video_bmx", out = argv[2];
  fs::create_directories(out);
  const auto sorted = [](const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
  };
  const std::vector<fs::path> pictures = sorted(data / "bmx-trees"), masks = sorted(data / "bmx-trees_mask");
  const auto truth_of = [&](size_t k) {
    const ImageF mask = read_image(masks[k]);
    IdImage ids(mask.width, mask.height, 1);
    for (size_t i = 0; i < ids.data.size(); ++i)
      ids.data[i] = mask.data[3 * i] > 0.02f || mask.data[3 * i + 1] > 0.02f || mask.data[3 * i + 2] > 0.02f;
    return ids;
  };
  FlowTrackerOptions options;
  for (int k = 3; k < argc; ++k) {
    const std::string word = argv[k], key = word.substr(0, word.find('='));
    const float value = std::strtof(word.c_str() + key.size() + 1, nullptr);
    if (key == "prior") options.prior = value;
    if (key == "data") options.cut.data = value;
    if (key == "gamma") options.cut.gamma = value;
    if (key == "border") options.border = value;
    if (key == "context") options.context = value;
    if (key == "recall") options.recall_alike = value;
    if (key == "common") options.recall_common = value;
    if (key == "doubt") options.doubt = value;
    if (key == "iterations") options.cut.iterations = static_cast<int>(value);
    if (key == "alike") options.least_alike = value;
    if (key == "consistent") options.consistent = value;
  }
  FlowTracker tracker(options);
  tracker.start(read_image(pictures[0]), truth_of(0));
  nlohmann::ordered_json rows;
  double first = 0, followed = 0;
  int kept = 0, wrong = 0;
  const auto start = std::chrono::steady_clock::now();
  for (size_t k = 1; k < std::min(pictures.size(), masks.size()); ++k) {
    const ImageF picture = read_image(pictures[k]);
    const TrackedFrame frame = tracker.step(picture);
    const IdImage truth = truth_of(k);
    size_t both = 0, either = 0;
    for (size_t i = 0; i < truth.data.size(); ++i) {
      both += truth.data[i] && frame.ids.data[i];
      either += truth.data[i] || frame.ids.data[i];
    }
    const double iou = either ? static_cast<double>(both) / static_cast<double>(either) : 1;
    const bool lost = !frame.lost.empty();
    rows.push_back({{"picture", k}, {"iou", iou}, {"lost", lost}});
    if (k <= 10) first += iou / 10;
    if (!lost) {
      followed += iou;
      ++kept;
      wrong += iou < 0.2;
    }
    std::printf("%2zu %s %.3f\n", k, lost ? "lost" : "    ", iou);
    if (k % 5 == 0) write_image(out / (pictures[k].stem().string() + ".jpg"), overlay_ids(picture, frame.ids));
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("mean of pictures 1-10: %.3f; %d pictures followed at %.3f, %d of them wrongly; %.2f s a picture\n",
              first, kept, followed / std::max(1, kept), wrong, seconds / static_cast<double>(rows.size()));
  std::ofstream(out / "track.json") << rows.dump(1) << "\n";
}
