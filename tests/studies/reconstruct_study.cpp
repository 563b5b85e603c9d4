// How good a scene made by `pliant reconstruct` or `pliant segment --joint` is on the photos that were held out:
//   reconstruct_study SCENE [--silhouette LEVEL] [--segmentation FILE --masks FOLDER]
// --silhouette: PSNR also over the pixels of the object alone, in photos with a black background: grey above LEVEL,
// closed, largest component, holes filled.  --masks: mIoU of the rendered labels with id pictures of the held-out
// photos. Prints JSON.

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "app/store/segmentation.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/render/image_loss.h"
#include "gaussians/render/render.h"
#include "segmentation/labels/mask_set.h"

using namespace pliant;
using nlohmann::json;

namespace {

/// 1 on the object, 0 beside it.
ImageF silhouette(const ImageF& photo, float level) {
  cv::Mat above(photo.height, photo.width, CV_8U);
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x)
      above.at<uint8_t>(y, x) = (photo(x, y, 0) + photo(x, y, 1) + photo(x, y, 2)) / 3 > level ? 255 : 0;
  cv::morphologyEx(above, above, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(above, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto largest = std::max_element(contours.begin(), contours.end(), [](const auto& a, const auto& b) {
    return cv::contourArea(a) < cv::contourArea(b);
  });
  cv::Mat filled = cv::Mat::zeros(above.size(), CV_8U);
  if (largest != contours.end())
    cv::drawContours(filled, contours, static_cast<int>(largest - contours.begin()), 255, cv::FILLED);
  ImageF out(photo.width, photo.height, 1, 0.0f);
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) out(x, y) = filled.at<uint8_t>(y, x) ? 1.0f : 0.0f;
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::string scene_folder, masks, segmentation_file;
  double level = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--silhouette" && i + 1 < argc)
      level = std::stod(argv[++i]);
    else if (word == "--masks" && i + 1 < argc)
      masks = argv[++i];
    else if (word == "--segmentation" && i + 1 < argc)
      segmentation_file = argv[++i];
    else
      scene_folder = word;
  }
  const Scene scene = load_scene(scene_folder);
  const json results = json::parse(read_text(scene_folder + "/results.json"));
  MaskSet truth_masks;
  Segmentation segmentation;
  if (!masks.empty()) {
    truth_masks = load_masks(masks, {}, scene.cameras);
    segmentation = read_segmentation(segmentation_file.empty() ? scene_folder + "/segmentation.h5" : segmentation_file);
  }
  json out = {
      {"gaussians", scene.cloud.size()}, {"iterations", results["iterations"]}, {"seconds", results["seconds"]}};
  double psnr = 0, similarity = 0, object_error = 0, object_pixels = 0;
  std::vector<IdImage> predicted, truth;
  for (const json& held_out : results["held_out"]) {
    const auto camera = std::find_if(scene.cameras.begin(), scene.cameras.end(),
                                     [&](const Camera& c) { return c.name == held_out["name"]; });
    const ImageF photo = read_image(camera->photo);
    ImageF picture = render(scene.cloud, *camera).color;
    for (float& value : picture.data) value = std::clamp(value, 0.0f, 1.0f);
    const double share = 1.0 / results["held_out"].size();
    psnr += share * psnr_of_mse(mse_loss(picture, photo));
    similarity += share * ssim(picture, photo, {}, SsimWindows::kInside);
    if (level > 0) {
      const ImageF object = silhouette(photo, static_cast<float>(level));
      const double pixels = std::count(object.data.begin(), object.data.end(), 1.0f);
      object_error += mse_loss(picture, photo, object) * pixels;
      object_pixels += pixels;
    }
    for (const MaskSet::View& view : truth_masks.views) {
      if (view.camera != camera - scene.cameras.begin()) continue;
      predicted.push_back(render_ids(segmentation, scene.cloud, *camera));
      truth.push_back(view.ids);
    }
  }
  out["psnr"] = psnr;
  out["ssim"] = similarity;
  if (level > 0) out["object_psnr"] = psnr_of_mse(object_error / object_pixels);
  if (!predicted.empty()) {
    const IdAgreement agreement = id_agreement(predicted, truth);
    out["miou"] = agreement.mean;
    for (const auto& [id, iou] : agreement.iou) out["iou"][std::to_string(id)] = iou;
  }
  std::printf("%s\n", out.dump(2).c_str());
}
