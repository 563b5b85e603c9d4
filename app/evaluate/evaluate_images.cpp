#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/evaluate/ms_ssim.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/photo.h"
#include "gaussians/render/image_loss.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// Formats that programs save transparency in.
bool has_alpha_format(const fs::path& file) {
  std::string format = file.extension().string();
  std::transform(format.begin(), format.end(), format.begin(), [](unsigned char c) { return std::tolower(c); });
  return format == ".png" || format == ".webp";
}

/// Picture over black, as it is stored.
ImageF read_picture(const fs::path& file) {
  ImageF image = read_image(file);
  const ImageU8 alpha = has_alpha_format(file) ? read_photo(file).alpha : ImageU8();
  for (size_t i = 0; i < alpha.data.size(); ++i)
    for (int c = 0; c < image.channels; ++c) image.data[i * image.channels + c] *= alpha.data[i] / 255.0f;
  return image;
}

/// Turns the picture as its orientation tag says, where only that gives it the size of the other one: `reconstruct`
/// trains on photos turned like this.
void turn_like(const ImageF& other, const fs::path& file, ImageF& picture) {
  if (picture.width == other.width || picture.width != other.height || picture.height != other.width) return;
  if (const int orientation = read_photo_head(file).orientation; orientation >= 5)
    picture = oriented(picture, orientation);
}

/// In double: SSIM of flat areas is a ratio of small differences.
Image<double> in_double(const ImageF& picture) {
  Image<double> out(picture.width, picture.height, picture.channels);
  std::copy(picture.data.begin(), picture.data.end(), out.data.begin());
  return out;
}

/// Names in `a` that `b` lacks, as an error about `folder`.
void require_names(const std::map<std::string, fs::path>& a, const std::map<std::string, fs::path>& b,
                   const fs::path& folder, const std::string& problem) {
  std::string first;
  int count = 0;
  for (const auto& [name, file] : a) {
    if (!b.count(name) && count++ == 0) first = name;
  }
  if (count > 0) {
    throw input_error(folder.string(), first, problem + " (" + std::to_string(count) + " such images)",
                      "both folders must contain images with the same names");
  }
}

}  // namespace

json evaluate_images(const fs::path& prediction, const fs::path& truth) {
  std::map<std::string, fs::path> ours = pictures_of(prediction), theirs = pictures_of(truth);
  // Two single pictures need not have the same name.
  std::error_code ignored;
  if (!fs::is_directory(prediction, ignored) && !fs::is_directory(truth, ignored)) {
    ours = {{truth.stem().string(), prediction}};
  }
  require_names(theirs, ours, prediction, "lacks an image of this name");
  require_names(ours, theirs, truth, "lacks an image of this name, which the prediction has");

  json out = {{"kind", "images"},
              {"pictures", theirs.size()},
              {"protocol",
               {{"range", "8-bit values / 255"},
                {"transparency", "over black"},
                {"ssim", "11x11 Gaussian window, sigma 1.5, windows inside the image"},
                {"ms_ssim", "5 scales, exponents of Wang et al. 2003; null below 176 x 176 pixels"},
                {"psnr", "of the mean squared error over R, G and B; at most 100 dB, as of identical pictures"}}}};
  std::vector<double> psnr, ssim, multi_scale, error;
  int identical = 0;
  for (const auto& [name, file] : theirs) {
    ImageF our_picture = read_picture(ours.at(name)), true_picture = read_picture(file);
    turn_like(our_picture, file, true_picture);
    turn_like(true_picture, ours.at(name), our_picture);
    const Image<double> a = in_double(our_picture), b = in_double(true_picture);
    if (a.width != b.width || a.height != b.height) {
      throw input_error(ours.at(name).string(), "",
                        "has " + std::to_string(a.width) + " x " + std::to_string(a.height) +
                            " pixels but the truth has " + std::to_string(b.width) + " x " + std::to_string(b.height),
                        "render at the size of the photos, upright or as they are stored");
    }
    if (a.width < 11 || a.height < 11)
      throw input_error(file.string(), "", "is smaller than 11 x 11 pixels", "SSIM needs a larger image");
    const double mse = mse_loss(a, b);
    json row = {{"identical", mse == 0}};
    identical += mse == 0;
    ssim.push_back(pliant::ssim(a, b, {}, SsimWindows::kInside));
    error.push_back(mse);
    psnr.push_back(capped_psnr(mse));
    row["psnr"] = psnr.back();
    row["ssim"] = ssim.back();
    row["ms_ssim"] = nullptr;
    if (std::min(a.width, a.height) >= kLeastMsSsimSize) {
      multi_scale.push_back(ms_ssim(a, b));
      row["ms_ssim"] = multi_scale.back();
    }
    out["per_image"][name] = std::move(row);
  }
  add_statistics(out, "psnr", psnr);
  add_statistics(out, "ssim", ssim);
  add_statistics(out, "ms_ssim", multi_scale);
  add_statistics(out, "mse", error);
  out["identical"] = identical == static_cast<int>(theirs.size());
  out["identical_pictures"] = identical;
  return out;
}

}  // namespace pliant
