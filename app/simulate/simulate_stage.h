#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "app/simulate/object_material.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

constexpr double kDampingTime = 1;  ///< s, of an object that a pin holds at the start

/// simulate: material and interactions -> material.h5, interactions.json, trajectory.h5.
struct SimulateStage {
  std::string interactions;  ///< file; empty = one push sized to the stiffness
  std::string physgaussian;  ///< file; a configuration of PhysGaussian instead of material, interactions, fps, ...
  bool physgaussian_bugs = false;  ///< its known defects are repeated
  MaterialValues material;         ///< command line's
  std::string material_file;       ///< material.h5 of any particles, whose nearest sample counts; instead of a fit's
  std::string velocity_file;       ///< velocity.h5 of any particles: how the motion starts; instead of a fit's
  double fps = 30, duration = 4;
  std::optional<double> damping_time;  ///< see SimulateOptions; default: the fit's, else kDampingTime where a pin holds
                                       ///< the object at the start, else 0
  double push = 0.15;                  ///< peak deflection of the automatic push, share of the object's height
  bool gravity = true;
  std::string rest_shape = "captured";  ///< of a pinned body: captured (free of stress) or solve (loaded by gravity)
  double settle = 2;  ///< s, at most, that an unpinned or flowing body gets to come to rest before frame 0; 0 = none
  double sleep_speed = 0;  ///< m/s below which parts at rest are not computed; 0 = all are
  double flip_time = 0;    ///< s in which particles lose what the grid cannot hold of their motion; 0 = at once (APIC)
  std::string solver = "auto";    ///< where stencils lie: auto, eulerian or lagrangian, see GridKind
  double contact_friction = 0.2;  ///< Coulomb coefficient of parts of the object against each other: low, as of leaves,
                                  ///< so that none stays hooked on another
  bool obstacles = false;         ///< the rest of the scene's Gaussians are an obstacle
  bool use_fit = true;       ///< material, damping and start of a fit, where there is one and `material` names no E
  bool floor = true;         ///< the plane of the support is a floor, see floor_of
  bool expects_push = true;  ///< it is said where the clip ends before the push begins; of no effect on the motion
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(SimulateStage& stage);
StageInputs<SimulateStage> inputs_of(const RunDirectory& run, const Scene& scene, const SimulateStage& stage);
/// --young, --poisson, --density.
std::vector<Option> material_options(MaterialValues& material);
/// --solver, see grid_kind.
Option solver_option(std::string& solver);
/// The material that simulate will use, see material.h; with a configuration of PhysGaussian its own.
ObjectMaterial check_material(const Scene& scene, const SimulateStage& stage);
nlohmann::json run_simulate(const Context& context, RunDirectory& run, const Scene& scene, const SimulateStage& stage);

}  // namespace pliant
