#include "gaussians/render/tiles.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <numeric>
#include <type_traits>

#include "gaussians/base/error.h"
#include "gaussians/render/project_input.h"
#include "gaussians/simd/radix_sort.h"

namespace pliant {
namespace {

// The bits of positive numbers ascend with their value.
template <class T>
using DepthKey = std::conditional_t<sizeof(T) == 4, uint32_t, uint64_t>;

// Tiles that the bounding box of a splat touches in the rows of tiles [low, high].
template <class T>
size_t touched_tiles(const Splat<T>& s, int low, int high) {
  const int rows = std::min<int>(s.last_row, high) - std::max<int>(s.first_row, low) + 1;
  return static_cast<size_t>(std::max(rows, 0)) * (s.last_column - s.first_column + 1);
}

// Cuts the tiles into bands of at most `most` touched tiles out of `total`, from the number of bounding boxes on each.
template <class T>
std::vector<int> cut_bands(const ProjectedSplats<T>& projected, size_t total, size_t most) {
  if (total <= most) return {0, projected.tiles()};
  // Corners of the boxes; their sum over all tiles before a tile, in both directions, is the count there.
  const int stride = projected.tiles_x + 1;
  std::vector<int64_t> corner(static_cast<size_t>(stride) * (projected.tiles_y + 1), 0);
  for (const Splat<T>& s : projected.splats) {
    ++corner[s.first_row * stride + s.first_column];
    --corner[s.first_row * stride + s.last_column + 1];
    --corner[(s.last_row + 1) * stride + s.first_column];
    ++corner[(s.last_row + 1) * stride + s.last_column + 1];
  }
  std::vector<int> bands = {0};
  std::vector<int64_t> above(projected.tiles_x, 0);
  size_t in_band = 0;
  int64_t along = 0;
  for (int tile = 0; tile < projected.tiles(); ++tile) {
    const int row = tile / projected.tiles_x, column = tile % projected.tiles_x;
    above[column] += corner[row * stride + column];
    along = (column > 0 ? along : 0) + above[column];
    const size_t here = static_cast<size_t>(along);
    if (in_band > 0 && in_band + here > most) {
      bands.push_back(tile);
      in_band = 0;
    }
    in_band += here;
  }
  bands.push_back(projected.tiles());
  return bands;
}

}  // namespace

template <class T, bool kCutOffs>
ProjectedSplats<T> project_splats(const CloudOf<T>& cloud, const Camera& camera, bool antialiased, size_t most_pairs,
                                  InstructionSet set, double screen_variance,
                                  const std::optional<PictureFrame>& frame) {
  CHECK(screen_variance > 0 && (!frame || (frame->width > 0 && frame->height > 0)));
  CHECK(camera.width > 0 && camera.height > 0 && cloud.sh_degree >= 0 && cloud.sh_degree <= 3);
  ProjectedSplats<T> out;
  out.width = camera.width;
  out.height = camera.height;
  out.tiles_x = (camera.width + kTileSize - 1) / kTileSize;
  out.tiles_y = (camera.height + kTileSize - 1) / kTileSize;
  CHECK_MSG(out.tiles_x < 65536 && out.tiles_y < 65536, "image too large");

  const View<T> view = make_view<T>(camera, screen_variance, frame);
  constexpr std::ptrdiff_t kBlock = 4096;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(cloud.size()), blocks = (n + kBlock - 1) / kBlock;
  std::vector<std::unique_ptr<Splat<T>[]>> visible(blocks);
  std::vector<size_t> start(blocks + 1, 0), touched(blocks, 0);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    const size_t begin = b * kBlock, end = std::min(n, (b + 1) * kBlock);
    visible[b].reset(new Splat<T>[end - begin]);
    const ProjectInput<T> input{cloud_input(cloud), view, antialiased, begin, end};
    start[b + 1] = blend_kernels<T, kCutOffs>(set).project(input, visible[b].get());
  });
  for (std::ptrdiff_t b = 0; b < blocks; ++b) start[b + 1] += start[b];
  out.splats.resize(start[blocks]);
  std::vector<DepthKey<T>> depth(start[blocks]);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    for (size_t i = start[b]; i < start[b + 1]; ++i) {
      const Splat<T>& s = out.splats[i] = visible[b][i - start[b]];
      depth[i] = std::bit_cast<DepthKey<T>>(s.depth);
      touched[b] += touched_tiles(s, 0, out.tiles_y - 1);
    }
    visible[b].reset();
  });
  out.order = sorted_order<DepthKey<T>>(depth);
  out.bands = cut_bands(out, std::accumulate(touched.begin(), touched.end(), size_t{0}), most_pairs);
  return out;
}

template <class T, bool kCutOffs>
TileLists bin_splats(const ProjectedSplats<T>& projected, int band, InstructionSet set) {
  constexpr std::ptrdiff_t kSmallestBlock = 2048, kMostBlocks = 16;
  TileLists out;
  out.first_tile = projected.bands[band];
  out.last_tile = projected.bands[band + 1];
  const int low = out.first_tile / projected.tiles_x, high = (out.last_tile - 1) / projected.tiles_x;
  const int tiles = out.last_tile - out.first_tile;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(projected.order.size());
  const std::ptrdiff_t block = std::max(kSmallestBlock, (n + kMostBlocks - 1) / kMostBlocks);
  const std::ptrdiff_t blocks = (n + block - 1) / block;

  // Each block of splats, in order of depth, finds its pairs; they are then dealt out to the tiles in that order.
  std::vector<std::unique_ptr<TilePair[]>> pairs(blocks);
  std::vector<size_t> found(blocks);
  std::vector<uint32_t> count(blocks * tiles, 0);
  std::vector<uint32_t>& first_pair = out.first_pair;
  first_pair.assign(n + 1, 0);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    const size_t begin = b * block, end = std::min(n, (b + 1) * block);
    size_t room = 0;
    for (size_t i = begin; i < end; ++i) room += touched_tiles(projected.splats[projected.order[i]], low, high);
    pairs[b].reset(new TilePair[room + 1]);
    const BinInput<T> input{
        projected.splats.data(), projected.order.data(), begin,          end,          projected.width,
        projected.height,        projected.tiles_x,      out.first_tile, out.last_tile};
    found[b] = blend_kernels<T, kCutOffs>(set).bin(input, pairs[b].get(), count.data() + b * tiles, first_pair.data());
  });
  uint32_t before = 0;
  for (uint32_t& first : first_pair) {
    const uint32_t here = first;
    first = before;
    before += here;
  }
  out.start.resize(tiles + 1);
  size_t total = 0;
  for (int tile = 0; tile < tiles; ++tile) {
    out.start[tile] = static_cast<uint32_t>(total);
    for (std::ptrdiff_t b = 0; b < blocks; ++b) {
      const uint32_t here = count[b * tiles + tile];
      count[b * tiles + tile] = static_cast<uint32_t>(total);
      total += here;
    }
  }
  CHECK_MSG(total < UINT32_MAX, "too many pairs of tile and splat");
  out.start[tiles] = static_cast<uint32_t>(total);
  out.entries.resize(total);
  out.entry_of_pair.resize(total);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    uint32_t splat = UINT32_MAX, pair = 0;
    for (size_t k = 0; k < found[b]; ++k) {
      const TilePair& p = pairs[b][k];
      pair = p.splat == splat ? pair + 1 : first_pair[p.splat];
      splat = p.splat;
      const uint32_t entry = count[b * tiles + p.tile]++;
      out.entries[entry] = {p.blocks, p.splat};
      out.entry_of_pair[pair] = entry;
    }
    pairs[b].reset();
  });
  return out;
}

template ProjectedSplats<float> project_splats<float, true>(const CloudOf<float>&, const Camera&, bool, size_t,
                                                            InstructionSet, double, const std::optional<PictureFrame>&);
template ProjectedSplats<double> project_splats<double, true>(const CloudOf<double>&, const Camera&, bool, size_t,
                                                              InstructionSet, double,
                                                              const std::optional<PictureFrame>&);
template ProjectedSplats<double> project_splats<double, false>(const CloudOf<double>&, const Camera&, bool, size_t,
                                                               InstructionSet, double,
                                                               const std::optional<PictureFrame>&);
template TileLists bin_splats<float, true>(const ProjectedSplats<float>&, int, InstructionSet);
template TileLists bin_splats<double, true>(const ProjectedSplats<double>&, int, InstructionSet);
template TileLists bin_splats<double, false>(const ProjectedSplats<double>&, int, InstructionSet);

}  // namespace pliant
