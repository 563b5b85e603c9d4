#include "gaussians/io/splats/half_turn.h"

#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/render/spherical_harmonics.h"

namespace pliant {
namespace {

/// The axes in which a basis function of the harmonics is odd, as bits 1 = x, 2 = y, 4 = z, in the order of 3DGS.
constexpr int kOddAxes[16] = {0, 2, 4, 1, 3, 6, 0, 5, 0, 2, 7, 2, 4, 1, 4, 1};

}  // namespace

void turn_half(GaussianCloud& cloud, int axis) {
  CHECK(axis >= 0 && axis < 3);
  Vec3f sign = Vec3f::Constant(-1);
  sign[axis] = 1;
  float harmonic[16];
  for (int k = 0; k < 16; ++k) {
    harmonic[k] = 1;
    for (int a = 0; a < 3; ++a) harmonic[k] *= kOddAxes[k] & (1 << a) ? sign[a] : 1.0f;
  }
  const int count = cloud.sh_count();
  for (size_t i = 0; i < cloud.size(); ++i) {
    cloud.position[i] = cloud.position[i].cwiseProduct(sign);
    // Conjugation with the half turn keeps the imaginary part along its axis and negates the other two.
    cloud.rotation[i].tail<3>() = cloud.rotation[i].tail<3>().cwiseProduct(sign);
    for (int k = 1; k < count; ++k) {
      for (int c = 0; c < 3; ++c) cloud.sh_of(i)[3 * k + c] *= harmonic[k];
    }
  }
}

void turn_y_up(GaussianCloud& cloud, bool z_is_up) {
  if (!z_is_up) return turn_half(cloud, 0);
  Mat3f R;  // x, y, z -> x, z, -y
  R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const ShRotation<float> harmonics;
  for (size_t i = 0; i < cloud.size(); ++i) {
    cloud.position[i] = R * cloud.position[i];
    const Vec4f q = cloud.rotation[i];
    // The quaternion of R is (1, -1, 0, 0) / sqrt(2).
    cloud.rotation[i] = static_cast<float>(M_SQRT1_2) * Vec4f(q[0] + q[1], q[1] - q[0], q[2] + q[3], q[3] - q[2]);
    harmonics.apply(R, cloud.sh_degree, cloud.sh_of(i));
  }
}

}  // namespace pliant
