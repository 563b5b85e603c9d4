#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace pliant {

/// Working memory of XMem (Cheng and Schwing 2022, section 3.2): keys of a few frames with the values of each thing in
/// them, read by similarity.  All arrays are channel-major, [channels, pixels] of one frame.
class FeatureMemory {
 public:
  struct Frame {
    std::vector<float> key;                        ///< [C, n]
    std::vector<float> shrinkage;                  ///< [n]
    std::map<uint32_t, std::vector<float>> value;  ///< thing -> [V, n]
  };

  /// At most `most` frames are kept: the oldest go, but not the first one of a thing.
  void add(Frame frame, size_t most);
  /// Puts `frame` in the place of the newest one.
  void replace_newest(Frame frame);
  void clear() { frames_.clear(); }
  size_t frames() const { return frames_.size(); }

  /// Values for each pixel of a query key [C, m] with selection [C, m]: the mean of the values of `thing` weighted by a
  /// softmax over the `top` memory pixels of greatest similarity
  ///   s(i, q) = -shrinkage_i sum_c selection_cq (key_ci - query_cq)^2 / sqrt(C)
  /// among the frames that know the thing.  One [V, m] for each of `things`.
  std::vector<std::vector<float>> read(const std::vector<float>& query, const std::vector<float>& selection,
                                       size_t channels, const std::vector<uint32_t>& things, size_t top) const;

 private:
  std::vector<Frame> frames_;
};

}  // namespace pliant
