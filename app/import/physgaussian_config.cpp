#include "app/import/physgaussian_config.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/physgaussian_boundary.h"
#include "app/import/physgaussian_keys.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

namespace pliant {
using nlohmann::json;

namespace {

using Config = PhysGaussianConfig;

const std::vector<std::string> kMaterials = {"jelly", "metal", "sand", "foam", "snow", "plasticine"};

const std::vector<std::string> kTopKeys = {"material",
                                           "grid_lim",
                                           "n_grid",
                                           "E",
                                           "nu",
                                           "density",
                                           "additional_material_params",
                                           "yield_stress",
                                           "hardening",
                                           "xi",
                                           "softening",
                                           "plastic_viscosity",
                                           "friction_angle",
                                           "g",
                                           "rpic_damping",
                                           "pic_damping",
                                           "grid_v_damping_scale",
                                           "substep_dt",
                                           "frame_dt",
                                           "frame_num",
                                           "opacity_threshold",
                                           "rotation_degree",
                                           "rotation_axis",
                                           "sim_area",
                                           "scale",
                                           "particle_filling",
                                           "boundary_conditions",
                                           "mpm_space_viewpoint_center",
                                           "mpm_space_vertical_upward_axis",
                                           "default_camera_index",
                                           "show_hint",
                                           "init_azimuthm",
                                           "init_elevation",
                                           "init_radius",
                                           "move_camera",
                                           "delta_a",
                                           "delta_e",
                                           "delta_r"};

Config::MaterialBox read_material_box(const JsonObject& object, const Config& config) {
  object.refuse_unknown({"point", "size", "E", "nu", "density"});
  Config::MaterialBox box{Vec3d::Ones(), Vec3d::Ones(), config.young, config.poisson, config.density};
  const PhysGaussianKeys keys(object);
  for (const char* key : {"point", "size"})
    if (!object.has(key)) throw object.complaint(key, "is missing", "give the center and the half extents of the box");
  keys.vector("point", box.point);
  keys.half_extent("size", box.half);
  keys.positive("E", box.young);
  keys.number("nu", box.poisson, 0, 0.4999);
  keys.positive("density", box.density);
  return box;
}

Config::Filling read_filling(const JsonObject& object, const json& row, Config& config) {
  object.refuse_unknown({"n_grid", "density_threshold", "search_threshold", "max_particles_num",
                         "max_partciels_per_cell", "max_particles_per_cell", "search_exclude_direction",
                         "ray_cast_direction", "boundary", "smooth", "visualize"});
  Config::Filling filling;
  filling.n_grid = 4 * config.n_grid;
  const PhysGaussianKeys keys(object);
  keys.whole("n_grid", filling.n_grid, 4, 4096);
  keys.positive("density_threshold", filling.density_threshold);
  keys.positive("search_threshold", filling.search_threshold);
  keys.whole("max_particles_num", filling.max_particles_num, 1, 1 << 30);
  keys.whole("max_partciels_per_cell", filling.max_particles_per_cell, 1, 64);
  if (keys.has("max_particles_per_cell")) {
    keys.whole("max_particles_per_cell", filling.max_particles_per_cell, 1, 64);
    config.notes.push_back(
        "max_particles_per_cell: PhysGaussian ignores this spelling (its key is max_partciels_per_cell); it is used "
        "here");
  }
  keys.whole("search_exclude_direction", filling.search_exclude_direction, -1, 6);
  keys.whole("ray_cast_direction", filling.ray_cast_direction, -1, 6);
  keys.six("boundary", filling.boundary, row);
  keys.flag("smooth", filling.smooth, row);
  keys.flag("visualize", filling.visualize, row);
  return filling;
}

void read_view(const PhysGaussianKeys& keys, const json& top, Config::View& view) {
  keys.vector("mpm_space_viewpoint_center", view.centre);
  keys.vector("mpm_space_vertical_upward_axis", view.up);
  if (!(view.up.norm() > 0))
    throw keys.object().complaint("mpm_space_vertical_upward_axis", "has no length", "give a direction");
  keys.whole("default_camera_index", view.default_camera_index, -1, 1 << 30);
  keys.flag("show_hint", view.show_hint, top);
  keys.flag("move_camera", view.move_camera, top);
  const auto optional = [&](const char* key, std::optional<double>& value) {
    if (keys.has(key) && !top[key].is_null()) value = keys.object().number(key);
  };
  optional("init_azimuthm", view.azimuth);
  optional("init_elevation", view.elevation);
  optional("init_radius", view.radius);
  keys.number("delta_a", view.delta_azimuth);
  keys.number("delta_e", view.delta_elevation);
  keys.number("delta_r", view.delta_radius);
}

void read_rotations(const JsonObject& object, const json& top, Config& config) {
  for (const char* key : {"rotation_degree", "rotation_axis"}) {
    if (!top.contains(key)) continue;
    const json& list = object.array(key);
    for (const json& value : list) {
      if (value.is_array() && value.empty()) continue;  // [[]] is PhysGaussian's "none"
      if (!value.is_number()) throw object.complaint(key, "holds " + value.dump(), "give a list of numbers");
      const double number = value.get<double>();
      if (key[9] == 'd') {
        config.rotation_degree.push_back(number);
      } else {
        if (number != 0 && number != 1 && number != 2)
          throw object.complaint(key, "holds " + value.dump(), "axes are 0 = x, 1 = y, 2 = z");
        config.rotation_axis.push_back(static_cast<int>(number));
      }
    }
  }
  if (config.rotation_degree.size() != config.rotation_axis.size())
    throw object.complaint("rotation_axis",
                           "has " + std::to_string(config.rotation_axis.size()) + " entries for " +
                               std::to_string(config.rotation_degree.size()) + " angles",
                           "give one axis for each angle");
}

}  // namespace

Config read_physgaussian_config(const std::filesystem::path& file) {
  const json top = read_json(file);
  const JsonObject object(top, file.string());
  object.refuse_unknown(kTopKeys);
  const PhysGaussianKeys keys(object);
  Config c;
  if (keys.has("material")) c.material = object.text("material");
  if (std::find(kMaterials.begin(), kMaterials.end(), c.material) == kMaterials.end())
    throw object.complaint("material", "'" + c.material + "' is unknown",
                           "did you mean '" + nearest_name(c.material, kMaterials) + "'?");
  keys.positive("grid_lim", c.grid_lim);
  keys.whole("n_grid", c.n_grid, 8, 4096);
  keys.positive("E", c.young);
  keys.number("nu", c.poisson, 0, 0.4999);
  keys.positive("density", c.density);
  keys.number("yield_stress", c.yield_stress, 0);
  keys.number("xi", c.xi, 0);
  keys.number("softening", c.softening, 0);
  keys.number("plastic_viscosity", c.plastic_viscosity, 0);
  keys.number("friction_angle", c.friction_angle, 0, 89);
  keys.flag("hardening", c.hardening, top);
  if (keys.has("g"))
    keys.vector("g", c.gravity);
  else
    c.notes.push_back("g is missing, which makes PhysGaussian stop; no gravity is used");
  keys.number("rpic_damping", c.rpic_damping, -1e9, 1);
  if (keys.has("pic_damping"))
    c.notes.push_back("pic_damping is read and never used by PhysGaussian; it is ignored here as well");
  keys.positive("grid_v_damping_scale", c.grid_v_damping_scale);
  keys.positive("substep_dt", c.substep_dt);
  keys.positive("frame_dt", c.frame_dt);
  keys.whole("frame_num", c.frame_num, 1, 1000000);
  keys.number("opacity_threshold", c.opacity_threshold, 0, 1);
  keys.positive("scale", c.scale);
  read_rotations(object, top, c);
  keys.six("sim_area", c.sim_area, top);
  const auto rows = [&](const char* key, auto&& use) {
    if (!top.contains(key)) return;
    const json& list = object.array(key);
    for (size_t i = 0; i < list.size(); ++i) {
      const JsonObject row(list[i], file.string(), std::string(key) + "[" + std::to_string(i) + "]");
      use(row, list[i]);
    }
  };
  rows("additional_material_params",
       [&](const JsonObject& row, const json&) { c.additional_material.push_back(read_material_box(row, c)); });
  rows("boundary_conditions", [&](const JsonObject& row, const json& value) {
    c.boundaries.push_back(read_physgaussian_boundary(row, value));
  });
  if (top.contains("particle_filling"))
    c.filling = read_filling(object.object("particle_filling"), top["particle_filling"], c);
  read_view(keys, top, c.view);
  for (const char* key :
       {"mpm_space_viewpoint_center", "mpm_space_vertical_upward_axis", "default_camera_index", "show_hint",
        "move_camera", "init_azimuthm", "init_elevation", "init_radius", "delta_a", "delta_e", "delta_r"})
    if (keys.has(key)) c.view_keys.push_back(key);

  if ((c.material == "metal" || c.material == "foam" || c.material == "plasticine") && !(c.yield_stress > 0))
    throw object.complaint("yield_stress", "is " + std::to_string(c.yield_stress),
                           "a '" + c.material + "' without it flows at once; give pascal");
  return c;
}

}  // namespace pliant
