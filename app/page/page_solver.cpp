#include "app/page/page_solver.h"

#include <algorithm>
#include <cmath>

#include "app/page/page_assets.h"

namespace pliant {
namespace {

constexpr std::array<int, 3> kPageLevels = {2500, 800, 350};  // of kLevelCounts, beside that of the motion

/// Numbers of an interaction, as app/page/solver/solver.cpp reads them.
std::vector<double> numbers_of(const Interaction& it) {
  std::vector<double> out = {static_cast<double>(it.type), std::isfinite(it.duration) ? it.duration : 0,
                             static_cast<double>(it.region.kind)};
  const auto add = [&](const Vec3d& v) { out.insert(out.end(), v.data(), v.data() + 3); };
  add(it.region.point);
  add(it.region.vector);
  out.push_back(it.region.radius);
  add(it.vector);
  for (const double x : {it.friction, it.rate, it.drag_coefficient, it.air_density, it.stiffness, it.damping,
                         it.max_force, static_cast<double>(it.contact)})
    out.push_back(x);
  return out;
}

void add_body(ClipFile& file, size_t l, const Particles& particles) {
  const auto add = [&](const char* name, const std::vector<float>& values) {
    file.add("levels", "level" + std::to_string(l) + "." + name, {values.size()}, std::span<const float>(values));
  };
  add("volume", particles.volume);
  add("mass", particles.mass);
  add("young", particles.young);
  add("poisson", particles.poisson);
  file.header["levels"][l] = {{"drivers", particles.size()}, {"cell_size", particles.cell_size}};
}

}  // namespace

void add_solver(ClipFile& file, const CodedClip& clip, const SessionSetup& setup, const Scene& scene,
                const MovingScene& moving) {
  file.header["solver"] = nullptr;
  file.header["plays_only"] = setup.refused.empty() ? "" : setup.refused;
  if (!setup.refused.empty()) return;
  if (solver_module().empty()) {
    file.header["plays_only"] = "this build of Pliant has no solver for pages";
    return;
  }
  const auto body_of = [&](const ParticleFile& level) {
    return make_body(level, scene, setup.solid, setup.material).particles;
  };
  add_body(file, 0, body_of(clip.level));
  size_t l = 0, last = clip.level.driving_position.size();
  for (const int count : kPageLevels) {
    if (count > 0.7 * static_cast<double>(last)) continue;
    const ParticleFile level = with_drivers(moving.particles, scene, count);
    last = level.driving_position.size();
    add_level(file, "levels", ++l, level.driving_position, bind_object(scene, level, moving.object));
    add_body(file, l, body_of(level));
  }
  nlohmann::json held = nlohmann::json::array();
  for (const Interaction& it : setup.held) held.push_back(numbers_of(it));
  const Vec3d& g = setup.options.gravity;
  file.header["solver"] = {{"fps", setup.options.fps},
                           {"gravity", {g.x(), g.y(), g.z()}},
                           {"damping_time", setup.options.damping_time},
                           {"contact_friction", setup.options.object_friction},
                           {"law", static_cast<int>(setup.material.law)},
                           {"height", setup.height},
                           {"held", held}};
  file.sections["solver"] = solver_module();
}

size_t solver_bytes(const SessionSetup& setup, const MovingScene& moving) {
  if (!setup.refused.empty() || solver_module().empty()) return 0;
  constexpr double kBase64 = 4.0 / 3, kPacked = 0.8;
  const double bindings = kPageLevels.size() * 3.0 * Binding::kCount * static_cast<double>(moving.object.size());
  const double bodies = 28.0 * (static_cast<double>(moving.particles.driving_position.size()) + 4000);
  return static_cast<size_t>(kBase64 *
                             (0.4 * static_cast<double>(solver_module().size()) + kPacked * bindings + bodies));
}

}  // namespace pliant
