#include "segmentation/select/prepared_scene.h"

#include <algorithm>
#include <optional>

#include "gaussians/base/orbit.h"
#include "gaussians/base/portable.h"

namespace pliant {

std::vector<int> different_cameras(const std::vector<Camera>& cameras, size_t most) {
  const size_t n = cameras.size();
  std::vector<double> far(n, INFINITY);
  std::vector<int> chosen;
  double spread = 0;
  for (const Camera& camera : cameras) spread = std::max(spread, (camera.centre() - cameras[0].centre()).norm());
  const auto view = [&](size_t c) { return Vec3d(cameras[c].cam_from_world.linear().row(2).transpose()); };
  for (size_t next = 0; chosen.size() < std::min(most, n);) {
    chosen.push_back(static_cast<int>(next));
    far[next] = -1;
    size_t farthest = next;
    for (size_t c = 0; c < n; ++c) {
      const double place = (cameras[c].centre() - cameras[next].centre()).norm() / std::max(spread, 1e-12);
      if (far[c] >= 0) far[c] = std::min(far[c], (view(c) - view(next)).norm() + place);
      if (far[c] > far[farthest]) farthest = c;
    }
    next = farthest;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

WindowView whole_picture(const std::vector<Camera>& cameras, int camera, int longest) {
  const PictureRect rect{0, 0, static_cast<double>(cameras[camera].width), static_cast<double>(cameras[camera].height)};
  return WindowView(cameras, camera, rect, longest);
}

const RegionView* PreparedScene::view_of(int camera) const {
  const auto at = std::lower_bound(views.begin(), views.end(), camera,
                                   [](const RegionView& view, int c) { return view.window.source < c; });
  return at != views.end() && at->window.source == camera ? &*at : nullptr;
}

PreparedScene prepare_scene(const PrepareOptions& options, const GaussianCloud& cloud,
                            const std::vector<Camera>& cameras) {
  PreparedScene scene;
  scene.options = options;
  scene.graph = gaussian_graph(cloud, std::vector<uint8_t>(cloud.size(), 1), options.neighbours);
  scene.adjacency = Adjacency(cloud.size(), scene.graph.edges);
  scene.parts =
      superpoints(scene.graph, std::clamp(static_cast<int>(cloud.size()) / options.least_parts, 1, options.part));
  scene.shown.assign(cloud.size(), 0.0f);
  const std::vector<int> chosen = different_cameras(cameras, static_cast<size_t>(options.most_views));
  std::vector<std::optional<RegionView>> views(chosen.size());
  parallel_for(static_cast<std::ptrdiff_t>(chosen.size()), [&](std::ptrdiff_t k) {
    views[k] = region_view(options.view, cloud, whole_picture(cameras, chosen[k], options.view_pixels));
  });
  for (std::optional<RegionView>& view : views) {
    for (size_t e = 0; e < view->gaussian.size(); ++e) scene.shown[view->gaussian[e]] += view->weight[e];
    scene.views.push_back(*std::move(view));
  }
  scene.diagonal = static_cast<float>(robust_framing(cloud, Vec3d::UnitZ()).diagonal());
  return scene;
}

}  // namespace pliant
