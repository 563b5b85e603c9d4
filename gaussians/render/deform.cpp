#include "gaussians/render/deform.h"

#include <algorithm>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/deform_kernels.h"
#include "gaussians/render/spherical_harmonics.h"
#include "gaussians/render/splat_kernels.h"

namespace pliant {
namespace {

// A Gaussian grows or shrinks at most by this factor along an axis; beyond it, the picture would show the solver's
// strain at single particles as needles.
constexpr float kStretchLimit = 4;

}  // namespace

void deform(const DeformOptions& options, const GaussianCloud& rest, const Binding& binding,
            std::span<const Vec3f> drivers_rest, std::span<const Vec3f> drivers_now, std::span<const Mat3f> F,
            GaussianCloud& out) {
  CHECK(binding.size() == rest.size() && &rest != &out);
  CHECK(drivers_rest.size() == drivers_now.size() && F.size() == drivers_now.size());
  out = rest;
  const ShRotation<float> sh_rotation;
  parallel_for(
      static_cast<std::ptrdiff_t>(rest.size()),
      [&](std::ptrdiff_t g) {
        const int* driver = binding.driver.data() + g * Binding::kCount;
        if (driver[0] < 0) return;
        Vec3f from[Binding::kCount], to[Binding::kCount];
        Mat3f gradient[Binding::kCount];
        int count = 0;
        for (; count < Binding::kCount && driver[count] >= 0; ++count) {
          from[count] = drivers_rest[driver[count]], to[count] = drivers_now[driver[count]];
          gradient[count] = F[driver[count]];
        }
        const RigidFit<float> fit = fit_rigid(count, binding.weight.data() + g * Binding::kCount, from, to, gradient);
        const Vec3f& x = rest.position[g];
        out.position[g] =
            options.mean_displacement ? Vec3f(x + (fit.now - fit.rest)) : Vec3f(fit.R * (x - fit.rest) + fit.now);
        if (options.stretch) {
          Mat3f axes;
          Vec3f length;
          principal_axes<float>(
              limit_stretch(fit.F, kStretchLimit) * covariance_factor<float>(rest.rotation[g], rest.log_scale[g]), axes,
              length);
          out.rotation[g] = quaternion_wxyz(axes);
          for (int k = 0; k < 3; ++k) out.log_scale[g][k] = std::log(std::max(length[k], 1e-30f));
        } else {
          out.rotation[g] = quaternion_wxyz(fit.R * covariance_factor<float>(rest.rotation[g], Vec3f::Zero()));
        }
        sh_rotation.apply(fit.R, rest.sh_degree, out.sh_of(g));
      },
      256);
}

}  // namespace pliant
