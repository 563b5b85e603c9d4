#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "fitting/fields/field.h"
#include "fitting/objective/motion.h"

namespace pliant {

struct GradientFitOptions {
  int iterations = 100;
  int first_window = 6;  ///< frames that are compared at first (PhysDreamer) ...
  double growth = 0.5;   ///< ... and all of them from this share of the iterations on, at the latest in the last one
  double material_rate = 0.01, velocity_rate = 0.01, poisson_rate = 0.05, density_rate = 0.02,
         damping_rate = 0.02;                                   ///< of Adam; fall to a tenth by the end
  double material_roughness = 1e-4, velocity_roughness = 1e-2;  ///< weights of the fields' total variation
  double material_limit = INFINITY;                             ///< of each parameter of the field of E, either way
  double density_limit = INFINITY;                              ///< likewise
  double clip = 1;       ///< largest norm of the gradient of one field's parameters
  int patience = 20;     ///< iterations with all frames and no better loss, after which it stops
  double better = 1e-3;  ///< relative fall of the loss that counts as better
  double astray =
      INFINITY;  ///< relative rise of the loss over the best after which it goes back there, with half the rates
  double weight_decay = 0;  ///< of AdamW (Loshchilov and Hutter 2019)
  int warm_up = 0;          ///< iterations in which the rates rise from 0 ...
  bool linear = false;      ///< ... and then fall to 0 in a line, instead of to a tenth by a cosine
  bool noisy = false;  ///< losses of two iterations cannot be compared, as in score distillation: no early stop, the
                       ///< last is best
};

/// One iteration.
struct GradientFitRow {
  int frames = 0;   ///< compared
  double loss = 0;  ///< of the frames, without roughness
  double rollout_seconds = 0, frames_seconds = 0, reverse_seconds = 0, field_seconds = 0;
};

struct GradientFitParameters {
  std::vector<double> material, velocity;          ///< of the fields; empty without one
  double damping = 0;                              ///< ln of the factor of the rate of mass-proportional damping
  std::vector<double> poisson = {}, density = {};  ///< of their fields; empty without one
};

/// Everything that an iteration starts from: a fit continues from here bit for bit.
struct GradientFitState {
  GradientFitParameters now, best;                  ///< best: of the least loss over all frames
  std::vector<double> first_moment, second_moment;  ///< of Adam, [all parameters]
  long steps = 0;                                   ///< that made these moments
  double rate = 1;                                  ///< halved each time that the loss has gone astray
  double best_loss = -1;                            ///< negative: none yet
  int without_better = 0;
  std::vector<GradientFitRow> rows;  ///< of the iterations done
  bool finished = false;
};

constexpr double kMostPoisson = 0.49;  ///< that a fit of Poisson's ratio stays below; it also stays above 0 ...
constexpr double kPoissonStart[2] = {0.01, 0.98 * kMostPoisson};  ///< ... and starts within

/// E = E0 + step f, kept between bounds, all in Pa, as in PhysDreamer's released code.
struct AddedYoung {
  double step = 1, low = 0, high = INFINITY;
};

/// What is fitted: ln of a factor of each particle's E, and a velocity [m/s] that is added to its start.  A motion
/// under no known force determines E / density alone: with a field of both, `keep_mass` decides the rest.
struct GradientFitFields {
  const Field* material = nullptr;  ///< one channel; null = E stays
  const Field* velocity = nullptr;  ///< three channels; null = the start stays
  bool damping = false;             ///< the damping time too, where the motion has one
  const Field* poisson = nullptr;   ///< one channel: ln of the factor of nu / (kMostPoisson - nu); null = nu stays
  std::optional<AddedYoung> added_young = {};  ///< what `material` is instead of a factor
  const Field* density = nullptr;              ///< one channel: ln of the factor of the density; null = it stays
  bool keep_mass = false;                      ///< these factors are divided by what they make of the total mass
};

/// Called after every iteration; false stops, and the state may be continued later.
using GradientFitSink = std::function<bool(const GradientFitState&)>;

/// Adam on the fields' parameters with exact gradients through MLS-MPM (PhysDreamer, Zhang et al. 2024), over a window
/// of frames that grows from the start; the best is never worse than the start, and what the last step leads to counts.
/// `state` is where it begins: `now`, and all else empty, or an earlier state.  Particles and start of `motion` are
/// those without the fields.  Its gradient_window cuts the way back (rollout.h).  Equal bit for bit for any number of
/// threads.
void fit_gradient(const GradientFitOptions& options, const Motion<float>& motion, const Objective<float>& objective,
                  const GradientFitFields& fields, GradientFitState& state, const GradientFitSink& sink = {});

/// Scales a gradient that is longer than `most` down to it.  Throws Error{kNumerical} with `remedy` where it is not
/// finite.
void clip_norm(std::span<double> gradient, double most, const std::string& remedy);

/// What a rate is multiplied by in iteration `k`: from 1 to a tenth by a cosine.
double cosine_fall(int k, int iterations);

/// The motion with the fields applied; its frames have more substeps once sound is 1.5 times as fast as without.
Motion<float> with_fields(const Motion<float>& motion, const GradientFitFields& fields,
                          const GradientFitParameters& at);

}  // namespace pliant
