#include <cmath>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/evaluate/self_test.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

ImageF plain(int width, int height, int level) { return ImageF(width, height, 3, static_cast<float>(level) / 255); }

/// A square of id `inside` at (left, top), id `outside` around it.
IdImage square(int left, int top, int side, uint32_t inside = 1, uint32_t outside = 2) {
  IdImage ids(60, 60, 1, outside);
  for (int y = top; y < top + side; ++y)
    for (int x = left; x < left + side; ++x) ids(x, y) = inside;
  return ids;
}

/// The same as a mask: white square, black rest, `scale` times as large.
ImageF mask_of_square(int left, int top, int side, int scale = 1) {
  ImageF mask(60 * scale, 60 * scale, 3);
  for (int y = top * scale; y < (top + side) * scale; ++y)
    for (int x = left * scale; x < (left + side) * scale; ++x)
      for (int c = 0; c < 3; ++c) mask(x, y, c) = 1;
  return mask;
}

// Intersection over union of squares of 20 px, 5 px apart.
constexpr double kShiftedIou = 15.0 * 20 / (2 * 400 - 15 * 20);
// The contours of a square of 20 px and of one that is larger by 1 px on each side, 2 px wide, have its outermost ring
// in common, of 3 rings together.
constexpr double kGrownBoundaryIou = 4.0 * 19 / (22 * 22 - 16 * 16);

}  // namespace

void check_images(SelfTest& test) {
  write_image(test.place("images/truth/a.png"), plain(200, 180, 100));
  write_image(test.place("images/bright/a.png"), plain(200, 180, 110));
  json same = evaluate_images(test.place("images/truth"), test.place("images/truth"));
  test.check_metric("images", "psnr", "identical pictures", kPsnrOfIdentical, same, 0);
  test.check_metric("images", "ssim", "identical pictures", 1, same, 1e-12);
  test.check_metric("images", "ms_ssim", "identical pictures", 1, same, 1e-12);
  const json offset = evaluate_images(test.place("images/bright"), test.place("images/truth"));
  const double a = 100 / 255.0, b = 110 / 255.0, c1 = 1e-4, luminance = (2 * a * b + c1) / (a * a + b * b + c1);
  test.check_metric("images", "mse", "offset by 10 of 255 levels", std::pow(10 / 255.0, 2), offset, 1e-8);
  test.check_metric("images", "psnr", "offset by 10 of 255 levels", 20 * std::log10(25.5), offset, 1e-4);
  test.check_metric("images", "ssim", "two plain pictures: luminance alone", luminance, offset, 1e-6);
  test.check_metric("images", "ms_ssim", "two plain pictures: luminance of the coarsest scale",
                    std::pow(luminance, 0.1333), offset, 1e-6);
}

void check_segmentation(SelfTest& test) {
  const auto score = [&](const std::string& name, const IdImage& ids, const SegmentationScore& how = {}) {
    write_ids(test.place("segmentation/" + name + "/a.png"), ids);
    return evaluate_segmentation(test.place("segmentation/" + name), test.place("segmentation/truth"), how);
  };
  write_ids(test.place("segmentation/truth/a.png"), square(20, 20, 20));
  const double rest = (3600 - 500) / (3600.0 - 300);  // IoU of what lies around the shifted squares
  const json shifted = score("shifted", square(25, 20, 20));
  test.check_metric("segmentation", "miou", "square shifted by a quarter", 0.5 * (kShiftedIou + rest), shifted, 1e-12);
  test.check_metric("segmentation", "accuracy", "square shifted by a quarter", 1 - 200 / 3600.0, shifted, 1e-12);
  SegmentationScore band;
  band.band = 2;
  const json grown = score("grown", square(19, 19, 22), band);
  test.check("segmentation", "boundary_iou", "square grown by 1 px, bands of 2 px", kGrownBoundaryIou,
             grown["per_id"]["1"]["boundary_iou"], 1e-12);
  test.check_metric("segmentation", "boundary_miou", "identical", 1, score("same", square(20, 20, 20)), 0);
  test.check_metric("segmentation", "miou", "labels swapped", 0, score("swapped", square(20, 20, 20, 2, 1)), 0);
  SegmentationScore overlap;
  overlap.match = "overlap";
  test.check_metric("segmentation", "miou", "labels swapped, matched by overlap", 1,
                    score("matched", square(20, 20, 20, 2, 1), overlap), 0);
  write_ids(test.place("segmentation/two/a.png"), square(20, 20, 20));
  write_ids(test.place("segmentation/two/b.png"), square(20, 20, 20));
  test.check_metric("segmentation", "miou", "one of two pictures missing", 0.5,
                    evaluate_segmentation(test.place("segmentation/same"), test.place("segmentation/two")), 1e-12);
}

void check_lerf_mask(SelfTest& test) {
  const ImageF truth = mask_of_square(20, 20, 20);
  write_image(test.place("lerf/truth/test_mask/0/cup.png"), truth);
  write_image(test.place("lerf/truth/test_mask/1/cup.png"), truth);
  write_image(test.place("lerf/ours/0/cup.png"), mask_of_square(25, 20, 20));
  const fs::path ours = test.place("lerf/ours"), theirs = test.place("lerf/truth");
  const json one = evaluate_lerf_mask(ours, theirs);
  test.check_metric("lerf-mask", "miou", "shifted by a quarter, other view missing", kShiftedIou / 2, one, 1e-12);
  test.check_metric("lerf-mask", "paper_compatible.miou", "shifted by a quarter, other view missing", kShiftedIou, one,
                    1e-12);
  // 2 % of the diagonal of 60 x 60 are 1.7 px.
  write_image(test.place("lerf/ours/0/cup.png"), mask_of_square(19, 19, 22));
  write_image(test.place("lerf/ours/1/cup.png"), mask_of_square(20, 20, 20, 2));
  const json two = evaluate_lerf_mask(ours, theirs);
  test.check_metric("lerf-mask", "boundary_miou", "grown by 1 px, other view of twice the size", kGrownBoundaryIou / 2,
                    two, 1e-12);
  test.check_metric("lerf-mask", "paper_compatible.boundary_miou", "grown by 1 px, other view of twice the size",
                    (kGrownBoundaryIou + 1) / 2, two, 1e-12);
}

void check_nvos(SelfTest& test) {
  write_image(test.place("nvos/truth/masks/fern/IMG_4027_mask.png"), mask_of_square(20, 20, 20));
  write_image(test.place("nvos/truth/masks/trex/DJI_20200223_163619_411_mask.png"), mask_of_square(20, 20, 20));
  write_image(test.place("nvos/ours/fern/IMG_4027.png"), mask_of_square(25, 20, 20));
  const json one = evaluate_nvos(test.place("nvos/ours"), test.place("nvos/truth"));
  test.check_metric("nvos", "miou", "shifted by a quarter, other scene missing", kShiftedIou / 2, one, 1e-12);
  test.check_metric("nvos", "accuracy", "shifted by a quarter, other scene missing", (1 - 200 / 3600.0) / 2, one,
                    1e-12);
  write_image(test.place("nvos/ours/fern/IMG_4027.png"), mask_of_square(19, 19, 22));
  write_image(test.place("nvos/ours/trex.png"), mask_of_square(20, 20, 20, 2));
  test.check_metric("nvos", "boundary_miou", "grown by 1 px, other scene of twice the size",
                    (kGrownBoundaryIou + 1) / 2, evaluate_nvos(test.place("nvos/ours"), test.place("nvos/truth")),
                    1e-12);
}

void check_repair(SelfTest& test) {
  // A wall that fills two views.  Its colour is 20 levels off without the repair; with it, 5 levels off from the one
  // camera and 15 from the other, which look at it from the left and from the right.
  const fs::path scene = test.place("repair/scene"), run = test.place("repair/run");
  std::vector<Camera> cameras;
  for (const int side : {-1, 1}) {
    Camera camera;
    camera.name = side < 0 ? "left" : "right";
    camera.width = camera.height = 40;
    camera.fx = camera.fy = 40;
    camera.cx = camera.cy = 20;
    camera.cam_from_world.translation() = Eigen::Vector3d(-0.2 * side, 0, 0);
    cameras.push_back(camera);
    IdImage hidden(40, 40, 1);
    for (int y = 10; y < 30; ++y)
      for (int x = 10; x < 30; ++x) hidden(x, y) = 2;  // never seen
    write_ids(test.place("repair/scene/truth/hidden/" + camera.name + ".png"), hidden);
    write_image(test.place("repair/scene/truth/without_object/" + camera.name + ".png"), plain(40, 40, 100));
    write_image(test.place("repair/scene/photos/" + camera.name + ".png"), plain(40, 40, 120));
  }
  write_cameras(scene / "transforms.json", cameras);
  const auto wall = [](double level, double slope) {
    constexpr double kSh0 = 0.28209479177387814, kSh1 = 0.4886025119029199;
    GaussianCloud cloud;
    cloud.sh_degree = 1;
    cloud.resize(4);
    for (size_t i = 0; i < cloud.size(); ++i) {
      cloud.position[i] = Vec3f(0, 0, 5);
      cloud.log_scale[i] = Vec3f(4, 4, -3);
      cloud.opacity_logit[i] = 2.5f;
      // The direction to the wall from a camera at x = -0.2 has x = 0.2 / |(0.2, 5)|.
      const double x = 0.2 / std::hypot(0.2, 5.0);
      for (int c = 0; c < 3; ++c) {
        cloud.sh_of(i)[c] = static_cast<float>((level / 255 - 0.5) / kSh0);
        cloud.sh_of(i)[9 + c] = static_cast<float>(-slope / 255 / (kSh1 * x));
      }
    }
    return cloud;
  };
  fs::create_directories(run);
  write_ply(run / "background.ply", wall(120, 0));
  write_ply(run / "background_repaired.ply", wall(110, -5));
  const json found = evaluate_repair(run, scene);
  const auto psnr = [](double square) { return 10 * std::log10(255 * 255 / square); };
  const double both = psnr((5 * 5 + 15 * 15) / 2.0);
  test.check_metric("repair", "psnr", "wall 5 and 15 of 255 levels off", both, found, 0.1);
  test.check_metric("repair", "gain_over_opencv", "the photo is 20 levels off", both - psnr(20 * 20), found, 0.1);
  test.check_metric("repair", "consistency_psnr", "views differ by 10 levels", psnr(10 * 10), found, 0.1);
  test.check_metric("repair", "outside.psnr", "changed by 5 and 15 levels", both, found, 0.1);
}

}  // namespace pliant
