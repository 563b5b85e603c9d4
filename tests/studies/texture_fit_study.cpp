// Gaussians in front of one camera, optimised by Adam through the rasteriser until they look like a photo: the PSNR
// curve, and the same curve for another number of threads, which must be equal bit for bit.
//
//   texture_fit_study PHOTO OUT [--gaussians 2000] [--iterations 1000] [--width 240]

#include <omp.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/adam.h"
#include "gaussians/base/memory.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/render/image_loss.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace {

constexpr float kDistance = 4;

ImageF resized(const ImageF& image, int width) {
  const int height = static_cast<int>(std::lround(static_cast<double>(image.height) * width / image.width));
  const cv::Mat from(image.height, image.width, CV_32FC3, const_cast<float*>(image.data.data()));
  ImageF out(width, height, 3);
  cv::Mat to(height, width, CV_32FC3, out.data.data());
  cv::resize(from, to, to.size(), 0, 0, cv::INTER_AREA);
  return out;
}

// Small grey Gaussians spread over the picture, at depths around kDistance.
GaussianCloud start_cloud(int n, const Camera& camera) {
  GaussianCloud cloud;
  cloud.resize(n);
  const double spacing = kDistance / camera.fx * std::sqrt(static_cast<double>(camera.width) * camera.height / n);
  for (int i = 0; i < n; ++i) {
    Random random(11, i);
    const double z = kDistance * random.uniform(0.95, 1.05);
    cloud.position[i] = Vec3f(float((random.uniform(0, camera.width) - camera.cx) / camera.fx * z),
                              float((random.uniform(0, camera.height) - camera.cy) / camera.fy * z), float(z));
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = static_cast<float>(random.normal());
    cloud.log_scale[i].setConstant(static_cast<float>(std::log(0.5 * spacing)));
    cloud.opacity_logit[i] = 0;
  }
  return cloud;
}

template <class V>
std::span<float> flat(std::vector<V>& values) {
  return {reinterpret_cast<float*>(values.data()), values.size() * sizeof(V) / sizeof(float)};
}

struct Fit {
  std::vector<double> psnr;  // before each step, and at the end
  ImageF picture;
  double seconds = 0;
};

Fit fit(const ImageF& photo, int gaussians, int iterations, int threads) {
  omp_set_num_threads(threads);
  Camera camera;
  camera.width = photo.width;
  camera.height = photo.height;
  camera.fx = camera.fy = photo.width;
  camera.cx = photo.width / 2.0;
  camera.cy = photo.height / 2.0;
  GaussianCloud cloud = start_cloud(gaussians, camera);
  Adam<float> position(3 * cloud.size()), rotation(4 * cloud.size()), scale(3 * cloud.size()), opacity(cloud.size()),
      color(cloud.sh.size());
  Fit out;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i <= iterations; ++i) {
    RenderTape<float> tape;
    const RenderResult picture = render(cloud, camera, {}, {}, 0, &tape);
    out.psnr.push_back(psnr_of_mse(mse_loss(picture.color, photo)));
    out.picture = picture.color;
    if (i == iterations) break;
    RenderResult adj;
    photometric_loss_adjoint({}, picture.color, photo, {}, 1.0, adj.color);
    RenderGradient<float> g = render_adjoint(cloud, camera, {}, {}, 0, picture, adj, &tape);
    const float decay = static_cast<float>(std::pow(0.1, static_cast<double>(i) / iterations));
    position.step(flat(cloud.position), flat(g.cloud.position), 0.01f * decay);
    rotation.step(flat(cloud.rotation), flat(g.cloud.rotation), 0.02f * decay);
    scale.step(flat(cloud.log_scale), flat(g.cloud.log_scale), 0.02f * decay);
    opacity.step(flat(cloud.opacity_logit), flat(g.cloud.opacity_logit), 0.05f * decay);
    color.step(flat(cloud.sh), flat(g.cloud.sh), 0.03f * decay);
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  keep_freed_memory();
  CLI::App app("Fits Gaussians to one photo");
  std::string photo_file, out_folder;
  int gaussians = 2000, iterations = 1000, width = 240;
  app.add_option("photo", photo_file)->required();
  app.add_option("out", out_folder)->required();
  app.add_option("--gaussians", gaussians);
  app.add_option("--iterations", iterations);
  app.add_option("--width", width);
  CLI11_PARSE(app, argc, argv);
  const ImageF photo = resized(read_image(photo_file), width);
  const Fit one = fit(photo, gaussians, iterations, 1), two = fit(photo, gaussians, iterations, 2);
  const bool equal = one.psnr == two.psnr && one.picture.data == two.picture.data;
  nlohmann::json result = {{"gaussians", gaussians},
                           {"iterations", iterations},
                           {"size", {photo.width, photo.height}},
                           {"seconds_1_thread", one.seconds},
                           {"seconds_2_threads", two.seconds},
                           {"equal_bits_for_1_and_2_threads", equal},
                           {"psnr", one.psnr}};
  std::filesystem::create_directories(out_folder);
  write_image(out_folder + "/photo.png", photo);
  write_image(out_folder + "/fit.png", one.picture);
  write_json(out_folder + "/texture_fit.json", result);
  for (int i = 0; i <= iterations; i += std::max(1, iterations / 10)) std::printf("%5d  %.2f dB\n", i, one.psnr[i]);
  std::printf("1 thread %.1f s, 2 threads %.1f s, %s\n", one.seconds, two.seconds,
              equal ? "equal bit for bit" : "DIFFERENT");
  return equal ? 0 : 1;
}
