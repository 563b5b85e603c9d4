// Selection by gesture against objects given as primitives in numbers (selection_truth.json):
//   selection_study DATA_FOLDER OUT_FOLDER [FILTER [METHOD]]
// Boxes are those of the truth's pixels in cameras 0, 6 and 12 of the scene's orbit (0, 90, 180 degrees), loosened on
// every side by a share of their size.  IoU: pixels with a rendered membership above 0.5, over 12 views of another
// orbit. Strokes: twice, over the scene's cameras, the largest connected wrong region; from its deepest pixel a
// straight line in both directions of its longer axis, as far as it stays inside by half the stroke's width (a click
// where that is nowhere). FILTER: only rows whose name contains it; METHOD: `boxes` leaves the strokes out.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/orbit.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/render/render.h"
#include "segmentation/select/gesture.h"
#include "tests/studies/selection_truth.h"

using namespace pliant;
using Json = nlohmann::ordered_json;

namespace {

using Mask = std::vector<uint8_t>;

Mask rendered(const GaussianCloud& cloud, const Camera& camera, const std::vector<float>& membership) {
  const RenderResult picture = render(cloud, camera, {}, membership, 1);
  Mask mask(picture.features.data.size());
  for (size_t i = 0; i < mask.size(); ++i) mask[i] = picture.features.data[i] > 0.5f;
  return mask;
}

std::vector<float> as_membership(const std::vector<uint8_t>& flags) { return {flags.begin(), flags.end()}; }

std::vector<float> membership_of(const GestureResult& result) {
  std::vector<float> membership(result.probability.size());
  for (size_t p = 0; p < membership.size(); ++p) membership[p] = result.selected(p);
  return membership;
}

struct Study {
  std::string name;
  Scene scene;
  PreparedScene prepared;
  std::vector<float> truth;
  std::vector<Camera> held_out, small;  // small: the scene's cameras at half size, where strokes are placed
  std::vector<Mask> held_out_truth, small_truth;

  Study(std::string scene_name, const std::filesystem::path& data, const nlohmann::json& entry)
      : name(std::move(scene_name)) {
    LoadOptions load;
    const auto up = entry.at("up").get<std::vector<double>>();
    load.up = Eigen::Vector3d(up[0], up[1], up[2]);
    scene = load_scene(data / entry.at("splats").get<std::string>(), load);
    const auto start = std::chrono::steady_clock::now();
    prepared = prepare_scene({}, scene.cloud, scene.cameras);
    std::printf("%s: prepared in %.1f s\n", name.c_str(),
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    truth = as_membership(inside_solid(entry.at("solid"), scene.cloud));
    OrbitOptions orbit;
    orbit.views = 48;
    orbit.elevations = {0, 15, 0, 30};
    const std::vector<Camera> all = orbit_cameras(orbit, scene.cloud, scene.up);
    for (int k = 0; k < 12; ++k) held_out.push_back(all[4 * k + 1 + 2 * (k % 2)]);
    for (const Camera& camera : held_out) held_out_truth.push_back(rendered(scene.cloud, camera, truth));
    for (const Camera& camera : scene.cameras) {
      small.push_back(camera.scaled(0.5));
      small_truth.push_back(rendered(scene.cloud, small.back(), truth));
    }
  }

  GestureResult select(const Gesture& gesture) const {
    GestureOptions options;
    options.up = scene.up.cast<float>();
    return select_by_gesture(options, gesture, {}, scene.cloud, scene.cameras, prepared);
  }

  Gesture boxes(int count, double loosen) const {
    Gesture gesture;
    for (int k = 0; k < count; ++k) {
      const int index = k * static_cast<int>(scene.cameras.size()) / 4;
      const Camera& camera = scene.cameras[index];
      const Mask mask = rendered(scene.cloud, camera, truth);
      BoxPrompt box{index, INFINITY, INFINITY, 0, 0};
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
          if (mask[static_cast<size_t>(y) * camera.width + x]) {
            box.x0 = std::min<float>(box.x0, x);
            box.y0 = std::min<float>(box.y0, y);
            box.x1 = std::max<float>(box.x1, x + 1);
            box.y1 = std::max<float>(box.y1, y + 1);
          }
      const float dx = loosen * (box.x1 - box.x0), dy = loosen * (box.y1 - box.y0);
      box.x0 = std::max(0.0f, box.x0 - dx);
      box.x1 = std::min<float>(camera.width, box.x1 + dx);
      box.y0 = std::max(0.0f, box.y0 - dy);
      box.y1 = std::min<float>(camera.height, box.y1 + dy);
      gesture.boxes.push_back(box);
    }
    return gesture;
  }

  /// Mean and least IoU; pictures of four views when `picture` is not empty: green = right, red = too much, blue =
  /// missing.
  Json measure(const GestureResult& result, const std::filesystem::path& picture) const {
    const std::vector<float> membership = membership_of(result);
    Json json;
    double sum = 0, least = 1;
    ImageF sheet(2 * held_out[0].width, 2 * held_out[0].height, 3);
    for (size_t v = 0; v < held_out.size(); ++v) {
      const Mask mask = rendered(scene.cloud, held_out[v], membership);
      size_t both = 0, either = 0;
      for (size_t i = 0; i < mask.size(); ++i) {
        both += mask[i] && held_out_truth[v][i];
        either += mask[i] || held_out_truth[v][i];
      }
      const double iou = either ? static_cast<double>(both) / static_cast<double>(either) : 1;
      sum += iou;
      least = std::min(least, iou);
      if (v % 3 != 0 || picture.empty()) continue;
      const ImageF color = render(scene.cloud, held_out[v]).color;
      const int x0 = v / 3 % 2 * color.width, y0 = static_cast<int>(v) / 6 * color.height;
      for (int y = 0; y < color.height; ++y)
        for (int x = 0; x < color.width; ++x) {
          const size_t i = static_cast<size_t>(y) * color.width + x;
          Vec3f tint(0, 1, 0);
          if (mask[i] && !held_out_truth[v][i]) tint = Vec3f(1, 0, 0);
          if (!mask[i] && held_out_truth[v][i]) tint = Vec3f(0.1f, 0.2f, 1);
          const float mix = !mask[i] && !held_out_truth[v][i] ? 0.0f : mask[i] && held_out_truth[v][i] ? 0.3f : 0.8f;
          for (int k = 0; k < 3; ++k) sheet(x0 + x, y0 + y, k) = (1 - mix) * color(x, y, k) + mix * tint[k];
        }
    }
    if (!picture.empty()) write_image(picture, sheet);
    size_t same = 0, any = 0;
    for (size_t p = 0; p < truth.size(); ++p) {
      same += truth[p] > 0 && membership[p] > 0;
      any += truth[p] > 0 || membership[p] > 0;
    }
    json["mean"] = sum / static_cast<double>(held_out.size());
    json["min"] = least;
    json["gaussians_iou"] = static_cast<double>(same) / static_cast<double>(any);
    json["seconds"] = result.summary.seconds;
    json["summary"] = result.summary.describe();
    return json;
  }

  StrokePrompt next_stroke(const GestureResult& result) const {
    const std::vector<float> membership = membership_of(result);
    StrokePrompt best;
    cv::Mat region;
    int largest = 0;
    for (size_t c = 0; c < small.size(); ++c) {
      const Mask mask = rendered(scene.cloud, small[c], membership);
      for (bool missing : {false, true}) {
        cv::Mat wrong(small[c].height, small[c].width, CV_8U), number, stats, centres;
        for (size_t i = 0; i < mask.size(); ++i)
          wrong.data[i] = missing ? small_truth[c][i] && !mask[i] : mask[i] && !small_truth[c][i];
        const int count = cv::connectedComponentsWithStats(wrong, number, stats, centres);
        for (int k = 1; k < count; ++k) {
          if (stats.at<int>(k, cv::CC_STAT_AREA) <= largest) continue;
          largest = stats.at<int>(k, cv::CC_STAT_AREA);
          best.camera = static_cast<int>(c);
          best.foreground = missing;
          region = number == k;
        }
      }
    }
    if (largest == 0) return best;
    cv::Mat depth, padded;
    cv::copyMakeBorder(region, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
    cv::distanceTransform(padded, depth, cv::DIST_L2, 5);
    depth = depth(cv::Rect(1, 1, region.cols, region.rows));
    cv::Point deepest;
    cv::minMaxLoc(depth, nullptr, nullptr, nullptr, &deepest);
    const cv::Moments m = cv::moments(region, true);
    const double angle = 0.5 * std::atan2(2 * m.mu11, m.mu20 - m.mu02);
    const float reach = 0.25f * best.width;  // half the width, at half size
    for (double side : {-1.0, 1.0}) {
      double t = 0;
      const auto at = [&](double s) {
        return cv::Point(cvRound(deepest.x + side * s * std::cos(angle)),
                         cvRound(deepest.y + side * s * std::sin(angle)));
      };
      while (cv::Rect(0, 0, depth.cols, depth.rows).contains(at(t + 1)) && depth.at<float>(at(t + 1)) > reach) ++t;
      best.points.push_back(Vec2f(2 * at(t).x + 1, 2 * at(t).y + 1));
    }
    if ((best.points[0] - best.points[1]).norm() < 2) {
      best.points.pop_back();
      best.width = std::min<float>(best.width, 4 * depth.at<float>(deepest));
    }
    return best;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s DATA_FOLDER OUT_FOLDER [FILTER [METHOD]]\n", argv[0]), 2;
  const std::filesystem::path out = argv[2], here = std::filesystem::path(PLIANT_SOURCE_DIR) / "tests/studies";
  const std::string filter = argc > 3 ? argv[3] : "", only = argc > 4 ? argv[4] : "";
  std::filesystem::create_directories(out);
  const auto truths = nlohmann::json::parse(std::ifstream(here / "selection_truth.json"));
  Json rows;
  for (const auto& [scene_name, entry] : truths.items()) {
    if (filter.find("seal") != std::string::npos && scene_name != "seal") continue;
    if (filter.find("daffodils") != std::string::npos && scene_name != "daffodils") continue;
    const Study study(scene_name, argv[1], entry);
    for (int loosen : {3, 8})
      for (int count : {1, 3}) {
        const std::string row = scene_name + "_" + std::to_string(loosen) + "_" + std::to_string(count);
        if (row.find(filter) == std::string::npos) continue;
        Gesture gesture = study.boxes(count, 0.01 * loosen);
        auto report = [&](const std::string& method, const GestureResult& result) {
          const Json json = rows[row][method] = study.measure(result, out / (row + "_" + method + ".png"));
          std::printf("%-16s %-10s mean %.3f min %.3f  3D %.3f  %.2f s  %s\n", row.c_str(), method.c_str(),
                      json["mean"].get<double>(), json["min"].get<double>(), json["gaussians_iou"].get<double>(),
                      result.summary.seconds, result.summary.describe().c_str());
          std::fflush(stdout);
        };
        GestureResult result = study.select(gesture);
        report("ours", result);
        if (only == "boxes") continue;
        for (int k = 1; k <= 2; ++k) {
          const StrokePrompt stroke = study.next_stroke(result);
          if (stroke.points.empty()) break;
          gesture.strokes.push_back(stroke);
          result = study.select(gesture);
          const std::string method = "stroke" + std::to_string(k);
          report(method, result);
          rows[row][method]["stroke"] = {{"foreground", stroke.foreground},
                                         {"camera", stroke.camera},
                                         {"from", {stroke.points[0].x(), stroke.points[0].y()}},
                                         {"to", {stroke.points.back().x(), stroke.points.back().y()}}};
        }
      }
  }
  std::ofstream(out / "selection.json") << rows.dump(1) << "\n";
}
