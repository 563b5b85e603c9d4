// What a click means where no box says how large it is.

#include <algorithm>

#include "gaussians/base/orbit.h"
#include "segmentation/select/selector.h"

namespace pliant {

/// What the views show of every Gaussian: its blend weight.
std::vector<float> Selector::shown() const {
  constexpr int kViews = 16, kLongest = 320;  // px
  Lift lift(cloud_.size());
  const int count = static_cast<int>(std::min<size_t>(kViews, cameras_.size()));
  for (int k = 0; k < count; ++k) {
    const Camera& camera = cameras_[k * cameras_.size() / count];
    const Camera small =
        camera.scaled(std::min(1.0, static_cast<double>(kLongest) / std::max(camera.width, camera.height)));
    lift.add(cloud_, small, options_.render, std::vector<uint8_t>(static_cast<size_t>(small.width) * small.height, 0));
  }
  return std::move(lift.total);
}

/// Planes that what was marked at these nodes stands on or hangs at.
void Selector::find_planes(const std::vector<int>& sources) {
  if (sources.empty()) return;
  Vec3f middle = Vec3f::Zero();
  for (const int i : sources) middle += cloud_.position[graph_.nodes[i]] / static_cast<float>(sources.size());
  SupportOptions options;
  options.seed = options_.seed;
  const float diagonal = static_cast<float>(robust_framing(cloud_, Vec3d::UnitZ()).diagonal());
  planes_ =
      planes_behind(options, draw_points(cloud_.position, shown(), options_.seed), middle, diagonal, graph_.spacing);
}

bool Selector::on_plane(int p) const {
  return std::any_of(planes_.begin(), planes_.end(),
                     [&](const Support& plane) { return plane.height(cloud_.position[p]) <= plane.tolerance; });
}

/// The graph without what ties things to the planes behind them; what is left hangs together whatever its colours.
GaussianGraph Selector::without_planes() const {
  GaussianGraph apart = graph_;
  for (size_t k = 0; k < apart.edges.size(); ++k) {
    CutEdge& edge = apart.edges[k];
    const bool joined =
        apart.edge_nearness[k] > options_.link && on_plane(graph_.nodes[edge.a]) == on_plane(graph_.nodes[edge.b]);
    edge.weight = joined ? apart.edge_nearness[k] : 0.0f;
  }
  return apart;
}

void Selector::propose_around_seeds() {
  std::vector<int> sources;
  for (size_t i = 0; i < graph_.nodes.size(); ++i)
    if (fixed_[graph_.nodes[i]] > 0) sources.push_back(static_cast<int>(i));
  if (options_.apart_from_planes) find_planes(sources);
  const auto behind = [&](int i) { return on_plane(graph_.nodes[i]); };
  if (!std::all_of(sources.begin(), sources.end(), behind)) {
    // A click near the foot covers some of the plane, too.
    for (const int i : sources)
      if (behind(i)) fixed_[graph_.nodes[i]] = 0;
    std::erase_if(sources, behind);
  }
  const GaussianGraph apart = planes_.empty() ? graph_ : without_planes();
  const std::vector<int> order = order_from(apart, sources);
  const size_t count = best_sweep(apart, order, std::max<size_t>(20, 2 * sources.size()));
  label_.assign(graph_.nodes.size(), 0);
  evidence_.assign(graph_.nodes.size(), -options_.evidence);
  for (size_t k = 0; k < count; ++k) {
    label_[order[k]] = 1;
    evidence_[order[k]] = options_.evidence;
  }
  for (size_t i = 0; i < graph_.nodes.size(); ++i)
    if (fixed_[graph_.nodes[i]]) evidence_[i] = fixed_[graph_.nodes[i]] * kFixed;
  cut_graph(options_.cut, graph_, evidence_, label_);
}

}  // namespace pliant
