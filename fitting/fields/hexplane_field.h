#pragma once

#include <cstdint>
#include <memory>

#include "fitting/fields/field.h"
#include "gaussians/base/types.h"

namespace pliant {

/// The defaults are those of a displacement [m] (DreamGaussian4D, Ren et al. 2023).
struct HexplaneOptions {
  int channels = 3;
  int space_resolution = 32;  ///< features along a side of the planes, in space ...
  int time_resolution = 12;   ///< ... and in time
  int features = 32;          ///< per place
  int hidden = 64;            ///< width of the layers between
  int layers = 2;             ///< linear ones with ReLU between them
  double scale = 1;           ///< of what the network adds to its output bias
  uint64_t seed = 0;
  int threads = 1;  ///< of torch; results are equal for a seed and a number of threads
};

/// Field over space and time: features on the planes xy, xz, yz through the box of the points and xt, yt, zt (Cao and
/// Johnson 2023), bilinear, all six multiplied (K-Planes, Fridovich-Keil et al. 2023), then a small network.  Values
/// are [times, points, channels], and points() = times * points.  Parameters: planes of space [3, features, space,
/// space] (rows along the second axis of the plane), planes of time [3, features, time, space] (rows along time), then
/// weight [out, in] and bias [out] of each layer.  The output layer starts with zero weights, so that the field is
/// constant at first; the planes of time start at 1, those of space between 0.1 and 0.5.  In double precision.
class HexplaneField : public Field {
 public:
  virtual size_t parameters() const = 0;
  /// `weight` times the sum of two terms (4D Gaussian Splatting, Wu et al. 2023, with one weight for both): total
  /// variation of the planes of space, the mean squared difference of neighbouring features along both axes; and
  /// smoothness of the planes of time, the mean squared second difference along time.  Each is summed over its planes.
  double roughness(std::span<const double> parameters, double weight, std::span<double> gradient) const override = 0;
};

/// The field over `points` at `times` in [0, 1].  It is there where triplane fields are (has_triplane_fields), and
/// libtorch is loaded by the first call.  Throws Error{kUsage} for impossible options, Error{kInput} when libtorch is
/// not there.
std::unique_ptr<HexplaneField> make_hexplane_field(const HexplaneOptions& options, std::span<const Vec3f> points,
                                                   std::span<const double> times);

}  // namespace pliant
