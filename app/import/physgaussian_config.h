#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// A configuration of PhysGaussian (Xie et al. 2024) with the defaults of its released code.  Lengths are in its
/// simulation space, where the object's largest extent is `scale` and its centre (1, 1, 1); E in Pa, times in s.
struct PhysGaussianConfig {
  std::string material = "jelly";  ///< jelly, metal, sand, foam, snow, plasticine
  double grid_lim = 2;             ///< edge of the domain [0, grid_lim]^3
  int n_grid = 50;                 ///< cells per edge
  double young = 1e5, poisson = 0.4, density = 200;
  double yield_stress = 0, xi = 0, softening = 0.1, plastic_viscosity = 0, friction_angle = 25;
  bool hardening = false;
  Vec3d gravity = Vec3d::Zero();
  double rpic_damping = 0, grid_v_damping_scale = 1.1;
  double substep_dt = 1e-4, frame_dt = 1e-2;
  int frame_num = 100;

  double opacity_threshold = 0.02, scale = 1;
  std::vector<double> rotation_degree;            ///< one after the other about the axes below, about the origin
  std::vector<int> rotation_axis;                 ///< 0 x, 1 y, 2 z
  std::optional<std::array<double, 6>> sim_area;  ///< x0, x1, y0, y1, z0, z1 after the rotations

  /// Box in simulation space with a material of its own.
  struct MaterialBox {
    Vec3d point, half;
    double young, poisson, density;
  };
  std::vector<MaterialBox> additional_material;

  enum class BoundaryType {
    kCuboid,              ///< grid nodes in a box take a velocity; the box moves with it
    kImpulse,             ///< force on every particle of a box during num_dt steps
    kBoundingBox,         ///< walls three cells inside the domain
    kTranslation,         ///< particles of a box take a velocity
    kRotation,            ///< particles of a cylinder turn about its axis
    kSurface,             ///< half space that nothing enters
    kReleaseSequentially  ///< particles are held and set free layer by layer
  };
  struct Boundary {
    BoundaryType type = BoundaryType::kBoundingBox;
    double start = 0, end = 1e3;  ///< s
    Vec3d point = Vec3d::Ones(), half = Vec3d::Ones(), velocity = Vec3d::Zero(), force = Vec3d::Zero(),
          normal = Vec3d::Zero();
    bool reset = false;
    int num_dt = 1, num_layers = 50;
    std::string surface = "sticky";  ///< sticky, slip, separate, cut
    double friction = 0;
    double half_height = 0, radius = 0, rotation = 0, translation = 0;  ///< rad/s, units/s
    double start_position = 0, end_position = 0;
  };
  std::vector<Boundary> boundaries;

  struct Filling {
    int n_grid = 200, max_particles_num = 2000000, max_particles_per_cell = 1;
    double density_threshold = 5, search_threshold = 3;
    int search_exclude_direction = 5, ray_cast_direction = 4;
    std::optional<std::array<double, 6>> boundary;
    bool smooth = false, visualize = false;
  };
  std::optional<Filling> filling;

  struct View {
    Vec3d centre = Vec3d::Ones(), up = Vec3d::UnitZ();
    int default_camera_index = 0;
    bool show_hint = false, move_camera = false;
    std::optional<double> azimuth, elevation, radius;                 ///< degrees, degrees, units
    double delta_azimuth = 0, delta_elevation = 0, delta_radius = 0;  ///< per frame
  };
  View view;
  std::vector<std::string> view_keys;  ///< those of `view` that the file has

  std::vector<std::string>
      notes;  ///< keys that PhysGaussian itself reads wrongly or ignores, and what was made of them

  double cell_size() const { return grid_lim / n_grid; }
};

/// Whether a box selects what lies at x: strictly inside, as in PhysGaussian.
inline bool in_physgaussian_box(const Vec3d& x, const Vec3d& centre, const Vec3d& half) {
  return ((x - centre).cwiseAbs().array() < half.array()).all();
}

/// Reads a configuration.  Throws Error{kUsage} naming file, key and value for unknown keys (with the nearest known
/// one) and for values that cannot be simulated, such as nu = 0.5.
PhysGaussianConfig read_physgaussian_config(const std::filesystem::path& file);

}  // namespace pliant
