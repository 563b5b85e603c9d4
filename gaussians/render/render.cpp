#include "gaussians/render/render.h"

#include "gaussians/base/error.h"
#include "gaussians/render/render_as.h"
#include "gaussians/render/tile_input.h"

namespace pliant {
namespace {

// Colour, depth and extra channels of one tile; each further block of channels traverses the tile again.
template <class T>
void render_tile(const BlendKernels<T>& kernels, TileInput<T> in, const Vec3<T>& background, Rendered<T>& out) {
  T transmittance[kTilePixels], sums[(4 + kMostChannelsAtOnce) * kTilePixels];
  const T* features = in.features;
  const int channels = in.channels;
  for (int first = 0; first == 0 || first < channels; first += kMostChannelsAtOnce) {
    in.features = features + first;
    in.channels = std::min(kMostChannelsAtOnce, channels - first);
    kernels.blend(in, transmittance, sums);
    for_each_pixel(in, [&](int x, int y, int pixel) {
      for (int c = 0; c < in.channels; ++c) out.features.at(x, y)[first + c] = sums[(4 + c) * kTilePixels + pixel];
      if (first > 0) return;
      const T left_over = transmittance[pixel];
      for (int c = 0; c < 3; ++c) out.color(x, y, c) = sums[c * kTilePixels + pixel] + left_over * background[c];
      out.depth(x, y) = sums[3 * kTilePixels + pixel];
      out.alpha(x, y) = 1 - left_over;
    });
  }
}

}  // namespace

template <class T, bool kCutOffs>
Rendered<T> render_as(const CloudOf<T>& cloud, const Camera& camera, const RenderOptions& options,
                      std::span<const T> features, int channels, RenderTape<T>* tape) {
  CHECK(features.size() == cloud.size() * channels);
  ProjectedSplats<T> projected =
      project_splats<T, kCutOffs>(cloud, camera, options.antialiased, options.most_pairs, options.instruction_set,
                                  options.screen_variance, options.frame);
  Rendered<T> out{
      {camera.width, camera.height, 3}, {camera.width, camera.height, 1}, {camera.width, camera.height, 1}, {}};
  if (channels > 0) out.features = Image<T>(camera.width, camera.height, channels);
  const BlendKernels<T>& kernels = blend_kernels<T, kCutOffs>(options.instruction_set);
  const Vec3<T> background = options.background.cast<T>();
  const int bands = static_cast<int>(projected.bands.size()) - 1;
  for (int band = 0; band < bands; ++band) {
    TileLists lists = bin_splats<T, kCutOffs>(projected, band, options.instruction_set);
    parallel_for(lists.last_tile - lists.first_tile, [&](std::ptrdiff_t tile) {
      render_tile(kernels, tile_input(projected, lists, static_cast<int>(tile), features, channels), background, out);
    });
    if (tape && bands == 1) tape->lists = std::move(lists);
  }
  if (tape) tape->projected = std::move(projected);
  return out;
}

template Rendered<float> render_as<float, true>(const CloudOf<float>&, const Camera&, const RenderOptions&,
                                                std::span<const float>, int, RenderTape<float>*);
template Rendered<double> render_as<double, true>(const CloudOf<double>&, const Camera&, const RenderOptions&,
                                                  std::span<const double>, int, RenderTape<double>*);
template Rendered<double> render_as<double, false>(const CloudOf<double>&, const Camera&, const RenderOptions&,
                                                   std::span<const double>, int, RenderTape<double>*);

RenderResult render(const CloudOf<float>& cloud, const Camera& camera, const RenderOptions& options,
                    std::span<const float> features, int channels, RenderTape<float>* tape) {
  return render_as<float>(cloud, camera, options, features, channels, tape);
}

}  // namespace pliant
