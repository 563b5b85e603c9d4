#include "gaussians/render/tiles.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <type_traits>

#include "gaussians/base/error.h"
#include "gaussians/base/radix_sort.h"
#include "gaussians/render/spherical_harmonics.h"

namespace pliant {
namespace {

// Spans are widened by this much so that rounding cannot drop a pixel; the exact test on alpha decides.
constexpr double kMargin = 0.01, kReachMargin = 1e-3;

template <class T, bool kCutOffs>
bool make_splat(const GaussianCloud& cloud, uint32_t i, const View<T>& view, bool antialiased, Splat<T>& out) {
  Footprint<T> f;
  const Mat3<T> A = covariance_factor<T>(cloud.rotation[i].cast<T>(), cloud.log_scale[i].cast<T>());
  const Vec3<T> position = cloud.position[i].cast<T>();
  if (!project(view, position, A, f)) return false;
  out.opacity = 1 / (1 + std::exp(-T(cloud.opacity_logit[i])));
  if (antialiased) out.opacity *= f.compensation;
  if (!(out.opacity >= (kCutOffs ? T(splat::kMinAlpha) : T(0)))) return false;
  out.u = f.u, out.v = f.v, out.depth = f.depth;
  out.slope = f.xy / f.yy;
  out.variance_x = f.determinant / f.yy;
  out.half_inverse_x = T(0.5) / out.variance_x;
  out.half_inverse_y = T(0.5) / f.yy;
  out.reach = kCutOffs ? 2 * std::log(out.opacity / T(splat::kMinAlpha)) + T(kReachMargin) : T(1e20);
  out.half_height = std::sqrt(out.reach * f.yy) + T(kMargin);
  if (out.v + out.half_height < 0 || out.v - out.half_height > T(view.height)) return false;
  const T half_width = std::sqrt(out.reach * f.xx) + T(kMargin);
  if (out.u + half_width < 0 || out.u - half_width > T(view.width)) return false;
  const Vec3<T> color = sh_color<T>(cloud.sh_degree, cloud.sh_of(i), (position - view.centre).normalized());
  for (int c = 0; c < 3; ++c) out.color[c] = color[c];
  out.index = i;
  return std::isfinite(color.sum());
}

// Range of whole numbers i with i + 0.5 in [low, high], cut to [0, n).
struct Range {
  int first, last;
  bool empty() const { return first > last; }
};
template <class T>
Range pixels_between(T low, T high, int n) {
  const T first = std::ceil(low - T(0.5)), last = std::floor(high - T(0.5));
  return {static_cast<int>(bounded(first, T(0), T(n))), static_cast<int>(bounded(last, T(-1), T(n - 1)))};
}

// Calls visit(tile) for every tile that the splat enters, by its horizontal extent within each row of tiles.
template <class T, class Visit>
void for_each_tile(const TiledSplats<T>& tiled, const Splat<T>& s, Visit&& visit) {
  const Range rows = pixels_between(s.v - s.half_height, s.v + s.half_height, tiled.height);
  if (rows.empty()) return;
  const T yy = T(0.5) / s.half_inverse_y, xx = s.variance_x + s.slope * s.slope * yy;
  const T rightmost = s.slope * yy * std::sqrt(s.reach / xx);  // dy at which the ellipse reaches farthest right
  for (int row = rows.first / kTileSize; row <= rows.last / kTileSize; ++row) {
    const T low = T(std::max(rows.first, row * kTileSize)) + T(0.5) - s.v;
    const T high = T(std::min(rows.last, row * kTileSize + kTileSize - 1)) + T(0.5) - s.v;
    const T dy_right = bounded(rightmost, low, high), dy_left = bounded(-rightmost, low, high);
    const auto half_width = [&](T dy) {
      return std::sqrt(std::max(T(0), s.variance_x * (s.reach - 2 * s.half_inverse_y * dy * dy))) + T(kMargin);
    };
    const T left = s.u + s.slope * dy_left - half_width(dy_left);
    const T right = s.u + s.slope * dy_right + half_width(dy_right);
    const Range columns = pixels_between(left, right, tiled.width);
    if (columns.empty()) continue;
    for (int column = columns.first / kTileSize; column <= columns.last / kTileSize; ++column)
      visit(row * tiled.tiles_x + column);
  }
}

template <class T>
std::vector<uint32_t> front_to_back(const std::vector<Splat<T>>& splats) {
  using Key = std::conditional_t<sizeof(T) == 4, uint32_t, uint64_t>;
  std::vector<Key> depth(splats.size());
  // The bits of positive numbers ascend with their value.
  for (size_t i = 0; i < splats.size(); ++i) depth[i] = std::bit_cast<Key>(splats[i].depth);
  return sorted_order<Key>(depth);
}

// Lists of the tiles by counting: fixed blocks of splats are counted, then written in order.
template <class T>
void bin(TiledSplats<T>& tiled) {
  constexpr std::ptrdiff_t kSmallestBlock = 2048, kMostBlocks = 16;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(tiled.splats.size());
  const std::ptrdiff_t block = std::max(kSmallestBlock, (n + kMostBlocks - 1) / kMostBlocks);
  const std::ptrdiff_t blocks = (n + block - 1) / block;
  const int tiles = tiled.tiles();
  std::vector<uint32_t> count(blocks * tiles, 0);
  const auto for_block = [&](std::ptrdiff_t b, auto&& visit) {
    for (std::ptrdiff_t i = b * block; i < std::min(n, (b + 1) * block); ++i)
      for_each_tile(tiled, tiled.splats[i], [&](int tile) { visit(count[b * tiles + tile], i); });
  };
  parallel_for(blocks, [&](std::ptrdiff_t b) { for_block(b, [](uint32_t& slot, std::ptrdiff_t) { ++slot; }); });
  tiled.tile_start.resize(tiles + 1);
  size_t total = 0;
  for (int tile = 0; tile < tiles; ++tile) {
    tiled.tile_start[tile] = static_cast<uint32_t>(total);
    for (std::ptrdiff_t b = 0; b < blocks; ++b) {
      const uint32_t here = count[b * tiles + tile];
      count[b * tiles + tile] = static_cast<uint32_t>(total), total += here;
    }
  }
  CHECK_MSG(total < UINT32_MAX, "too many pairs of tile and splat");
  tiled.tile_start[tiles] = static_cast<uint32_t>(total);
  tiled.tile_splat.resize(total);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    for_block(b, [&](uint32_t& slot, std::ptrdiff_t i) { tiled.tile_splat[slot++] = static_cast<uint32_t>(i); });
  });
}

}  // namespace

template <class T, bool kCutOffs>
TiledSplats<T> tile_splats(const GaussianCloud& cloud, const Camera& camera, bool antialiased) {
  CHECK(camera.width > 0 && camera.height > 0 && cloud.sh_degree >= 0 && cloud.sh_degree <= 3);
  TiledSplats<T> tiled;
  tiled.width = camera.width, tiled.height = camera.height;
  tiled.tiles_x = (camera.width + kTileSize - 1) / kTileSize,
  tiled.tiles_y = (camera.height + kTileSize - 1) / kTileSize;

  const View<T> view = make_view<T>(camera);
  constexpr std::ptrdiff_t kBlock = 4096;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(cloud.size()), blocks = (n + kBlock - 1) / kBlock;
  std::vector<std::vector<Splat<T>>> visible(blocks);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    Splat<T> s;
    for (std::ptrdiff_t i = b * kBlock; i < std::min(n, (b + 1) * kBlock); ++i)
      if (make_splat<T, kCutOffs>(cloud, static_cast<uint32_t>(i), view, antialiased, s)) visible[b].push_back(s);
  });
  std::vector<Splat<T>> splats;
  splats.reserve(std::accumulate(visible.begin(), visible.end(), size_t{0},
                                 [](size_t sum, const auto& v) { return sum + v.size(); }));
  for (const auto& v : visible) splats.insert(splats.end(), v.begin(), v.end());

  const std::vector<uint32_t> order = front_to_back(splats);
  tiled.splats.resize(splats.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(order.size()), [&](std::ptrdiff_t i) { tiled.splats[i] = splats[order[i]]; }, 4096);
  bin(tiled);
  return tiled;
}

template TiledSplats<float> tile_splats<float, true>(const GaussianCloud&, const Camera&, bool);
template TiledSplats<double> tile_splats<double, true>(const GaussianCloud&, const Camera&, bool);
template TiledSplats<double> tile_splats<double, false>(const GaussianCloud&, const Camera&, bool);

}  // namespace pliant
