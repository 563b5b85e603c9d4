#include "fitting/fields/motion.h"

#include <chrono>

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace

template <class T>
double Objective<T>::of(const Rollout<T>& rollout) const {
  double total = 0;
  for (size_t f = 0; f < rollout.frames.size(); ++f)
    for (const Term& term : terms) total += term.weight * term.loss->value(static_cast<int>(f), rollout.frames[f]);
  return total;
}

template <class T>
double motion_loss(const Motion<T>& motion, const Objective<T>& objective) {
  return objective.of(rollout<T>(motion.options, motion.particles, motion.interactions, motion.start));
}

template <class T>
MotionGradient<T> motion_loss_adjoint(const Motion<T>& motion, const Objective<T>& objective) {
  MotionGradient<T> result;
  auto clock = Clock::now();
  const Rollout<T> run = rollout<T>(motion.options, motion.particles, motion.interactions, motion.start);
  result.rollout_seconds = since(clock), clock = Clock::now();
  result.by = rollout_adjoint<T>(motion.options, motion.particles, motion.interactions, run,
                                 [&](int frame, StateGradient<T>& gradient) {
                                   const auto begin = Clock::now();
                                   for (const auto& term : objective.terms)
                                     result.loss += term.weight * term.loss->value_adjoint(frame, run.frames[frame], term.weight, gradient);
                                   result.frames_seconds += since(begin);
                                 });
  result.reverse_seconds = since(clock) - result.frames_seconds;
  return result;
}

#define PLIANT_INSTANTIATE(T)                                          \
  template struct Objective<T>;                                        \
  template double motion_loss<T>(const Motion<T>&, const Objective<T>&); \
  template MotionGradient<T> motion_loss_adjoint<T>(const Motion<T>&, const Objective<T>&);
PLIANT_INSTANTIATE(float)
PLIANT_INSTANTIATE(double)

}  // namespace pliant
