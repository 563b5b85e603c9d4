#include "gaussians/render/render.h"

#include "gaussians/base/error.h"
#include "gaussians/render/blend_tile.h"
#include "gaussians/render/render_as.h"

namespace pliant {
namespace {

// Extra channels blended in one traversal of a tile: its accumulators then stay in the first-level cache.
constexpr int kChannelsAtOnce = 16;

// Sums of `count` attributes over a tile, [count][pixels] in packs.
template <class T, int kMax>
struct TileSums {
  static constexpr int kPacks = kTilePixels / kLanes<T>;
  Pack<T> sum[kMax][kPacks];

  explicit TileSums(int count) {
    for (int c = 0; c < count; ++c)
      for (Pack<T>& pack : sum[c]) pack = Pack<T>{};
  }
  T at(int c, int pixel) const { return sum[c][pixel / kLanes<T>][pixel % kLanes<T>]; }
};

// Calls visit(x, y, pixel of the tile) for every pixel of the tile that lies in the image.
template <class T, class Visit>
void for_each_pixel(const TiledSplats<T>& tiled, int tile, Visit&& visit) {
  const int left = tile % tiled.tiles_x * kTileSize, top = tile / tiled.tiles_x * kTileSize;
  for (int y = top; y < std::min(top + kTileSize, tiled.height); ++y)
    for (int x = left; x < std::min(left + kTileSize, tiled.width); ++x) visit(x, y, (y - top) * kTileSize + x - left);
}

// Colour, depth and extra channels of one tile; each further block of channels traverses the tile again.
template <class T, bool kCutOffs>
void render_tile(const TiledSplats<T>& tiled, int tile, const Vec3f& background, std::span<const float> features,
                 int channels, Rendered<T>& out) {
  for (int first = 0; first == 0 || first < channels; first += kChannelsAtOnce) {
    const int count = std::min(kChannelsAtOnce, channels - first);
    TileTransmittance<T> transmittance;
    TileSums<T, 4 + kChannelsAtOnce> sums(4 + count);
    blend_tile<T, kCutOffs>(tiled, tile, transmittance, [&](const Splat<T>& s, int k, Pack<T> weight) {
      for (int c = 0; c < 3; ++c) sums.sum[c][k] += weight * s.color[c];
      sums.sum[3][k] += weight * s.depth;
      const float* feature = features.data() + static_cast<size_t>(s.index) * channels + first;
      for (int c = 0; c < count; ++c) sums.sum[4 + c][k] += weight * T(feature[c]);
    });
    for_each_pixel(tiled, tile, [&](int x, int y, int pixel) {
      for (int c = 0; c < count; ++c) out.features(x, y, first + c) = sums.at(4 + c, pixel);
      if (first > 0) return;
      const T left_over = transmittance.at(pixel);
      for (int c = 0; c < 3; ++c) out.color(x, y, c) = sums.at(c, pixel) + left_over * T(background[c]);
      out.depth(x, y) = sums.at(3, pixel);
      out.alpha(x, y) = 1 - left_over;
    });
  }
}

}  // namespace

template <class T, bool kCutOffs>
Rendered<T> render_as(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options,
                      std::span<const float> features, int channels) {
  CHECK(features.size() == cloud.size() * channels);
  const TiledSplats<T> tiled = tile_splats<T, kCutOffs>(cloud, camera, options.antialiased);
  Rendered<T> out{
      {camera.width, camera.height, 3}, {camera.width, camera.height, 1}, {camera.width, camera.height, 1}, {}};
  if (channels > 0) out.features = Image<T>(camera.width, camera.height, channels);
  parallel_for(tiled.tiles(), [&](std::ptrdiff_t tile) {
    render_tile<T, kCutOffs>(tiled, static_cast<int>(tile), options.background, features, channels, out);
  });
  return out;
}

template Rendered<float> render_as<float, true>(const GaussianCloud&, const Camera&, const RenderOptions&,
                                                std::span<const float>, int);
template Rendered<double> render_as<double, true>(const GaussianCloud&, const Camera&, const RenderOptions&,
                                                  std::span<const float>, int);
template Rendered<double> render_as<double, false>(const GaussianCloud&, const Camera&, const RenderOptions&,
                                                   std::span<const float>, int);

RenderResult render(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options,
                    std::span<const float> features, int channels) {
  Rendered<float> r = render_as<float>(cloud, camera, options, features, channels);
  return {std::move(r.color), std::move(r.depth), std::move(r.alpha), std::move(r.features)};
}

}  // namespace pliant
