#pragma once

#include <string>
#include <vector>

#include "app/demo/demo_interruption.h"
#include "app/demo/kinds/flower.h"
#include "app/demo/stage.h"
#include "gaussians/base/image.h"
#include "physics/body/make_particles.h"
#include "physics/body/samples.h"
#include "physics/simulate/interaction.h"
#include "physics/simulate/simulate.h"

namespace pliant {

struct ReferenceOptions {
  int particles = 14000;  ///< about; the grid spacing follows as (8 V / N)^(1/3)
  double seconds = 3, fps = 24;
  double courant = 0.35;
  double damping_time = 1.6;      ///< s in which an amplitude falls to 1/e
  double contact_friction = 0.2;  ///< Coulomb coefficient of parts that meet: the default of `simulate`
  double travel = 0.055;          ///< wanted peak motion of the flower's blossom [m]
  uint64_t seed = 1;
  Interrupted interrupted{};  ///< asked per simulated frame
};

/// What moves of a stage, filled with samples; each is one particle.
struct ReferenceBody {
  SolidSamples samples;     ///< world [m]
  std::vector<int> piece;   ///< index of each sample's material in the object
  ElasticSamples material;  ///< of the samples
  Particles particles;
  double cell_size = 0;  ///< of the grid [m]
};
ReferenceBody reference_body(const Stage& stage, const ObjectSolid& solid);
/// All of the object that moves.
ReferenceBody reference_body(const Stage& stage, const ReferenceOptions& options);

/// What a hand or the air does to an object, with its pins.
struct ReferenceScript {
  std::string name;
  std::vector<Interaction> interactions;
};
/// poke (a push of the tip for a quarter of a second), pull (the tip is pulled aside and released), wind (a gust over
/// all for a second) and jolt (an impulse to jolted_region()).  Each moves the body by a sixth of its height or so:
/// forces are found by short trials with fewer particles.
std::vector<ReferenceScript> reference_scripts(const Stage& stage, const ReferenceBody& body,
                                               const ReferenceOptions& options);
/// What the jolt pushes, in the world: the box around the particles that no pin holds, or what the kind says where that
/// box would hold the pinned part.
Region jolted_region(const Stage& stage, const ReferenceBody& body);
/// The same for the flower: a push whose force follows from the stem as a beam.
ReferenceScript flower_script(const Stage& stage, const Flower& flower, const ReferenceOptions& options);

/// An object's motion, simulated on samples of its solid.
struct ReferenceMotion {
  SolidSamples samples;  ///< world [m]; one particle each
  std::vector<Interaction> interactions;
  double fps = 0, damping_time = 0;
  double cell_size = 0;                 ///< [m]
  size_t particles = 0;                 ///< simulated; of `samples` the motion is known
  double time_step = 0;                 ///< smallest [s]
  double max_stretch = 0;               ///< where beyond kFarStretch, else 0
  std::vector<SimulationState> frames;  ///< at 0, 1/fps, ...
};
/// What a motion is known of before it is simulated.
ReferenceMotion without_frames(const ReferenceBody& body, const std::vector<Interaction>& interactions,
                               const ReferenceOptions& options);
/// Throws Error{kInterrupted}.
ReferenceMotion simulate_reference(const ReferenceBody& body, const std::vector<Interaction>& interactions,
                                   const ReferenceOptions& options);
/// The flower down to three cells below the pinned plane.
ReferenceBody flower_body(const Stage& stage, const Flower& flower, const ReferenceOptions& options);

/// The motion filmed by one camera.
struct ReferenceFilm {
  std::vector<ImageF> frames;          ///< [H, W, 3]
  std::vector<Vec3d> tip;              ///< the object's tip, world [m], per frame
  std::vector<Eigen::Vector2d> pixel;  ///< its place in the picture
  double peak_pixels() const;          ///< largest distance from the place in the first frame
  double peak_metres() const;
};

/// Draws a fine mesh of the object's surfaces, carried by the particles and painted as at rest, into the ray-cast view
/// of everything that stands still; hidden surfaces by depth, 3 x 3 samples a pixel.  Throws
/// Error{kInterrupted}.
ReferenceFilm film_reference(const Stage& stage, const ReferenceMotion& motion, const Camera& camera,
                             const Interrupted& interrupted = {});

}  // namespace pliant
