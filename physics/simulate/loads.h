#pragma once

#include <string>
#include <vector>

#include "physics/simulate/interaction.h"
#include "physics/mpm/mpm.h"
#include "physics/simulate/simulate.h"

namespace pliant {

/// Turns an interaction script into what acts during each substep.
template <class T>
class LoadSchedule {
 public:
  /// Marks the touched particles.  Throws Error{kUsage} when a force, impulse, grab or gust touches none.
  LoadSchedule(const SimulateOptions& options, const BasicParticles<T>& particles,
               const std::vector<Interaction>& interactions);

  const std::vector<uint32_t>& bits() const { return bits_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Whether a pin that reaches the body is active at time t.
  bool pinned(double t) const;
  /// Loads of the substep [t, t + dt]; a load that starts or ends inside it acts for its part of it.
  void at(double t, double dt, const Mpm<T>& solver, StepLoads<T>& loads) const;

 private:
  struct Entry {
    Interaction interaction;
    double end = 0;
    uint32_t bit = 0;
    double mass = 0;           // touched, kg
    std::vector<int> touched;  // only of a grab
    bool reaches_body = false; // only of a pin
  };

  void add_grab(const Entry& entry, double t, double dt, const Mpm<T>& solver, StepLoads<T>& loads) const;

  SimulateOptions options_;
  double body_mass_ = 0;
  std::vector<Entry> entries_;
  std::vector<uint32_t> bits_;
  std::vector<std::string> warnings_;
};

extern template class LoadSchedule<float>;
extern template class LoadSchedule<double>;

}  // namespace pliant
