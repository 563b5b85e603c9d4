#pragma once

#include <cstdint>
#include <memory>

#include "fitting/fields/field.h"
#include "gaussians/base/types.h"

namespace pliant {

/// The defaults are those of a material; a velocity has resolution 24 and three channels.
struct TriplaneOptions {
  int channels = 1;
  int resolution = 8;             ///< features along a side of each plane
  int features = 32;              ///< per place
  int hidden = 32;                ///< width of the layers between
  int layers = 3;                 ///< linear ones with ReLU between them; the networks released with PhysDreamer have 2
  double scale = 1;               ///< of what the network adds to its output bias
  std::vector<double> low, high;  ///< [channels] bounds that the values approach smoothly; empty = none
  uint64_t seed = 0;
  int threads = 1;  ///< of torch; results are equal for a seed and a number of threads
};

/// Field of PhysDreamer (Zhang et al. 2024): features on three planes (xy, xz, yz) through the box of the points,
/// bilinear and summed, then a small network.  Parameters: planes [3, features, resolution, resolution] (rows along the
/// second axis of the plane), then weight [out, in] and bias [out] of each layer.  The output layer starts with zero
/// weights, so that the field is constant at first.  Evaluated in double precision.
class TriplaneField : public Field {
 public:
  virtual size_t parameters() const = 0;
  /// [M, channels] at other points; outside of the box, the value at its border.
  virtual std::vector<double> values_at(std::span<const double> parameters, std::span<const Vec3f> points) const = 0;
  /// Total variation: `weight` times the mean squared difference of neighbouring features along both axes, summed over
  /// the planes.  The paper's weights are 1e-4 for a material, 1e-2 for a velocity.
  double roughness(std::span<const double> parameters, double weight, std::span<double> gradient) const override = 0;
};

/// Whether this program was built with libtorch.
bool has_triplane_fields();
/// Loads what these fields and hexplane fields need (half a second), so that its lack is said before any work.  Throws
/// Error{kInput} when libtorch is not there.
void require_triplane_fields();

/// The field over `points`.  libtorch is loaded by the first call (half a second), not with the program.  Throws
/// Error{kUsage} for impossible options, Error{kInput} when libtorch is not there.
std::unique_ptr<TriplaneField> make_triplane_field(const TriplaneOptions& options, std::span<const Vec3f> points);

}  // namespace pliant
