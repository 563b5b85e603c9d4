#include <algorithm>

#include "app/simulate/simulate_stage.h"

namespace pliant {

std::vector<Option> material_options(MaterialValues& material) {
  return {{.name = "young", .field = &material.young, .help = "Young's modulus [Pa]", .value = "E"},
          {.name = "poisson",
           .field = &material.poisson,
           .help = "Poisson's ratio, -0.2 to 0.5; hencky: from -1",
           .value = "NU"},
          {.name = "density", .field = &material.density, .help = "Density [kg/m^3]", .value = "RHO"}};
}

Option solver_option(std::string& solver) {
  return {.name = "solver",
          .field = &solver,
          .help =
              "lagrangian: MPM on the rest shape, which cannot tear; eulerian: the usual MPM grid, for any law; "
              "auto: lagrangian where possible",
          .choices = {"auto", "lagrangian", "eulerian"}};
}

OptionTable options_of(SimulateStage& stage) {
  OptionTable table{
      "simulate",
      {
          {.name = "interactions",
           .field = &stage.interactions,
           .help = "JSON array of forces (default: the fit's motion, or one push)",
           .value = "FILE",
           .recorded = Recorded::kContents},
          {.name = "material",
           .field = &stage.material_file,
           .help = "E(x), nu(x), rho(x), a material.h5 of any particles",
           .value = "FILE",
           .exists = true,
           .recorded = Recorded::kContents},
          {.name = "velocity",
           .field = &stage.velocity_file,
           .help = "Initial motion, a velocity.h5 of any particles",
           .value = "FILE",
           .exists = true,
           .recorded = Recorded::kContents},
          {.name = "no-fit",
           .field = &stage.use_fit,
           .help = "Ignore the results of a fit",
           .off = true,
           .recorded = Recorded::kElsewhere},
          {.name = "fps", .field = &stage.fps, .help = "Frames per second", .low = 1, .high = 1000},
          {.name = "duration", .field = &stage.duration, .help = "Length of the clip [s]", .low = 0.01, .high = 3600},
          {.name = "damping-time",
           .field = &stage.damping_time,
           .help =
               "Vibrations decay as exp(-t / this), drift and falls as exp(-2 t / this) [s]; 0 = none (default: the "
               "fit's, 1 if pinned, else 0)",
           .low = 0},
          {.name = "auto-push",
           .field = &stage.push,
           .help =
               "Peak deflection of the automatic push, as a fraction of the object's height (of a flat one: of a fifth "
               "of its extent)",
           .low = 0.001,
           .high = 1,
           .formerly = "push"},
          {.name = "rest-shape",
           .field = &stage.rest_shape,
           .help = "Captured shape of a pinned object: free of stress, or loaded by gravity (solve)",
           .choices = {"captured", "solve"}},
          {.name = "settle-time",
           .field = &stage.settle,
           .help = "Maximum settling time of an unpinned or flowing object before the clip [s]",
           .low = 0,
           .formerly = "settle"},
          {.name = "sleep-speed",
           .field = &stage.sleep_speed,
           .help = "Speed below which parts sleep until something touches them [m/s]",
           .low = 0},
          {.name = "flip-time",
           .field = &stage.flip_time,
           .help = "Low-dissipation transfer: time that particles keep motion below the grid scale [s]; 0 = APIC",
           .low = 0},
          solver_option(stage.solver),
          {.name = "contact-friction",
           .field = &stage.contact_friction,
           .help = "Coulomb friction of the object's parts against each other",
           .low = 0,
           .high = 10},
          {.name = "collide-scene",
           .field = &stage.obstacles,
           .help = "Collide with the rest of the scene",
           .formerly = "obstacles"},
          {.name = "no-gravity", .field = &stage.gravity, .help = "No gravity", .off = true},
          {.name = "no-floor",
           .field = &stage.floor,
           .help = "Let the object pass through its support plane",
           .off = true},
          {.name = "physgaussian",
           .field = &stage.physgaussian,
           .help = "PhysGaussian configuration: object, material, boundaries, time",
           .value = "FILE",
           .exists = true,
           .recorded = Recorded::kContents},
          {.name = "physgaussian-bugs",
           .field = &stage.physgaussian_bugs,
           .help = "With --physgaussian: reproduce the known defects of that program",
           .formerly = "compat"},
          {.name = "law",
           .field = &stage.material.law,
           .help = "Constitutive law (default fixed_corotated)",
           .choices = law_names()},
      }};
  for (Option& option : material_options(stage.material)) table.options.push_back(std::move(option));
  for (const MaterialConstant& constant : material_constants()) {
    std::string name = constant.name;
    std::replace(name.begin(), name.end(), '_', '-');
    table.options.push_back({.name = name,
                             .field = EntryField{&stage.material.constants, constant.name},
                             .help = constant.description,
                             .value = "X",
                             .group = "Constants of the law"});
  }
  return table;
}

}  // namespace pliant
