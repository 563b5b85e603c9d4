#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "gaussians/base/portable.h"
#include "physics/mpm/mpm.h"
#include "physics/mpm/team.h"

namespace pliant {

template <class T>
bool Mpm<T>::advance(int count, T dt, StepLoads<T>& loads, const std::function<void(int)>& prepare,
                     const std::function<bool()>& check) {
  constexpr int kParticlesPerThread = 1000;  // below this a thread costs more than it brings
  const int useful = static_cast<int>(std::min<size_t>(data_.record.size() / kParticlesPerThread, 1024));
  const int threads = std::clamp(omp_get_max_threads(), 1, std::max(1, useful));
  std::exception_ptr error;
  Queue scatter, update, gather;
  bool going = true, good = true;
  // What one thread does between steps.
  const auto between = [&](int k) {
    try {
      if (k > 0) {
        collect_reports();
        good = finite_ && check();
      }
      going = good && k < count;
      if (going) prepare(k);
    } catch (...) {
      error = std::current_exception(), going = false;
    }
    scatter.reset(), update.reset(), gather.reset();
  };
  std::unique_ptr<Barrier> barrier;
#pragma omp parallel num_threads(threads)
  {
#pragma omp single
    barrier = std::make_unique<Barrier>(omp_get_num_threads());
    for (int k = 0;; ++k) {
      if (omp_get_thread_num() == 0) between(k);
      barrier->wait();
      if (!going) break;
      for (int b; (b = scatter.take()) < data_.grid.particle_blocks();) scatter_block(b, dt, loads);
      barrier->wait();
      for (int n; (n = update.take()) < data_.grid.node_blocks();)
        sum_node_block(n), update_node_block(n, dt, loads), apply_conditions(n, loads);
      barrier->wait();
      for (int b; (b = gather.take()) < data_.grid.particle_blocks();) gather_block(b, dt);
      barrier->wait();
    }
  }
  if (error) std::rethrow_exception(error);
  return good;
}

template <class T>
void Mpm<T>::particles_to_grid(T dt, const StepLoads<T>& loads) {
  for (int b = 0; b < data_.grid.particle_blocks(); ++b) scatter_block(b, dt, loads);
  for (int n = 0; n < data_.grid.node_blocks(); ++n) sum_node_block(n);
}

template <class T>
void Mpm<T>::update_grid(T dt, const StepLoads<T>& loads) {
  for (int n = 0; n < data_.grid.node_blocks(); ++n) update_node_block(n, dt, loads), apply_conditions(n, loads);
}

template <class T>
void Mpm<T>::grid_to_particles(T dt) {
  for (int b = 0; b < data_.grid.particle_blocks(); ++b) gather_block(b, dt);
  collect_reports();
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
