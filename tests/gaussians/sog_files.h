#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/gaussians/format_files.h"

namespace pliant {

/// A codebook of 256 values from low to high.
inline nlohmann::json codebook(double low, double high) {
  nlohmann::json values = nlohmann::json::array();
  for (int k = 0; k < 256; ++k) values.push_back(low + (high - low) * k / 255);
  return values;
}

inline uint8_t place(double value, double low, double high) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp((value - low) / (high - low), 0.0, 1.0)));
}

inline double log_of(double x) { return std::copysign(std::log1p(std::abs(x)), x); }

/// The files of a SOG of the cloud, one palette entry for each Gaussian.
inline Entries sog_files(const GaussianCloud& cloud) {
  const int n = static_cast<int>(cloud.size()), width = 8, height = (n + width - 1) / width;
  const Box box = cloud.bounds();
  std::vector<uint8_t> low(4 * width * height, 255), high = low, quats = low, scales = low, sh0 = low, labels = low;
  nlohmann::json meta = {{"version", 2}, {"count", n}};
  for (int k = 0; k < 3; ++k) {
    meta["means"]["mins"].push_back(log_of(box.low[k]));
    meta["means"]["maxs"].push_back(log_of(box.high[k]));
  }
  const int rest = cloud.sh_count() - 1;
  std::vector<uint8_t> palette(4 * 64 * std::max(rest, 1) * ((n + 63) / 64), 255);
  for (int i = 0; i < n; ++i) {
    Vec4f q = cloud.rotation[i].normalized();
    Eigen::Index largest;
    q.cwiseAbs().maxCoeff(&largest);
    if (q[largest] < 0) q = -q;
    quats[4 * i + 3] = static_cast<uint8_t>(252 + largest);
    for (int k = 0, byte = 0; k < 4; ++k) {
      if (k != largest) quats[4 * i + byte++] = place(q[k] * M_SQRT2, -1, 1);
    }
    for (int k = 0; k < 3; ++k) {
      const double a = log_of(box.low[k]), b = log_of(box.high[k]);
      const long fixed = std::lround(65535 * (log_of(cloud.position[i][k]) - a) / (b - a));
      low[4 * i + k] = fixed & 255;
      high[4 * i + k] = static_cast<uint8_t>(fixed >> 8);
      scales[4 * i + k] = place(cloud.log_scale[i][k], -10, 2);
      sh0[4 * i + k] = place(cloud.sh_of(i)[k], -1, 1);
    }
    sh0[4 * i + 3] = static_cast<uint8_t>(std::lround(255 * sigmoid(cloud.opacity_logit[i])));
    labels[4 * i] = i & 255;
    labels[4 * i + 1] = static_cast<uint8_t>(i >> 8);
    for (int k = 0; k < rest; ++k) {
      for (int c = 0; c < 3; ++c) palette[4 * (i * rest + k) + c] = place(cloud.sh_of(i)[3 + 3 * k + c], -1, 1);
    }
  }
  Entries files;
  const auto add = [&](const char* key, const char* name, const std::vector<uint8_t>& pixels, int w, int h) {
    meta[key]["files"].push_back(name);
    files.emplace_back(name, webp(pixels, w, h));
  };
  add("means", "means_l.webp", low, width, height);
  add("means", "means_u.webp", high, width, height);
  add("quats", "quats.webp", quats, width, height);
  add("scales", "scales.webp", scales, width, height);
  meta["scales"]["codebook"] = codebook(-10, 2);
  add("sh0", "sh0.webp", sh0, width, height);
  meta["sh0"]["codebook"] = codebook(-1, 1);
  if (rest > 0) {
    add("shN", "shN_centroids.webp", palette, 64 * rest, (n + 63) / 64);
    add("shN", "shN_labels.webp", labels, width, height);
    meta["shN"]["bands"] = cloud.sh_degree;
    meta["shN"]["count"] = n;
    meta["shN"]["codebook"] = codebook(-1, 1);
  }
  files.emplace_back("meta.json", meta.dump());
  return files;
}

}  // namespace pliant
