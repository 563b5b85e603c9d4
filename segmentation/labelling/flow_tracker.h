#pragma once

#include <map>
#include <optional>

#include "segmentation/labelling/color_histogram.h"
#include "segmentation/model_interfaces/promptable_segmenter.h"
#include "segmentation/model_interfaces/tracker.h"
#include "segmentation/select/grab_cut.h"

namespace pliant {

struct FlowTrackerOptions {
  int longest = 480;  ///< px; larger pictures are followed at this size
  // Carrying a mask to the next picture.
  float consistent = 1.5f;  ///< px; flow that does not come back this near to its start is not believed
  GrabCutOptions cut;
  int window = 200;         ///< px, longer side of the window of the cut
  float context = 0.35f;    ///< of the carried mask's box, on every side of it
  float prior = 4;          ///< log odds of what was carried, away from its border
  float doubt = 0.3f;       ///< share of these where the flow is not believed
  float border = 0.1f;      ///< distance over which they come to bear, share of the root of the mask's area
  float least_kept = 0.5f;  ///< overlap with what was carried below which the cut is not taken
  float reach = 1;          ///< what flow loses is looked for within so many roots of the mask's area around it ...
  float stands_out =
      0.3f;  ///< ... where the squares by which its colours differ are less than this share of the median there
  float better = 0.5f;  ///< ... and of those along the flow
  // Being lost.
  float least_believed = 0.1f;  ///< share of a mask whose flow is believed
  float least_alike =
      0.75f;  ///< likeness of its colours with those of the thing; that of what lies around must be less
  size_t least_pixels = 12;
  // Coming back.
  float recall_alike = 0.85f;  ///< likeness of colours at which a lost thing is known again
  float recall_common =
      0.5f;               ///< likeness of its colours with those of the whole picture, above which they tell nothing
  float recall_size = 3;  ///< times larger or smaller than it was when it was last shown, at most
  float match = 0.5f;     ///< overlap with a followed mask at which a detection corrects it
};

/// Carries masks through pictures without learnt weights: dense flow back to the picture before, or where that fails,
/// as for small things that move fast, one shift at which the colours fit better; a GrabCut around what is carried, and
/// a check of flow and colours after which a thing is lost rather than followed wrongly.  A lost thing comes back,
/// under its id, where its colours stand out at about its size, or where `add` shows it.  Equal for any number of
/// threads.
class FlowTracker final : public Tracker {
 public:
  explicit FlowTracker(const FlowTrackerOptions& options = {}) : options_(options) {}
  TrackedFrame start(const ImageF& picture, const IdImage& masks) override;
  TrackedFrame step(const ImageF& picture) override;
  TrackedFrame add(const IdImage& detections) override;

 private:
  struct Thing {
    ImageF mask;  ///< [h, w, 1]; > 0 inside
    ColorHistogram look;
    size_t pixels = 0;  ///< when it was last shown
    bool lost = false;
  };
  struct Flows {
    ImageF back, forth;
  };
  static constexpr float kOut = -4;  ///< logit where a mask certainly is not

  void take(const ImageF& picture);
  IdImage scaled(const IdImage& ids) const;
  void follow(uint32_t id, const ImageF& mask);
  /// A mask moved on to the next picture, and how far each pixel of it is believed, 0..1.
  struct Carried {
    ImageF mask, trust;
    float misfit = 0;  ///< mean squared difference of colours from the picture before
  };
  std::optional<Carried> carry_by_flow(const Flows& flows, const ImageF& lab_before, const Thing& thing) const;
  std::optional<Carried> carry_by_shift(const ImageF& lab_before, const Thing& thing) const;
  bool settle(const std::optional<Carried>& carried, Thing& thing) const;
  bool recall(const ImageF& lab, const ColorHistogram& ground, const std::vector<uint8_t>& taken, Thing& thing) const;
  ImageF cut_around(const ImageF& carried, const ImageF& trust, const ImageF& lab, const ColorHistogram& look) const;
  TrackedFrame frame() const;

  FlowTrackerOptions options_;
  int width_ = 0, height_ = 0;  ///< of the pictures as they are given
  ImageF picture_, lab_;        ///< the last one, as it is followed
  std::map<uint32_t, Thing> things_;
};

}  // namespace pliant
