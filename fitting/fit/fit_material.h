#pragma once

#include "fitting/fields/kan_field.h"
#include "fitting/fields/smooth_field.h"
#include "fitting/fields/triplane_field.h"
#include "fitting/fit/fit_clip.h"
#include "fitting/fit/fit_vibration.h"
#include "fitting/fit/young_posterior.h"
#include "fitting/modal/dissipation.h"
#include "fitting/objective/clip_objective.h"

namespace pliant {

enum class MaterialKind { kUniform, kParts, kSmooth, kTriplanes, kKan };

/// What PhysDreamer's released code (train/*.py, commit 95beb71) does and its paper does not say, for fit_physdreamer
/// with triplanes: E = E0 + 1000 f(x) and v0 = 0.1 g(x) in a cube, networks of two layers, mean squared error instead
/// of L1, AdamW with warm-up and a linear fall, half as many iterations again for v0 as for E.
struct PhysDreamerCode {
  static constexpr double kYoungStep = 1000, kYoungLow = 1e3, kYoungHigh = 5e8;  // Pa in the cube
  static constexpr double kSpeedStep = 0.1;                                      // edges a second
  double edge = 1;  ///< of the cube [m]; densities and times are those outside of it, so E grows with its square
};

struct MaterialFitOptions {
  VibrationFitOptions vibration;  ///< its field is this fit's
  MaterialKind kind = MaterialKind::kUniform;
  std::vector<uint32_t> part;  ///< [N] of the particles, from 0 without gaps, for kParts
  double part_sigma = 0.5;     ///< decades by which a part is expected to differ from the common factor
  SmoothFieldOptions smooth;   ///< for kSmooth, in metres
  TriplaneOptions planes;      ///< of E, for kTriplanes; those of v0 have a resolution of 24 and no bounds
  KanFieldOptions kan;         ///< of E, for kKan; its bound is `decades`
  double decades =
      2;  ///< by which a part may differ from the best constant, and E at a point from where gradients begin
  bool smooth_first = true;  ///< they begin from a fit of a smooth field rather than from the best constant
  /// Of kTriplanes and kKan, and of every kind once `clip` compares more than tracks.  Its windows are in frames of the
  /// video.
  GradientFitOptions gradient;
  int gradient_window = 0;                       ///< frames of the video through which gradients run back; 0 = all
  int clip_frames = 0;                           ///< of fit_physdreamer: compared, with that of its start; 0 = all
  bool poisson = false;                          ///< Poisson's ratio too: one, of each part, or a smooth field
  bool density = false;                          ///< the density likewise
  ClipTerms clip;                                ///< that these gradients compare
  std::optional<PhysDreamerCode> released_code;  ///< of fit_physdreamer alone
};

/// Where an interrupted fit goes on, and who keeps what is done.
struct MaterialFitProgress {
  std::optional<VibrationFit> homogeneous;  ///< of an earlier call
  std::optional<VibrationFit> field;        ///< of an earlier call: from the homogeneous on
  VibrationFitState vibration;              ///< of an earlier call: of the first of these two that is not done
  GradientFitState velocity;                ///< of an earlier call: of v0 alone (fit_physdreamer.h)
  GradientFitState gradient;                ///< of an earlier call
  PosteriorState posterior;                 ///< of an earlier call: about what gradients found
  std::function<void(const VibrationFit&)> keep_homogeneous, keep_field;
  VibrationFitSink keep_vibration;
  PosteriorSink keep_posterior;
  GradientFitSink keep_velocity, keep_gradient;  ///< false stops the fit with Error{kInterrupted}
};

/// What a stage of a fit brought.
struct FitStep {
  std::string name;
  double rms = 0;  ///< of the tracks, in their unit
  double seconds = 0;
  bool converged = true;
  std::string stopped_by;     ///< empty where there is nothing to stop
  std::vector<double> loss;   ///< at its start and after every step; of gradients, over as many frames as the last
  bool by_gradients = false;  ///< this loss is that of the frames compared, else the tracks' error
};

/// E(x) and the motion that explains the tracks.
struct MaterialFit {
  VibrationFit homogeneous;   ///< the best constant
  VibrationFit found;         ///< with the field; its log10_factor is against the particles that the fit was given
  std::vector<double> young;  ///< [N] Pa
  std::vector<double> sigma;  ///< [N] decades, one standard deviation of log10 E
  double prior_sigma = 0;     ///< [decades] of a particle's E before any track was seen
  Dissipation losses;         ///< of the swing that was found, over the frames compared; zero from fit_physdreamer
  bool field_left = false;    ///< a field explained the tracks no better than the best constant, which was kept
  Particles particles;        ///< with that E
  std::vector<FitStep> steps;
  std::vector<GradientFitRow> iterations;  ///< of the gradients

  /// Whether the tracks, rather than the prior, decide the E of a particle: its variance fell to a quarter.
  bool determined(size_t particle) const { return !sigma.empty() && sigma[particle] < 0.5 * prior_sigma; }
};

/// What gradients vary for a kind of material: its field of E, damping, for triplanes v0(x), and Poisson's ratio and
/// the density, its total mass kept, if asked for.  What `interactions` hold for good keeps v0 and, but for fields with
/// one value for many particles, E.
ClipFitOptions gradient_fields(const MaterialFitOptions& options, const Particles& particles,
                               const std::vector<Interaction>& interactions);

/// Mean log10 of the factors by which E of the particles differs from before.
double mean_log10_factor(const Particles& fitted, const Particles& before);

/// What gradients brought, and what their motion leaves of the tracks.
FitStep step_of(const std::string& name, const ClipFit& clip, const TrackLoss<float>& tracks, const ClipFrames& frames);

/// How sure the tracks make E and damping about what gradients found (young_posterior.h), in the directions in which a
/// material of this kind may vary; of networks, the modes of a smooth field.
void find_posterior(const MaterialFitOptions& options, const Motion<float>& motion, const TrackLoss<float>& tracks,
                    const ClipFrames& frames, const MaterialFitProgress& kept, MaterialFit& fit);

/// The homogeneous fit (fit_vibration.h); then, for parts and smooth fields, Gauss-Newton once more from there with a
/// field of factors of E, which also says how sure it is and is only taken where it explains more; for triplanes
/// and KANs, or when more than tracks is compared, from there exact gradients (fit_gradient.h) of E(x), damping and,
/// for triplanes, v0(x).
MaterialFit fit_material(const MaterialFitOptions& options, const Particles& particles,
                         const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                         const std::function<void(const std::string&)>& progress = {}, MaterialFitProgress kept = {});

}  // namespace pliant
