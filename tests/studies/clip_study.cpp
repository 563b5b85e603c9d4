// What a clip must keep still and what a repair must match, measured on a finished run: median optical flow of every
// object that is not moved, and the luminance of the filled hole against the ring around it.  Prints JSON.
// Usage: clip_study SCENE RUN

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "app/run/run_directory.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/splats/ply.h"
#include "segmentation/labels/mask_set.h"
#include "segmentation/repair/hole.h"

namespace pliant {
namespace {

using nlohmann::json;

double median(std::vector<float>& values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Largest median flow [px] of each id between the first frame and every fifth one.
json still_objects(const Scene& scene, const std::string& clip, const std::string& camera_name, uint32_t moved) {
  const MaskSet masks = load_masks(scene.settings.masks, scene.settings.labels, scene.cameras);
  const IdImage* ids = nullptr;
  for (const MaskSet::View& view : masks.views)
    if (scene.cameras[view.camera].name == camera_name) ids = &view.ids;
  const auto video = codecs::open_video(clip);
  cv::Mat frame, first, grey, flow;
  const auto dis = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM);
  std::map<uint32_t, double> largest;
  for (int f = 0; video->read(frame); ++f) {
    cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
    if (f == 0) {
      first = grey.clone();
      continue;
    }
    if (f % 5) continue;
    dis->calc(first, grey, flow);
    std::map<uint32_t, std::pair<std::vector<float>, std::vector<float>>> parts;
    for (int y = 0; y < flow.rows; ++y)
      for (int x = 0; x < flow.cols; ++x) {
        const cv::Vec2f d = flow.at<cv::Vec2f>(y, x);
        parts[(*ids)(x, y)].first.push_back(d[0]);
        parts[(*ids)(x, y)].second.push_back(d[1]);
      }
    for (auto& [id, d] : parts)
      if (id != 0 && id != moved) largest[id] = std::max(largest[id], std::hypot(median(d.first), median(d.second)));
  }
  json out;
  for (const auto& [id, pixels] : largest) out[masks.name_of(id)] = pixels;
  return out;
}

/// Difference of mean luminance of hole and ring, in standard deviations of the ring, per view.
json hole_luminance(const Scene& scene, const RunDirectory& run, const std::string& folder) {
  const GaussianCloud background = read_ply(run / "background.ply"), object = read_ply(run / (folder + "/object.ply"));
  const GaussianCloud repaired = read_ply(run / "background_repaired.ply");
  std::vector<int> views;
  for (int c = 0; c < static_cast<int>(scene.cameras.size()); c += 2) views.push_back(c);
  const Observation observation = observe({}, background, object, scene.cameras, views);
  std::vector<double> sigmas;
  size_t open = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const HoleView hole = find_hole({}, observation, v, background, scene.cameras);
    if (hole.pixels < 100) continue;
    open += hole.pixels;
    const ImageF picture = render(repaired, scene.cameras[views[v]]).color;
    cv::Mat inside(picture.height, picture.width, CV_8U, const_cast<uint8_t*>(hole.hole.data.data())), near, far;
    cv::dilate(inside, near, cv::Mat::ones(5, 5, CV_8U));
    cv::dilate(inside, far, cv::Mat::ones(25, 25, CV_8U));
    double in = 0, ring = 0, squares = 0;
    size_t in_count = 0, ring_count = 0;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        const double luminance = 0.299 * picture(x, y, 0) + 0.587 * picture(x, y, 1) + 0.114 * picture(x, y, 2);
        if (inside.at<uint8_t>(y, x)) {
          in += luminance;
          ++in_count;
        } else if (far.at<uint8_t>(y, x) && !near.at<uint8_t>(y, x)) {
          ring += luminance;
          squares += luminance * luminance;
          ++ring_count;
        }
      }
    const double mean = ring / ring_count;
    sigmas.push_back(std::abs(in / in_count - mean) / std::sqrt(squares / ring_count - mean * mean));
  }
  double sum = 0;
  for (double s : sigmas) sum += s;
  return {{"views", sigmas.size()},
          {"hole_pixels", open},
          {"mean_sigma", sigmas.empty() ? 0 : sum / sigmas.size()},
          {"worst_sigma", sigmas.empty() ? 0 : *std::max_element(sigmas.begin(), sigmas.end())}};
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  if (argc != 3) return std::fprintf(stderr, "usage: clip_study SCENE RUN\n"), 2;
  const Scene scene = load_scene(argv[1]);
  const RunDirectory run = RunDirectory::open(argv[2]);
  const nlohmann::json& extract = run.summary("extract", "");
  const nlohmann::json result = {
      {"still_objects_px",
       still_objects(scene, (run / "clip.mp4").string(), run.summary("render", "")["camera"], extract["id"])},
      {"hole", hole_luminance(scene, run, extract["folder"])},
      {"motion", run.summary("simulate", "")["motion"]}};
  std::printf("%s\n", result.dump(2).c_str());
  return 0;
}
