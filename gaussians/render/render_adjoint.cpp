#include <memory>

#include "gaussians/base/error.h"
#include "gaussians/render/project_input.h"
#include "gaussians/render/render_as.h"
#include "gaussians/render/tile_input.h"

namespace pliant {
namespace {

// Memory for the kernels, aligned to a cache line.
template <class T>
class Scratch {
 public:
  explicit Scratch(size_t count) : memory_(count * sizeof(T) + kLine) {}
  T* data() {
    const auto address = reinterpret_cast<uintptr_t>(memory_.data());
    return reinterpret_cast<T*>((address + kLine - 1) / kLine * kLine);
  }

 private:
  static constexpr size_t kLine = 64;
  std::vector<std::byte> memory_;
};

// Derivatives of the blended values of a tile, and per pixel their scalar product with the values; returns what the
// tile's pixels say about the background.
template <class T>
Vec3<T> gather_tile(const TileInput<T>& in, const Rendered<T>& picture, const Rendered<T>& adj, T* adj_sums, T* rest) {
  Vec3<T> background = Vec3<T>::Zero();
  std::fill_n(adj_sums, (4 + in.channels) * kTilePixels, T(0));
  std::fill_n(rest, kTilePixels, T(0));
  for_each_pixel(in, [&](int x, int y, int pixel) {
    const T left_over = 1 - picture.alpha(x, y);
    T sum = 0;
    if (!adj.color.empty()) {
      for (int c = 0; c < 3; ++c) {
        const T g = adj.color(x, y, c);
        adj_sums[c * kTilePixels + pixel] = g;
        sum += g * picture.color(x, y, c);
        background[c] += left_over * g;
      }
    }
    if (!adj.depth.empty()) {
      adj_sums[3 * kTilePixels + pixel] = adj.depth(x, y);
      sum += adj.depth(x, y) * picture.depth(x, y);
    }
    if (!adj.alpha.empty()) sum -= left_over * adj.alpha(x, y);
    if (!adj.features.empty()) {
      const T *g = adj.features.at(x, y), *value = picture.features.at(x, y);
      for (int c = 0; c < in.channels; ++c) {
        adj_sums[(4 + c) * kTilePixels + pixel] = g[c];
        sum += g[c] * value[c];
      }
    }
    rest[pixel] = sum;
  });
  return background;
}

// dL/d(u, v) of a splat from the moments of dL/d ln(alpha) over its pixels.
template <class T>
Eigen::Matrix<T, 2, 1> screen_gradient(const Splat<T>& splat, const T* sum) {
  const T twice_ln2 = T(2 * 0.6931471805599453);
  const T along_x = twice_ln2 * splat.precision_x * sum[kMomentE];
  return {along_x, twice_ln2 * splat.precision_y * sum[kMomentD] - splat.slope * along_x};
}

// Sums the derivatives of splats over their pairs, and turns them into those of Gaussians; returns the camera's part,
// equal for any number of threads: fixed blocks of splats, added in order.
template <class T>
ViewGradient<T> gather_gaussians(const BlendKernels<T>& kernels, ProjectAdjointInput<T> input,
                                 const ProjectedSplats<T>& projected, const TileLists& lists, const T* pair_gradient,
                                 size_t pair_stride, int channels, RenderGradient<T>& out) {
  constexpr std::ptrdiff_t kBlock = 4096, kAtOnce = 256;
  constexpr uint32_t kAhead = 32;
  const CloudGradient<T> to = cloud_gradient(out.cloud, out.covariance);
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(projected.splats.size()), blocks = (n + kBlock - 1) / kBlock;
  std::vector<ViewGradient<T>> of_block(blocks);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    const std::ptrdiff_t last = std::min(n, (b + 1) * kBlock);
    uint32_t index[kAtOnce];
    T sums[kAtOnce * kPairSlots];
    ProjectAdjointInput<T> in = input;
    in.index = index;
    in.sums = sums;
    for (std::ptrdiff_t s = b * kBlock; s < last;) {
      for (in.count = 0; in.count < kAtOnce && s < last; ++s) {
        const uint32_t begin = lists.first_pair[s], end = lists.first_pair[s + 1], i = projected.splats[s].index;
        if (begin == end) continue;
        T sum[kPairSlots] = {};
        T* features = out.features.data() + static_cast<size_t>(i) * channels;
        for (uint32_t pair = begin; pair < end; ++pair) {
          // Entries of a splat lie far apart; those that come up are asked for in time, with both ends.
          if (pair + kAhead < lists.entry_of_pair.size()) {
            const T* ahead = pair_gradient + lists.entry_of_pair[pair + kAhead] * pair_stride;
            __builtin_prefetch(ahead);
            __builtin_prefetch(ahead + pair_stride - 1);
          }
          const T* from = pair_gradient + lists.entry_of_pair[pair] * pair_stride;
          for (int k = 0; k < kPairSlots; ++k) sum[k] += from[k];
          for (int k = 0; k < channels; ++k) features[k] += from[kPairSlots + k];
        }
        std::copy_n(sum, kPairSlots, sums + in.count * kPairSlots);
        if (!out.screen.empty()) out.screen[i] += screen_gradient(projected.splats[s], sum);
        index[in.count++] = i;
      }
      kernels.project_adjoint(in, to, of_block[b]);
    }
  });
  ViewGradient<T> total;
  for (const ViewGradient<T>& g : of_block) total += g;
  return total;
}

// Free entries of R, t and centre = -R^T t to a turn and a shift of cam_from_world from the left.
template <class T>
void set_pose(const View<T>& view, const ViewGradient<T>& adj, RenderGradient<T>& out) {
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  using Vector = Eigen::Map<const Vec3<T>>;
  const Eigen::Map<const RowMajor> R(view.R[0]), adj_R(adj.R[0]);
  const Vector t(view.t), adj_t(adj.t), adj_centre(adj.centre);
  out.translation = adj_t - R * adj_centre;
  const Mat3<T> G = (adj_R - t * adj_centre.transpose()) * R.transpose() + out.translation * t.transpose();
  out.rotation = Vec3<T>(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
}

}  // namespace

template <class T, bool kCutOffs>
RenderGradient<T> render_adjoint_as(const CloudOf<T>& cloud, const Camera& camera, const RenderOptions& options,
                                    std::span<const T> features, int channels, const Rendered<T>& picture,
                                    const Rendered<T>& adj, const RenderTape<T>* tape, const GradientExtras& extras) {
  CHECK(features.size() == cloud.size() * channels);
  CHECK(picture.color.width == camera.width && picture.color.height == camera.height);
  for (const Image<T>* image : {&adj.color, &adj.depth, &adj.alpha, &adj.features})
    CHECK(image->empty() || (image->width == camera.width && image->height == camera.height));
  CHECK(adj.features.empty() || adj.features.channels == channels);
  // Without derivatives of the features their values do not matter.
  const int blended = adj.features.empty() ? 0 : channels;

  RenderGradient<T> out;
  out.cloud.sh_degree = cloud.sh_degree;
  out.cloud.resize(cloud.size());
  for (auto& q : out.cloud.rotation) q.setZero();
  out.features.assign(features.size(), T(0));
  if (extras.covariance) out.covariance.assign(cloud.size(), Mat3<T>::Zero());
  if (extras.screen) out.screen.assign(cloud.size(), Eigen::Matrix<T, 2, 1>::Zero());

  ProjectedSplats<T> made;
  if (!tape) {
    made = project_splats<T, kCutOffs>(cloud, camera, options.antialiased, options.most_pairs, options.instruction_set,
                                       options.screen_variance, options.frame);
  }
  const ProjectedSplats<T>& projected = tape ? tape->projected : made;
  const BlendKernels<T>& kernels = blend_kernels<T, kCutOffs>(options.instruction_set);
  const View<T> view = make_view<T>(camera, options.screen_variance, options.frame);
  const size_t stride = kPairSlots + blended;
  ViewGradient<T> adj_view;
  for (int band = 0; band + 1 < static_cast<int>(projected.bands.size()); ++band) {
    TileLists binned;
    if (!tape || !tape->lists) binned = bin_splats<T, kCutOffs>(projected, band, options.instruction_set);
    const TileLists& lists = tape && tape->lists ? *tape->lists : binned;
    const std::unique_ptr<T[]> pair_gradient(new T[lists.entries.size() * stride]);
    const int tiles = lists.last_tile - lists.first_tile;
    std::vector<Vec3<T>> background(tiles);
    parallel_for(tiles, [&](std::ptrdiff_t tile) {
      thread_local std::unique_ptr<Scratch<T>> scratch;
      thread_local int room = -1;
      if (room < blended) {
        scratch = std::make_unique<Scratch<T>>((9 + 2 * blended) * kTilePixels);
        room = blended;
      }
      T* adj_sums = scratch->data();
      T* rest = adj_sums + (4 + blended) * kTilePixels;
      const TileInput<T> in = tile_input(projected, lists, static_cast<int>(tile), features, channels);
      TileInput<T> used = in;
      used.channels = blended;
      background[tile] = gather_tile(used, picture, adj, adj_sums, rest);
      kernels.blend_adjoint(used, adj_sums, rest, pair_gradient.get() + lists.start[tile] * stride, stride,
                            rest + kTilePixels);
    });
    for (const Vec3<T>& b : background) out.background += b;
    adj_view += gather_gaussians(kernels, {cloud_input(cloud), view, options.antialiased, nullptr, nullptr, 0},
                                 projected, lists, pair_gradient.get(), stride, blended, out);
  }
  set_pose(view, adj_view, out);
  return out;
}

template RenderGradient<float> render_adjoint_as<float, true>(const CloudOf<float>&, const Camera&,
                                                              const RenderOptions&, std::span<const float>, int,
                                                              const Rendered<float>&, const Rendered<float>&,
                                                              const RenderTape<float>*, const GradientExtras&);
template RenderGradient<double> render_adjoint_as<double, true>(const CloudOf<double>&, const Camera&,
                                                                const RenderOptions&, std::span<const double>, int,
                                                                const Rendered<double>&, const Rendered<double>&,
                                                                const RenderTape<double>*, const GradientExtras&);
template RenderGradient<double> render_adjoint_as<double, false>(const CloudOf<double>&, const Camera&,
                                                                 const RenderOptions&, std::span<const double>, int,
                                                                 const Rendered<double>&, const Rendered<double>&,
                                                                 const RenderTape<double>*, const GradientExtras&);

RenderGradient<float> render_adjoint(const CloudOf<float>& cloud, const Camera& camera, const RenderOptions& options,
                                     std::span<const float> features, int channels, const RenderResult& picture,
                                     const RenderResult& adj, const RenderTape<float>* tape,
                                     const GradientExtras& extras) {
  return render_adjoint_as<float>(cloud, camera, options, features, channels, picture, adj, tape, extras);
}

}  // namespace pliant
