#include "gaussians/render/deform.h"

#include <algorithm>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/deform_kernels.h"
#include "gaussians/render/spherical_harmonics.h"
#include "gaussians/render/splat_kernels.h"

namespace pliant {
namespace {

/// Places (Gaussian, k) of a binding by driver: those of driver d are slot[start[d]] .. slot[start[d + 1] - 1],
/// ascending.
struct SlotsByDriver {
  std::vector<size_t> start;
  std::vector<uint32_t> slot;

  SlotsByDriver(const Binding& binding, size_t drivers) : start(drivers + 1, 0) {
    const auto for_each_slot = [&](auto&& visit) {
      for (size_t g = 0; g < binding.size(); ++g)
        for (size_t s = g * Binding::kCount; s < (g + 1) * Binding::kCount && binding.driver[s] >= 0; ++s) visit(s);
    };
    for_each_slot([&](size_t s) { ++start[binding.driver[s] + 1]; });
    for (size_t d = 0; d < drivers; ++d) start[d + 1] += start[d];
    slot.resize(start[drivers]);
    std::vector<size_t> next(start.begin(), start.end() - 1);
    for_each_slot([&](size_t s) { slot[next[binding.driver[s]]++] = static_cast<uint32_t>(s); });
  }
};

}  // namespace

template <class T>
void deform_as(const DeformOptions& options, const CloudOf<T>& rest, const Binding& binding,
               std::type_identity_t<std::span<const Vec3<T>>> drivers_rest,
               std::type_identity_t<std::span<const Vec3<T>>> drivers_now,
               std::type_identity_t<std::span<const Mat3<T>>> F, CloudOf<T>& out) {
  CHECK(binding.size() == rest.size() && &rest != &out);
  CHECK(drivers_rest.size() == drivers_now.size() && F.size() == drivers_now.size());
  out = rest;
  const ShRotation<T> sh_rotation;
  parallel_for(
      static_cast<std::ptrdiff_t>(rest.size()),
      [&](std::ptrdiff_t g) {
        const GatheredDrivers<T> drivers(binding, g, drivers_rest, drivers_now, F);
        if (drivers.count == 0) return;
        const RigidFit<T> fit = drivers.fit();
        out.position[g] = carried_position(options, fit, rest.position[g]);
        if (options.stretch) {
          Mat3<T> axes;
          Vec3<T> length;
          principal_axes<T>(carried_frame(options, fit) * covariance_factor<T>(rest.rotation[g], rest.log_scale[g]),
                            axes, length);
          out.rotation[g] = quaternion_wxyz(axes);
          for (int k = 0; k < 3; ++k) out.log_scale[g][k] = std::log(std::max(length[k], T(1e-30)));
        } else {
          out.rotation[g] = quaternion_wxyz(
              Mat3<T>(carried_frame(options, fit) * covariance_factor<T>(rest.rotation[g], Vec3<T>::Zero())));
        }
        sh_rotation.apply(fit.R, rest.sh_degree, out.sh_of(g));
      },
      256);
}

void deform(const DeformOptions& options, const GaussianCloud& rest, const Binding& binding,
            std::span<const Vec3f> drivers_rest, std::span<const Vec3f> drivers_now, std::span<const Mat3f> F,
            GaussianCloud& out) {
  deform_as<float>(options, rest, binding, drivers_rest, drivers_now, F, out);
}

template <class T>
DeformGradientOf<T> deform_adjoint(const DeformOptions& options, const CloudOf<T>& rest, const Binding& binding,
                                   std::type_identity_t<std::span<const Vec3<T>>> drivers_rest,
                                   std::type_identity_t<std::span<const Vec3<T>>> drivers_now,
                                   std::type_identity_t<std::span<const Mat3<T>>> F,
                                   std::type_identity_t<std::span<const Vec3<T>>> adj_position,
                                   std::type_identity_t<std::span<const Mat3<T>>> adj_covariance,
                                   std::type_identity_t<std::span<const T>> adj_sh) {
  CHECK(binding.size() == rest.size() && adj_position.size() == rest.size() && adj_covariance.size() == rest.size());
  CHECK(drivers_rest.size() == drivers_now.size() && F.size() == drivers_now.size());
  CHECK(adj_sh.empty() || adj_sh.size() == rest.sh.size());

  // Every Gaussian's derivative with respect to its fit; then every driver sums over the Gaussians that it moves.
  struct Row {
    RigidFitAdjoint<T> adj;
    Vec3<T> rest;  // mean of the drivers
  };
  std::vector<Row> rows(rest.size());
  const ShRotation<T> sh_rotation;
  parallel_for(
      static_cast<std::ptrdiff_t>(rest.size()),
      [&](std::ptrdiff_t g) {
        const GatheredDrivers<T> drivers(binding, g, drivers_rest, drivers_now, F);
        if (drivers.count == 0) return;
        const RigidFit<T> fit = drivers.fit();
        const Mat3<T> A = covariance_factor<T>(rest.rotation[g], rest.log_scale[g]);
        Mat3<T> adj_R = Mat3<T>::Zero(), adj_F;
        Vec3<T> adj_now;
        if (!adj_sh.empty()) {
          sh_rotation.apply_adjoint(fit.R, rest.sh_degree, rest.sh_of(g), adj_sh.data() + g * rest.sh_count() * 3,
                                    adj_R);
        }
        carried_adjoint<T>(options, fit, rest.position[g], A * A.transpose(), adj_position[g], adj_covariance[g], adj_R,
                           adj_now, adj_F);
        rows[g] = {fit_rigid_adjoint<T>(drivers.count, drivers.weight, drivers.rest, fit, adj_R, adj_now, adj_F),
                   fit.rest};
      },
      256);

  DeformGradientOf<T> gradient{std::vector<Vec3<T>>(F.size(), Vec3<T>::Zero()),
                               std::vector<Mat3<T>>(F.size(), Mat3<T>::Zero())};
  const SlotsByDriver slots(binding, F.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(F.size()),
      [&](std::ptrdiff_t d) {
        for (size_t i = slots.start[d]; i < slots.start[d + 1]; ++i) {
          const Row& row = rows[slots.slot[i] / Binding::kCount];
          const T weight = T(binding.weight[slots.slot[i]]);
          gradient.drivers_now[d] += weight * (row.adj.moment * (drivers_rest[d] - row.rest) + row.adj.now);
          gradient.F[d] += weight * row.adj.F;
        }
      },
      64);
  return gradient;
}

#define PLIANT_INSTANTIATE(T)                                                                                      \
  template void deform_as<T>(const DeformOptions&, const CloudOf<T>&, const Binding&, std::span<const Vec3<T>>,    \
                             std::span<const Vec3<T>>, std::span<const Mat3<T>>, CloudOf<T>&);                     \
  template DeformGradientOf<T> deform_adjoint<T>(                                                                  \
      const DeformOptions&, const CloudOf<T>&, const Binding&, std::span<const Vec3<T>>, std::span<const Vec3<T>>, \
      std::span<const Mat3<T>>, std::span<const Vec3<T>>, std::span<const Mat3<T>>, std::span<const T>);
PLIANT_INSTANTIATE(float)
PLIANT_INSTANTIATE(double)

}  // namespace pliant
