#include "segmentation/models/feature_memory.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr std::ptrdiff_t kBlock = 64;  // query pixels at once

/// Weights of the memory pixels that one query pixel reads.
struct Reading {
  std::vector<std::pair<uint32_t, uint32_t>> pixels;  // frame, pixel
  std::vector<float> weights;
};

/// Softmax over the `top` greatest of `similarity` [frames, n] among the frames of a group; ties go to the older pixel.
Reading reading_of(const std::vector<size_t>& frames, const Eigen::VectorXf& similarity, size_t n, size_t top) {
  std::vector<uint32_t> order;
  for (const size_t frame : frames)
    for (size_t i = 0; i < n; ++i) order.push_back(static_cast<uint32_t>(frame * n + i));
  const size_t count = std::min(top, order.size());
  std::partial_sort(
      order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
      [&](uint32_t a, uint32_t b) { return similarity[a] != similarity[b] ? similarity[a] > similarity[b] : a < b; });
  Reading reading;
  float total = 0;
  for (size_t k = 0; k < count; ++k) {
    reading.pixels.emplace_back(order[k] / n, order[k] % n);
    reading.weights.push_back(std::exp(similarity[order[k]] - similarity[order[0]]));
    total += reading.weights.back();
  }
  for (float& weight : reading.weights) weight /= total;
  return reading;
}

}  // namespace

void FeatureMemory::add(Frame frame, size_t most) {
  frames_.push_back(std::move(frame));
  for (size_t f = 0; frames_.size() > most && f + 1 < frames_.size();) {
    bool first_of_one = false;  // is it the only place where some thing is remembered longest?
    for (const auto& [thing, value] : frames_[f].value) {
      bool earlier = false;
      for (size_t e = 0; e < f; ++e) earlier |= frames_[e].value.count(thing) > 0;
      first_of_one |= !earlier;
    }
    if (first_of_one)
      ++f;
    else
      frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(f));
  }
}

void FeatureMemory::replace_newest(Frame frame) {
  CHECK(!frames_.empty());
  frames_.back() = std::move(frame);
}

std::vector<std::vector<float>> FeatureMemory::read(const std::vector<float>& query,
                                                    const std::vector<float>& selection, size_t channels,
                                                    const std::vector<uint32_t>& things, size_t top) const {
  CHECK(!frames_.empty() && query.size() == selection.size());
  const size_t n = frames_[0].shrinkage.size(), m = query.size() / channels;
  const auto rows = static_cast<std::ptrdiff_t>(frames_.size() * n), c = static_cast<std::ptrdiff_t>(channels);
  Matrix keys(rows, c);
  Eigen::VectorXf scale(rows);
  for (size_t f = 0; f < frames_.size(); ++f)
    for (size_t i = 0; i < n; ++i) {
      scale[f * n + i] = frames_[f].shrinkage[i] / std::sqrt(static_cast<float>(channels));
      for (size_t k = 0; k < channels; ++k) keys(f * n + i, k) = frames_[f].key[k * n + i];
    }
  const Matrix squares = keys.cwiseAbs2();

  std::map<std::vector<size_t>, std::vector<size_t>> groups;  // frames that know a thing -> things
  for (size_t t = 0; t < things.size(); ++t) {
    std::vector<size_t> known;
    for (size_t f = 0; f < frames_.size(); ++f)
      if (frames_[f].value.count(things[t])) known.push_back(f);
    CHECK(!known.empty());
    groups[known].push_back(t);
  }
  std::vector<std::vector<float>> out(things.size());
  for (size_t t = 0; t < things.size(); ++t) {
    for (const Frame& frame : frames_)
      if (const auto value = frame.value.find(things[t]); value != frame.value.end())
        out[t].resize(value->second.size() / n * m);
  }

  parallel_for((static_cast<std::ptrdiff_t>(m) + kBlock - 1) / kBlock, [&](std::ptrdiff_t block) {
    const std::ptrdiff_t begin = block * kBlock, count = std::min(kBlock, static_cast<std::ptrdiff_t>(m) - begin);
    Matrix chosen(c, count), product(c, count);
    Eigen::RowVectorXf rest = Eigen::RowVectorXf::Zero(count);
    for (std::ptrdiff_t k = 0; k < c; ++k)
      for (std::ptrdiff_t q = 0; q < count; ++q) {
        const float e = selection[k * m + begin + q], x = query[k * m + begin + q];
        chosen(k, q) = e;
        product(k, q) = 2 * x * e;
        rest[q] += e * x * x;
      }
    Matrix similarity = keys * product - squares * chosen;
    similarity.rowwise() -= rest;
    for (std::ptrdiff_t q = 0; q < count; ++q) {
      const Eigen::VectorXf column = similarity.col(q).cwiseProduct(scale);
      for (const auto& [frames, members] : groups) {
        const Reading reading = reading_of(frames, column, n, top);
        for (const size_t t : members)
          for (size_t k = 0; k < reading.pixels.size(); ++k) {
            const auto [frame, pixel] = reading.pixels[k];
            const std::vector<float>& value = frames_[frame].value.at(things[t]);
            for (size_t v = 0; v * n < value.size(); ++v)
              out[t][v * m + begin + q] += reading.weights[k] * value[v * n + pixel];
          }
      }
    }
  });
  return out;
}

}  // namespace pliant
