#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "gaussians/render/blend_weights.h"
#include "segmentation/field/semantic_loss.h"

namespace pliant {

/// How much blend weight every Gaussian puts on pixels of every class: votes[p, c] = sum over pixels of class c of w.
/// Most Gaussians meet few classes, so four slots each and a table for the rest hold any number of classes.
class ClassVotes {
 public:
  struct Vote {
    int32_t cls = -1;
    float weight = 0;
  };

  explicit ClassVotes(size_t gaussians) : slots_(gaussians * kSlots) {}
  /// Adds one view; `target` [pixels] is the class of a pixel, -1 = unlabelled.
  void add(const BlendWeights& weights, std::span<const int> target);
  /// Classes of Gaussian p with their weights, by class.
  std::vector<Vote> of(size_t p) const;
  float total(size_t p) const;
  size_t size() const { return slots_.size() / kSlots; }

 private:
  static constexpr int kSlots = 4;
  void add(size_t p, int cls, float weight);
  std::vector<Vote> slots_;
  std::unordered_map<uint32_t, std::vector<Vote>> more_;
};

/// Unit codes [C, 16] of low mutual coherence: a Hadamard basis for C <= 16, beyond it vectors chosen greedily from
/// random candidates.
std::vector<float> class_codes(int classes, uint64_t seed);

/// The scale s of a classifier of these codes: the smallest s >= 8 with sum over c != k of exp(-s (1 - e_k . e_c)) <=
/// 0.05 for every k, so that a Gaussian whose attribute is the code of its class has that class with a probability of
/// at least 1 / 1.05.  It is 8 for C <= 16.
float code_sharpness(std::span<const float> codes);

/// Closed-form start: y = code-weighted normalised votes and a classifier of the same codes times their
/// code_sharpness, so that the most probable class of every Gaussian is the one with the most votes (mixed votes are
/// sharpened until it is).  Gaussians without votes get y = 0.
void start_from_votes(const ClassVotes& votes, int classes, uint64_t seed, SemanticModel<float>& model);

}  // namespace pliant
