#include "app/demo/truth.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/demo/raycast.h"
#include "app/store/material.h"
#include "app/store/segmentation.h"
#include "app/store/trajectory.h"
#include "gaussians/base/portable.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
constexpr size_t kStoredParticles = 2500;

std::string provenance(uint64_t seed) {
  return Json{{"maker", "pliant demo"}, {"version", PLIANT_VERSION}, {"seed", seed}}.dump();
}

Json solid_json(const ElasticSolid& solid) {
  return {{"young", solid.young}, {"poisson", solid.poisson}, {"density", solid.density}};
}

Json interaction_json(const Interaction& interaction) {
  const Region& r = interaction.region;
  Json json = {{"type", interaction_name(interaction.type)}};
  if (interaction.type == InteractionType::kPin) {
    json["region"]["box"] = {r.point.x(), r.point.y(), r.point.z(), r.vector.x(), r.vector.y(), r.vector.z()};
  } else {
    json["start"] = interaction.start;
    json["duration"] = interaction.duration;
    json["region"]["sphere"] = {r.point.x(), r.point.y(), r.point.z(), r.radius};
    json["force"] = {interaction.vector.x(), interaction.vector.y(), interaction.vector.z()};
  }
  return json;
}

TrajectoryFile thinned(const ReferenceMotion& motion) {
  const size_t step = std::max<size_t>(1, motion.samples.size() / kStoredParticles);
  TrajectoryFile trajectory;
  trajectory.object = "flower";
  trajectory.fps = motion.options.fps;
  trajectory.cell_size = motion.cell_size;
  for (const SimulationState& state : motion.frames) {
    TrajectoryFile::Frame frame;
    frame.time = state.time;
    frame.step = state.substeps;
    for (size_t i = 0; i < state.size(); i += step) {
      frame.position.push_back(state.x[i]);
      frame.velocity.push_back(state.v[i]);
      frame.F.push_back(state.F[i]);
    }
    trajectory.frames.push_back(std::move(frame));
  }
  return trajectory;
}

}  // namespace

void write_truth(const fs::path& folder, const Stage& stage, const StageSplats& splats, uint64_t seed) {
  fs::create_directories(folder);
  write_labels(folder / "labels.h5", {splats.label, stage_names()}, provenance(seed));
  std::vector<uint32_t> parts;
  for (const FlowerPart part : splats.flower_part) parts.push_back(static_cast<uint32_t>(part));
  write_labels(folder / "flower_parts.h5", {parts, {{1, "pot"}, {2, "stem"}, {3, "leaf"}, {4, "blossom"}}},
               provenance(seed));

  const Flower& flower = stage.flower();
  const FlowerMechanics m = flower_mechanics(flower);
  Json json;
  json["seed"] = seed;
  json["solids"] = {
      {"stem", solid_json(flower.stem)}, {"leaf", solid_json(flower.leaf)}, {"blossom", solid_json(flower.blossom)}};
  json["stem"] = {{"tip_diameter", flower.tip_diameter},
                  {"base_diameter", flower.base_diameter},
                  {"free_length", flower.free_length}};
  json["height"] = flower.height;
  json["pin_height"] = flower.pin_height;
  json["mechanics"] = {{"volume", m.volume},
                       {"cell_8k", m.cell_8k},
                       {"stem_cells_8k", m.stem_cells},
                       {"leaf_cells_8k", m.leaf_cells},
                       {"frequency", m.frequency},
                       {"substeps_4k", m.substeps_4k},
                       {"contrast", m.contrast},
                       {"compliance", m.compliance}};
  write_text(folder / "flower.json", json.dump(2) + "\n");
}

void write_truth(const fs::path& folder, const ReferenceMotion& motion, const ReferenceFilm& film, const Camera& camera,
                 uint64_t seed) {
  fs::create_directories(folder);
  const ElasticSamples& elastic = motion.material;
  write_material(folder / "material.h5",
                 {elastic.young, elastic.poisson, elastic.density, "truth of the demo scene", motion.samples.position,
                  motion.samples.volume},
                 provenance(seed));
  Json interactions = Json::array();
  for (const Interaction& interaction : motion.interactions) interactions.push_back(interaction_json(interaction));
  write_text(folder / "interactions.json", interactions.dump(2) + "\n");
  write_trajectory(folder / "trajectory.h5", thinned(motion), provenance(seed));

  Json json;
  json["camera"] = camera.name;
  json["fps"] = motion.options.fps;
  json["particles"] = motion.samples.size();
  json["cell_size"] = motion.cell_size;
  json["damping_time"] = motion.options.damping_time;
  json["time_step"] = motion.summary.min_dt;
  json["peak_pixels"] = film.peak_pixels();
  json["peak_metres"] = film.peak_metres();
  for (size_t f = 0; f < film.tip.size(); ++f) {
    json["pixel"].push_back({film.pixel[f].x(), film.pixel[f].y()});
    json["tip"].push_back({film.tip[f].x(), film.tip[f].y(), film.tip[f].z()});
  }
  write_text(folder / "video_motion.json", json.dump(2) + "\n");
}

void write_hidden_truth(const fs::path& folder, const Stage& stage, const std::vector<Camera>& cameras) {
  fs::create_directories(folder / "without_object");
  fs::create_directories(folder / "hidden");
  const Stage bare = stage.without(kFlowerId);
  for (const Camera& camera : cameras) {
    write_image(folder / "without_object" / (camera.name + ".png"), take_photo(bare, camera).color);
    // The cameras beside this one see most of what the flower hides here, so they are asked first.
    std::vector<const Camera*> others;
    for (const Camera& other : cameras) others.push_back(&other);
    std::stable_sort(others.begin(), others.end(), [&](const Camera* a, const Camera* b) {
      return (a->centre() - camera.centre()).squaredNorm() < (b->centre() - camera.centre()).squaredNorm();
    });
    IdImage hidden(camera.width, camera.height, 1);
    const Vec3d eye = camera.centre();
    parallel_for(
        camera.height,
        [&](std::ptrdiff_t row) {
          const int y = static_cast<int>(row);
          for (int x = 0; x < camera.width; ++x) {
            const Ray ray{eye, camera.ray(x + 0.5, y + 0.5)};
            const StageHit front = stage.cast(ray);
            if (front.part < 0 || stage.parts()[front.part].id != kFlowerId) continue;
            hidden(x, y) = kSeenElsewhere;
            const StageHit behind = bare.cast(ray);
            if (behind.part < 0) continue;
            const Vec3d point = ray.origin + behind.t * ray.direction;
            const Vec3d normal = bare.parts()[behind.part].world_from_local.linear() * behind.normal;
            if (std::none_of(others.begin(), others.end(),
                             [&](const Camera* c) { return sees(stage, *c, point, normal); }))
              hidden(x, y) = kNeverSeen;
          }
        },
        4);
    write_ids(folder / "hidden" / (camera.name + ".png"), hidden);
  }
}

}  // namespace pliant
