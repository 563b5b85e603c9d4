#include "fitting/objective/motion.h"

#include <chrono>

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

template <class T>
void add(const StateGradient<T>& from, StateGradient<T>& to) {
  for (size_t i = 0; i < from.x.size(); ++i) {
    to.x[i] += from.x[i];
    to.v[i] += from.v[i];
    to.C[i] += from.C[i];
    to.F[i] += from.F[i];
  }
}

}  // namespace

template <class T>
double Objective<T>::of(const Rollout<T>& rollout) const {
  double total = 0;
  for (const WholeTerm& term : whole) total += term.weight * term.loss->value(rollout.frames);
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
  result.rollout_seconds = since(clock);
  clock = Clock::now();
  std::vector<StateGradient<T>> whole;  // [frames], unless nothing looks at all of them
  if (!objective.whole.empty()) whole.assign(run.frames.size(), StateGradient<T>::zero(motion.particles.size()));
  for (const auto& term : objective.whole)
    result.loss += term.weight * term.loss->value_adjoint(run.frames, term.weight, whole);
  result.frames_seconds = since(clock);
  result.by = rollout_adjoint<T>(
      motion.options, motion.particles, motion.interactions, run, [&](int frame, StateGradient<T>& gradient) {
        const auto begin = Clock::now();
        for (const auto& term : objective.terms)
          result.loss += term.weight * term.loss->value_adjoint(frame, run.frames[frame], term.weight, gradient);
        if (!whole.empty()) add(whole[frame], gradient);
        result.frames_seconds += since(begin);
      });
  result.reverse_seconds = since(clock) - result.frames_seconds;
  return result;
}

#define PLIANT_INSTANTIATE(T)                                            \
  template struct Objective<T>;                                          \
  template double motion_loss<T>(const Motion<T>&, const Objective<T>&); \
  template MotionGradient<T> motion_loss_adjoint<T>(const Motion<T>&, const Objective<T>&);
PLIANT_INSTANTIATE(float)
PLIANT_INSTANTIATE(double)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
