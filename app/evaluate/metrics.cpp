#include "app/evaluate/metrics.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/render/image_loss.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// Values without their least-squares line.
std::vector<double> detrended(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0, slope = 0, spread = 0;
  for (double value : values) mean += value / n;
  for (size_t i = 0; i < values.size(); ++i) {
    const double t = static_cast<double>(i) - 0.5 * (n - 1);
    slope += t * (values[i] - mean);
    spread += t * t;
  }
  std::vector<double> out;
  for (size_t i = 0; i < values.size(); ++i)
    out.push_back(values[i] - mean - slope / spread * (static_cast<double>(i) - 0.5 * (n - 1)));
  return out;
}

}  // namespace

double median(std::vector<double> values) {
  CHECK(!values.empty());
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

void add_statistics(nlohmann::json& out, const std::string& name, const std::vector<double>& values) {
  if (values.empty()) {
    out[name] = out[name + "_median"] = out[name + "_std"] = nullptr;
    return;
  }
  const auto n = static_cast<double>(values.size());
  double mean = 0, variance = 0;
  for (double value : values) mean += value / n;
  for (double value : values) variance += (value - mean) * (value - mean) / n;
  out[name] = mean;
  out[name + "_median"] = median(values);
  out[name + "_std"] = std::sqrt(variance);
}

double capped_psnr(double mse) { return std::min(psnr_of_mse(mse), kPsnrOfIdentical); }

const nlohmann::json* find_value(const nlohmann::json& object, const std::string& key) {
  if (const auto whole = object.find(key); whole != object.end()) return &*whole;
  for (size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', dot + 1)) {
    const auto outer = object.find(key.substr(0, dot));
    if (outer == object.end() || !outer->is_object()) continue;
    if (const nlohmann::json* inner = find_value(*outer, key.substr(dot + 1))) return inner;
  }
  return nullptr;
}

std::map<std::string, fs::path> pictures_of(const fs::path& folder) {
  std::error_code failed;
  if (!fs::exists(folder, failed)) throw input_error(folder.string(), "", "does not exist", "check the name");
  std::map<std::string, fs::path> pictures;
  const bool many = fs::is_directory(folder, failed);
  for (const fs::path& file : many ? images_in(folder) : std::vector<fs::path>{folder}) {
    if (!is_image_file(file)) continue;
    const std::string name = file.stem().string();
    if (!pictures.emplace(name, file).second)
      throw input_error(folder.string(), name, "is the name of two images", "keep one of them");
  }
  if (pictures.empty())
    throw input_error(folder.string(), "", "contains no images", "give a folder of PNG or JPEG images");
  return pictures;
}

double dominant_frequency(const std::vector<double>& values, double rate) {
  if (values.size() < 4) return 0;
  std::vector<double> signal = detrended(values);
  const auto n = static_cast<double>(signal.size());
  double largest = 0;
  for (double value : signal) largest = std::max(largest, std::abs(value));
  if (largest < 1e-12) return 0;
  for (size_t i = 0; i < signal.size(); ++i)
    signal[i] *= 0.5 - 0.5 * std::cos(2 * M_PI * (static_cast<double>(i) + 0.5) / n);
  const auto power = [&](double frequency) {
    std::complex<double> sum = 0;
    for (size_t i = 0; i < signal.size(); ++i)
      sum += signal[i] * std::polar(1.0, -2 * M_PI * frequency * static_cast<double>(i) / rate);
    return std::norm(sum);
  };
  const double lowest = rate / n, step = lowest / 16;
  double best = 0, strongest = 0;
  for (double frequency = lowest; frequency <= 0.5 * rate; frequency += step) {
    const double p = power(frequency);
    if (p > strongest) {
      strongest = p;
      best = frequency;
    }
  }
  // The top of a parabola through the maximum and its neighbours; at an end of the scan it may be no maximum.
  const double left = power(best - step), right = power(best + step), curvature = left - 2 * strongest + right;
  const bool is_peak = strongest >= std::max(left, right) && curvature < 0;
  return is_peak ? best + 0.5 * step * (left - right) / curvature : best;
}

double zero_crossing_frequency(const std::vector<double>& values, double rate) {
  if (values.size() < 4) return 0;
  const std::vector<double> signal = detrended(values);
  std::vector<double> crossing;
  for (size_t i = 1; i < signal.size(); ++i) {
    const double a = signal[i - 1], b = signal[i];
    if ((a < 0) != (b < 0)) crossing.push_back(static_cast<double>(i - 1) + a / (a - b));
  }
  if (crossing.size() < 2) return 0;
  return 0.5 * static_cast<double>(crossing.size() - 1) * rate / (crossing.back() - crossing.front());
}

}  // namespace pliant
