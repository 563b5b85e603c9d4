#pragma once

#include "segmentation/discover/automatic_supports.h"
#include "segmentation/select/gesture.h"

namespace pliant {

/// The steps of `select_by_gesture` and what they hand on.
class Selector {
 public:
  Selector(const GestureOptions& options, const Gesture& gesture, const GaussianCloud& cloud,
           const std::vector<Camera>& cameras)
      : options_(options),
        gesture_(gesture),
        cloud_(cloud),
        cameras_(cameras),
        prompts_(cloud.size()),
        rule_(cloud.size()) {}

  GestureResult run(const std::optional<SelectionShape>& shape);

 private:
  void find_members(const std::optional<SelectionShape>& shape);
  void fix_seeds();
  void spread_seeds();
  void look_at_boxes();
  std::vector<float> shown() const;
  void find_planes(const std::vector<int>& sources);
  bool on_plane(int p) const;
  GaussianGraph without_planes() const;
  void propose_around_seeds();
  void cut(const GraphCutOptions& cut_options, const Lift& lift);
  void keep_main_part();
  void find_support();
  void give_back_enclosed();
  std::vector<WindowView> views_of_selection() const;
  void refine();

  GrabCutInput input_of(const WindowView& window, const RenderResult& picture) const;
  void seed_strokes(const WindowView& window, GrabCutInput& input) const;
  std::vector<float> evidence_of(const Lift& lift) const;
  std::vector<float> memberships() const;

  static constexpr float kFixed = 1e4f;  // evidence on Gaussians that a stroke covers

  const GestureOptions& options_;
  const Gesture& gesture_;
  const GaussianCloud& cloud_;
  const std::vector<Camera>& cameras_;

  std::vector<uint8_t> member_;      // [N] may belong to the object
  std::vector<int8_t> fixed_;        // [N] +1 / -1 under strokes
  GaussianGraph graph_;              // of the members
  std::vector<uint8_t> label_;       // [nodes]
  std::vector<float> evidence_;      // [nodes] of the last cut
  std::vector<float> support_;       // [nodes] evidence from the plane that the object stands on
  std::vector<Support> planes_;      // that what was clicked stands on or hangs at
  std::vector<float> spread_;        // [nodes] -1..1, how strokes reach along the graph
  Lift prompts_;                     // of the boxes' masks
  std::vector<SelectionRule> rule_;  // [N]
  GestureResult::Summary summary_;
};

}  // namespace pliant
