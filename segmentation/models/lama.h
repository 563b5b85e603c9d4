#pragma once

#include "segmentation/model_interfaces/inpainter.h"
#include "segmentation/models/neural_module.h"

namespace pliant {

/// LaMa (Suvorov et al. 2022) as export/export_lama.py writes it; *never run with the official weights*.
///   in   image: float32 [1,3,8h,8w] in 0..1, red first, zero where the hole is; mask: float32 [1,1,8h,8w], 1 = hole
///   out  inpainted: float32 [1,3,8h,8w] in 0..R, red first
/// Sides are filled up by mirroring.  Files of one fixed size name it in the description ("height", "width"); R is
/// "range" there (1, or 255).  Only the surroundings of the hole are looked at; where these are larger than a tile,
/// they are filled at a smaller scale first and then refined by overlapping tiles wherever at least half of a tile is
/// known.
class Lama : public Inpainter {
 public:
  struct Options {
    int tile = 1024;     ///< longest side of what is filled at once, px
    int overlap = 128;   ///< of tiles, px
    double context = 1;  ///< picture looked at on every side of a hole, in its sizes (at least 64 px)
  };

  Lama(std::unique_ptr<NeuralModule> module, const Options& options);

  ImageF inpaint(const ImageF& picture, const ImageU8& mask) override;

 private:
  ImageF fill(const ImageF& picture, const ImageU8& mask);
  ImageF fill_by_tiles(const ImageF& picture, const ImageU8& mask);

  std::unique_ptr<NeuralModule> module_;
  Options options_;
  Contract contract_;
  int fixed_width_ = 0, fixed_height_ = 0, range_ = 1;
};

}  // namespace pliant
