#include "app/page/page_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/page/interaction_numbers.h"
#include "app/page/material_numbers.h"
#include "app/page/page_assets.h"

namespace pliant {
namespace {

constexpr std::array<int, 3> kPageLevels = {2500, 800, 350};  // beside that of the motion
constexpr double kCoarser = 0.7;                              // of that of the motion, at most

/// What the driving particles remember [N, 19]: both elastic parts by rows, the history.
std::vector<float> memory_numbers(const TrajectoryFile::Memory& memory) {
  std::vector<float> out;
  for (size_t i = 0; i < memory.history.size(); ++i) {
    for (const Mat3f* F : {&memory.F[i], &memory.F_viscous[i]})
      for (int k = 0; k < 9; ++k) out.push_back((*F)(k / 3, k % 3));
    out.push_back(memory.history[i]);
  }
  return out;
}

void add_body(ClipFile& file, size_t l, const Particles& particles,
              const std::optional<TrajectoryFile::Memory>& memory) {
  const std::string level = "level" + std::to_string(l) + ".";
  const auto add = [&](const char* name, const std::vector<float>& values) {
    file.add("levels", level + name, {values.size()}, std::span<const float>(values));
  };
  add("volume", particles.volume);
  add("mass", particles.mass);
  add("young", particles.young);
  add("poisson", particles.poisson);
  std::vector<double> materials;
  for (const Material& material : particles.materials) {
    const std::vector<double> row = numbers_of(material);
    materials.insert(materials.end(), row.begin(), row.end());
  }
  file.add("levels", level + "materials", {particles.materials.size(), kMaterialNumbers},
           std::span<const double>(materials));
  std::vector<uint16_t> index = particles.material_index;
  index.resize(particles.size());
  file.add("levels", level + "material", {particles.size()}, std::span<const uint16_t>(index));
  if (memory) add("memory", memory_numbers(*memory));
  // Of each pair, by how much the first exceeds that of the pair before, and the second the first.
  std::vector<uint16_t> links;
  for (int before = 0; const auto& [a, b] : particles.links) {
    links.push_back(static_cast<uint16_t>(a - before));
    links.push_back(static_cast<uint16_t>(b - a));
    before = a;
  }
  file.add("levels", level + "links", {particles.links.size(), 2}, std::span<const uint16_t>(links));
  file.header["levels"][l].update({{"drivers", particles.size()},
                                   {"cell_size", particles.cell_size},
                                   {"links", particles.links.size()},
                                   {"materials", particles.materials.size()}});
}

/// Whether every weight hangs on some particle.
bool carries_weights(const SessionSetup& setup, const std::vector<Vec3f>& rest, double metres_per_unit) {
  return std::all_of(setup.held.begin(), setup.held.end(), [&](const Interaction& it) {
    return it.type != InteractionType::kWeight || std::any_of(rest.begin(), rest.end(), [&](const Vec3f& x) {
             return it.region.contains(metres_per_unit * x.cast<double>());
           });
  });
}

bool can_play(const SessionSetup& setup) { return setup.refused.empty() && !solver_module().empty(); }

}  // namespace

std::vector<SolverLevel> solver_levels(const SessionSetup& setup, const Scene& scene, const MovingScene& moving) {
  std::vector<SolverLevel> levels;
  if (!can_play(setup)) return levels;
  for (const int count : kPageLevels) {
    if (count > kCoarser * static_cast<double>(moving.particles.driving_position.size())) continue;
    SolverLevel level{count, with_drivers(moving.particles, scene, count), {}, {}};
    if (!carries_weights(setup, level.file.driving_position, scene.metres_per_unit)) continue;
    level.binding = bind_object(scene, level.file, moving.object);
    level.memory = memory_of(moving, level.file);
    levels.push_back(std::move(level));
  }
  return levels;
}

std::span<const SolverLevel> levels_beside(const ParticleFile& motion_level, std::span<const SolverLevel> levels,
                                           size_t most) {
  const double largest = kCoarser * static_cast<double>(motion_level.driving_position.size());
  while (!levels.empty() &&
         (levels.size() > most || static_cast<double>(levels[0].file.driving_position.size()) > largest))
    levels = levels.subspan(1);
  return levels;
}

size_t solver_bytes(const SolverLevel& motion_level, const SessionSetup& setup, const Scene& scene,
                    std::span<const SolverLevel> levels, SectionPacker& packer) {
  if (!can_play(setup)) return 0;
  ClipFile file;
  add_solver(file, motion_level, setup, scene, levels);
  return packer.pack(file);
}

void add_solver(ClipFile& file, const SolverLevel& motion_level, const SessionSetup& setup, const Scene& scene,
                std::span<const SolverLevel> levels) {
  file.header["solver"] = nullptr;
  file.header["plays_only"] = setup.refused;
  if (!setup.refused.empty()) return;
  if (!can_play(setup)) {
    file.header["plays_only"] = "this build of Pliant has no solver for pages";
    return;
  }
  if (!carries_weights(setup, motion_level.file.driving_position, scene.metres_per_unit)) {
    file.header["plays_only"] = "no driving particle of the reduced body carries one of the weights";
    return;
  }
  const auto body_of = [&](const ParticleFile& level) {
    return make_body(level, scene, setup.solid, setup.material).particles;
  };
  add_body(file, 0, body_of(motion_level.file), motion_level.memory);
  size_t l = 0;
  for (const SolverLevel& level : levels) {
    add_level(file, "levels", ++l, level.file.driving_position, level.binding);
    add_binding(file, "levels", "level" + std::to_string(l) + ".from.", bind_level(motion_level.file, level.file));
    add_body(file, l, body_of(level.file), level.memory);
    file.header["levels"][l]["clustered_to"] = level.clustered_to;
  }
  nlohmann::json held = nlohmann::json::array();
  for (const Interaction& it : setup.held) held.push_back(numbers_of(it));
  const Vec3d& g = setup.options.gravity;
  file.header["solver"] = {{"fps", setup.options.fps},
                           {"gravity", {g.x(), g.y(), g.z()}},
                           {"damping_time", setup.options.damping_time},
                           {"contact_friction", setup.options.object_friction},
                           {"grid", static_cast<int>(setup.options.grid)},
                           {"flip_time", setup.options.flip_time},
                           {"sleep_speed", setup.options.sleep_speed},
                           {"remembers", setup.remembers},
                           {"height", setup.height},
                           {"held", held},
                           {"script", setup.script}};
  file.sections["solver"] = solver_module();
}

}  // namespace pliant
