#pragma once

#include <string>
#include <vector>

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
  double damping_time = 1.6;  ///< s in which an amplitude falls to 1/e
  double travel = 0.055;      ///< wanted peak motion of the blossom [m]
  uint64_t seed = 1;
};

/// The flower of a stage swaying from a known push, simulated on samples of its analytic solid.
struct ReferenceMotion {
  SolidSamples samples;                   ///< world [m]; one particle each
  ElasticSamples material;                ///< of the samples
  std::vector<Interaction> interactions;  ///< the pin around the pot and the push on the blossom
  SimulateOptions options;
  SimulateSummary summary;
  std::vector<SimulationState> frames;  ///< at 0, 1/fps, ...
  double cell_size = 0;                 ///< [m]
};
ReferenceMotion simulate_reference(const Stage& stage, const ReferenceOptions& options);

/// The motion filmed by one camera.
struct ReferenceFilm {
  std::vector<ImageF> frames;          ///< [H, W, 3]
  std::vector<Vec3d> tip;              ///< centre of the blossom, world [m], per frame
  std::vector<Eigen::Vector2d> pixel;  ///< its place in the picture
  double peak_pixels() const;          ///< largest distance from the place in the first frame
  double peak_metres() const;
};

/// Draws a fine mesh of the flower's surfaces, carried by the particles and painted as at rest, into the ray-cast view
/// of everything that stands still; hidden surfaces by depth, 3 x 3 samples a pixel.
ReferenceFilm film_reference(const Stage& stage, const ReferenceMotion& motion, const Camera& camera);

}  // namespace pliant
