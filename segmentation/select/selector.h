#pragma once

#include <memory>

#include "segmentation/discover/automatic_supports.h"
#include "segmentation/select/gesture.h"

namespace pliant {

/// The steps of `select_by_gesture` and what they hand on.
class Selector {
 public:
  Selector(const GestureOptions& options, const Gesture& gesture, const GaussianCloud& cloud,
           const std::vector<Camera>& cameras, const PreparedScene& scene)
      : options_(options),
        gesture_(gesture),
        cloud_(cloud),
        cameras_(cameras),
        scene_(scene),
        graph_(scene.graph),
        prompts_(cloud.size()),
        rule_(cloud.size()) {}

  /// `part`: what an earlier run took a part of a thing for, see `part()`; null = it is decided.
  GestureResult run(const std::optional<SelectionShape>& shape, const std::vector<int>* part = nullptr);
  /// Gaussians that colours found in the boxes, where what hangs together with them counts instead; else none.
  const std::vector<int>& part() const { return part_; }
  /// Adds what lies against the selection, as near as its own Gaussians lie to each other, `gesture.grow` times, or
  /// takes its outermost Gaussians where that is negative. What strokes mark stays as they say, and what is outside the
  /// boxes stays outside.
  void grow(const std::optional<SelectionShape>& shape, GestureResult& result);
  std::vector<uint8_t> guess();  ///< [N] what is proposed around the seeds

 private:
  void find_members(const std::optional<SelectionShape>& shape);
  void fix_seeds();
  void spread_seeds();
  void look_at_boxes();
  bool on_plane(int p) const;
  void propose_around_seeds();
  void propose_apart_from_planes(const std::vector<int>& sources, int least);
  void believe_proposal();
  void find_what_fills_boxes();
  void propose_whole(const std::vector<int>& part);
  void take_proposal_for_boxes();
  float box_fit() const;
  void try_plane(Support plane, const std::vector<int>& sources, int least);
  void propose(const std::vector<int>& sources, int least);
  void add_proposal(const std::vector<int>& sources);
  std::vector<float> distance_to_neighbours() const;
  std::vector<int> before_planes(const std::vector<int>& sources) const;
  void cut(const GraphCutOptions& cut_options);
  void keep_main_part();
  void find_support();
  void give_back_enclosed();
  struct Look;
  std::vector<Look> looks_at_selection();
  void refine();

  const RegionView& view_of(int camera);
  std::vector<float> evidence_of(const Lift& lift) const;

  static constexpr float kFixed = 1e4f;  // evidence on Gaussians that a stroke covers

  const GestureOptions& options_;
  const Gesture& gesture_;
  const GaussianCloud& cloud_;
  const std::vector<Camera>& cameras_;
  const PreparedScene& scene_;
  const GaussianGraph& graph_;

  std::vector<uint8_t> member_;                          // [N] may belong to the object
  std::vector<float> held_;                              // [N] weight of the edges to what may not
  std::vector<float> coarse_weight_;                     // [edges of the superpoints] between members
  std::vector<int8_t> fixed_;                            // [N] +1 / -1 under strokes
  std::vector<std::vector<int>> marks_;                  // Gaussians of each stroke over the object
  std::vector<uint8_t> label_;                           // [N]
  std::vector<uint8_t> proposed_;                        // [N] what hangs together, before any cut, where that counts
  std::vector<int> part_;                                // see part()
  std::vector<float> evidence_;                          // [N] of the last cut
  std::vector<float> support_;                           // [N] evidence from the plane that the object stands on
  std::vector<Support> planes_;                          // that what was clicked stands on or hangs at
  std::vector<float> spread_;                            // [N] -1..1, how strokes reach along the graph
  Lift prompts_;                                         // of the boxes' masks
  std::vector<std::unique_ptr<RegionView>> more_views_;  // of cameras that are not prepared
  std::vector<SelectionRule> rule_;                      // [N]
  GestureResult::Summary summary_;
};

}  // namespace pliant
