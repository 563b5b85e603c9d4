#include "segmentation/field/vote.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "gaussians/base/random.h"

namespace pliant {

void ClassVotes::add(size_t p, int cls, float weight) {
  Vote* slot = slots_.data() + p * kSlots;
  for (int s = 0; s < kSlots; ++s) {
    if (slot[s].cls != cls && slot[s].cls >= 0) continue;
    slot[s].cls = cls;
    slot[s].weight += weight;
    return;
  }
  std::vector<Vote>& more = more_[static_cast<uint32_t>(p)];
  for (Vote& vote : more)
    if (vote.cls == cls) return void(vote.weight += weight);
  more.push_back({cls, weight});
}

void ClassVotes::add(const BlendWeights& weights, std::span<const int> target) {
  CHECK(target.size() == weights.pixels());
  for (size_t pixel = 0; pixel < target.size(); ++pixel) {
    if (target[pixel] < 0) continue;
    for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e)
      add(weights.gaussian[e], target[pixel], weights.weight[e]);
  }
}

std::vector<ClassVotes::Vote> ClassVotes::of(size_t p) const {
  std::vector<Vote> votes;
  for (int s = 0; s < kSlots; ++s)
    if (slots_[p * kSlots + s].cls >= 0) votes.push_back(slots_[p * kSlots + s]);
  if (const auto it = more_.find(static_cast<uint32_t>(p)); it != more_.end())
    votes.insert(votes.end(), it->second.begin(), it->second.end());
  std::sort(votes.begin(), votes.end(), [](const Vote& a, const Vote& b) { return a.cls < b.cls; });
  return votes;
}

float ClassVotes::total(size_t p) const {
  float sum = 0;
  for (const Vote& vote : of(p)) sum += vote.weight;
  return sum;
}

namespace {

using Code = Eigen::Matrix<float, kSemanticChannels, 1>;

Code hadamard(int row) {
  Code code;
  for (int k = 0; k < kSemanticChannels; ++k)
    code[k] = std::popcount(static_cast<unsigned>(row & k)) % 2 ? -0.25f : 0.25f;
  return code;
}

}  // namespace

std::vector<float> class_codes(int classes, uint64_t seed) {
  std::vector<Code> codes;
  for (int c = 0; c < classes; ++c) {
    if (c < kSemanticChannels) {
      codes.push_back(hadamard(c));
      continue;
    }
    // Of a few random directions, the one whose worst inner product with the codes so far is smallest.
    Code best = Code::Zero();
    float best_coherence = INFINITY;
    for (int candidate = 0; candidate < 32; ++candidate) {
      Random random(seed, c, candidate);
      Code code;
      for (int k = 0; k < kSemanticChannels; ++k) code[k] = static_cast<float>(random.normal());
      code.normalize();
      float coherence = -1;
      for (const Code& other : codes) coherence = std::max(coherence, code.dot(other));
      if (coherence < best_coherence) {
        best_coherence = coherence;
        best = code;
      }
    }
    codes.push_back(best);
  }
  std::vector<float> flat;
  for (const Code& code : codes) flat.insert(flat.end(), code.data(), code.data() + kSemanticChannels);
  return flat;
}

float code_sharpness(std::span<const float> codes) {
  constexpr double kLeast = 8, kOthers = 0.05;
  const size_t classes = codes.size() / kSemanticChannels;
  const auto code = [&](size_t c) { return Eigen::Map<const Code>(codes.data() + c * kSemanticChannels); };
  double sharpness = kLeast;
  std::vector<double> gap;  // 1 - e_k . e_c of the other classes
  const auto others = [&](double s) {
    double sum = 0;
    for (const double g : gap) sum += std::exp(-s * g);
    return sum;
  };
  for (size_t k = 0; k < classes; ++k) {
    gap.clear();
    for (size_t c = 0; c < classes; ++c)
      if (c != k) gap.push_back(std::max(1e-3, 1.0 - code(k).dot(code(c))));
    if (others(sharpness) <= kOthers) continue;
    double low = sharpness, high = 2 * sharpness;
    while (others(high) > kOthers) high *= 2;
    for (int halving = 0; halving < 30; ++halving) {
      const double middle = 0.5 * (low + high);
      (others(middle) > kOthers ? low : high) = middle;
    }
    sharpness = high;
  }
  return static_cast<float>(sharpness);
}

void start_from_votes(const ClassVotes& votes, int classes, uint64_t seed, SemanticModel<float>& model) {
  model.resize(votes.size(), classes);
  const std::vector<float> codes = class_codes(classes, seed);
  auto code = [&](int c) { return Eigen::Map<const Code>(codes.data() + static_cast<size_t>(c) * kSemanticChannels); };
  const float sharpness = code_sharpness(codes);
  for (size_t i = 0; i < codes.size(); ++i) model.classifier[i] = sharpness * codes[i];
  parallel_for(
      static_cast<std::ptrdiff_t>(votes.size()),
      [&](std::ptrdiff_t p) {
        std::vector<ClassVotes::Vote> share = votes.of(p);
        if (share.empty()) return;
        const int winner = std::max_element(share.begin(), share.end(), [](const auto& a, const auto& b) {
                             return a.weight < b.weight;
                           })->cls;
        Code y = code(winner);
        // Codes of more than 16 classes overlap; squaring the shares approaches the winner's own code, which is decoded
        // correctly because distinct unit codes have inner products below 1.
        for (int round = 0; round < 8; ++round) {
          float sum = 0;
          for (const auto& vote : share) sum += vote.weight;
          if (!(sum > 0)) break;
          Code mixed = Code::Zero();
          for (auto& vote : share) {
            vote.weight /= sum;
            mixed += vote.weight * code(vote.cls);
          }
          int decoded = 0;
          float largest = -INFINITY;
          for (int c = 0; c < classes; ++c)
            if (const float value = code(c).dot(mixed); value > largest) {
              largest = value;
              decoded = c;
            }
          if (decoded == winner) {
            y = mixed;
            break;
          }
          for (auto& vote : share) vote.weight *= vote.weight;
        }
        Eigen::Map<Code>(model.attribute.data() + p * kSemanticChannels) = y;
      },
      256);
}

}  // namespace pliant
