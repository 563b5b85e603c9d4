#pragma once

#include <vector>

#include "gaussians/base/image.h"
#include "segmentation/graph/color_model.h"
#include "segmentation/graph/min_cut.h"

namespace pliant {

/// What is known about a pixel beforehand.
enum class PixelSeed : uint8_t { kUnknown, kForeground, kBackground };

struct GrabCutOptions {
  ColorModelOptions color;
  float gamma = 10;           ///< cost of a border between equal colours
  float data = 1;             ///< factor of the colours' log odds; pixels side by side do not tell independent things
  int iterations = 5;         ///< of models and cut; ends early when the cut no longer moves
  std::vector<float> levels;  ///< > 0, ascending: the last cut is repeated with these log odds more and less
};

struct GrabCutInput {
  int width = 0, height = 0;
  std::vector<Vec3f> lab;       ///< [H * W] colours, see lab_of_rgb
  std::vector<PixelSeed> seed;  ///< [H * W]
  std::vector<float> prior;     ///< [H * W] log odds of foreground, or empty
  std::vector<uint8_t> start;   ///< [H * W] first labels of unknown pixels, or empty: all foreground
  // Regions in place of pixels, where area is not empty; width and height do not count.
  std::vector<float> area;     ///< factor of what a region's colour and prior say
  std::vector<CutEdge> edges;  ///< between regions, in place of picture_edges
};

struct GrabCutResult {
  std::vector<uint8_t> foreground;  ///< [H * W]
  int iterations = 0;
  size_t pixels = 0;  ///< of the foreground
  /// [H * W] log odds against which a pixel keeps its label: the middle of the levels between which it flips, positive
  /// for foreground.  Empty without levels.
  std::vector<float> logit;
};

/// Colours of a picture, see lab_of_rgb.
std::vector<Vec3f> lab_pixels(const ImageF& rgb);

/// Edges of pixels to the right, below, and along both diagonals: exp(-beta dLab^2) / distance, beta = 1 / (2 mean
/// dLab^2).
std::vector<CutEdge> picture_edges(int width, int height, const std::vector<Vec3f>& lab);

/// Foreground of a picture by turns of colour models and a minimum cut over 8 neighbours (Rother, Kolmogorov and Blake
/// 2004).  Where one side has no colours left, the labels reached so far are returned.
GrabCutResult grab_cut(const GrabCutOptions& options, const GrabCutInput& input);

}  // namespace pliant
