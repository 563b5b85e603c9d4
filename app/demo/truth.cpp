#include "app/demo/truth.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/demo/raycast.h"
#include "app/import/interactions.h"
#include "app/store/material.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
std::string provenance(uint64_t seed) {
  return Json{{"maker", "pliant demo"}, {"version", PLIANT_VERSION}, {"seed", seed}}.dump();
}

Json solid_json(const ElasticSolid& solid) {
  return {{"young", solid.young}, {"poisson", solid.poisson}, {"density", solid.density}};
}

Json vector_json(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

Json interaction_json(const Interaction& interaction) {
  Json json = {{"type", interaction_name(interaction.type)}};
  const bool always = std::isinf(interaction.duration);
  if (interaction.type != InteractionType::kPin) json["start"] = interaction.start;
  if (!always) json["duration"] = interaction.duration;
  json["region"] = region_to_json(interaction.region);
  switch (interaction.type) {
    case InteractionType::kPin:
      break;
    case InteractionType::kPointForce:
      json["force"] = vector_json(interaction.vector);
      break;
    case InteractionType::kImpulse:
      json["impulse"] = vector_json(interaction.vector);
      break;
    case InteractionType::kGust:
      json["wind"] = vector_json(interaction.vector);
      json["drag"] = interaction.rate;
      break;
    case InteractionType::kGrab:
      for (const Interaction::PathPoint& p : interaction.path)
        json["path"].push_back({p.time, p.position.x(), p.position.y(), p.position.z()});
      break;
    default:
      CHECK_MSG(false, "no reference script does that");
  }
  return json;
}

}  // namespace

Json interactions_json(const std::vector<Interaction>& interactions) {
  Json json = Json::array();
  for (const Interaction& interaction : interactions) json.push_back(interaction_json(interaction));
  return json;
}

TrajectoryFile trajectory_of(const ReferenceMotion& motion, const std::string& name, size_t every) {
  TrajectoryFile trajectory;
  trajectory.object = name;
  trajectory.fps = motion.fps;
  trajectory.cell_size = motion.cell_size;
  trajectory.up = Vec3d::UnitZ();  // of every stage
  for (const SimulationState& state : motion.frames) {
    TrajectoryFile::Frame frame;
    frame.time = state.time;
    frame.step = state.substeps;
    for (size_t i = 0; i < state.size(); i += every) {
      frame.position.push_back(state.x[i]);
      frame.velocity.push_back(state.v[i]);
      frame.F.push_back(state.F[i]);
    }
    trajectory.frames.push_back(std::move(frame));
  }
  return trajectory;
}

void write_label_truth(const fs::path& folder, const char* parts_name, const Stage& stage, const StageSplats& splats,
                       uint64_t seed) {
  fs::create_directories(folder);
  write_labels(folder / "labels.h5", {splats.label, stage.names()}, provenance(seed));
  std::vector<uint32_t> parts;
  for (const int material : splats.material) parts.push_back(static_cast<uint32_t>(material + 1));
  std::map<uint32_t, std::string> names;
  for (const DemoMaterial& material : stage.object().materials)
    names[static_cast<uint32_t>(names.size() + 1)] = material.name;
  write_labels(folder / parts_name, {parts, names}, provenance(seed));
}

void write_flower_truth(const fs::path& folder, const Flower& flower, uint64_t seed) {
  const FlowerMechanics m = flower_mechanics(flower);
  Json json;
  json["seed"] = seed;
  json["solids"] = {{"stem", solid_json(flower.solid(kStem))},
                    {"leaf", solid_json(flower.solid(kLeaf))},
                    {"blossom", solid_json(flower.solid(kBlossom))}};
  json["stem"] = {{"tip_diameter", flower.tip_diameter},
                  {"base_diameter", flower.base_diameter},
                  {"free_length", flower.free_length}};
  json["height"] = flower.object.height;
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

void write_object_truth(const fs::path& folder, const std::string& kind, const DemoObject& object,
                        const ReferenceBody& body, uint64_t seed) {
  Json json = {{"kind", kind}, {"seed", seed}, {"height", object.height}, {"particles", body.particles.size()}};
  for (const DemoMaterial& m : object.materials) {
    Json part = {{"name", m.name}, {"fixed", m.fixed}};
    if (!m.fixed) {
      double volume = 0;
      for (size_t i = 0; i < body.samples.size(); ++i)
        if (body.piece[i] == static_cast<int>(&m - object.materials.data())) volume += body.samples.volume[i];
      part["volume"] = volume;
      part["mass"] = volume * m.solid.density;
      part.update(solid_json(m.solid));
      part["low"] = solid_json(m.low);
      part["high"] = solid_json(m.high);
      part["reason"] = m.reason;
    }
    json["parts"].push_back(part);
  }
  write_text(folder / "object.json", json.dump(2) + "\n");
}

void write_material_truth(const fs::path& folder, const ReferenceBody& body, uint64_t seed) {
  const ElasticSamples& elastic = body.material;
  write_material(folder / "material.h5",
                 {elastic.young, elastic.poisson, elastic.density, "truth of the demo scene", body.samples.position,
                  body.samples.volume},
                 provenance(seed));
}

void write_motion_truth(const fs::path& folder, const ReferenceMotion& motion, const TrajectoryFile& trajectory,
                        const ReferenceFilm& film, const Camera& camera, uint64_t seed) {
  fs::create_directories(folder);
  write_text(folder / "interactions.json", interactions_json(motion.interactions).dump(2) + "\n");
  write_trajectory(folder / "trajectory.h5", trajectory, provenance(seed));

  Json json;
  json["camera"] = camera.name;
  json["fps"] = motion.fps;
  json["particles"] = motion.particles;
  json["cell_size"] = motion.cell_size;
  json["damping_time"] = motion.damping_time;
  json["time_step"] = motion.time_step;
  json["peak_pixels"] = film.peak_pixels();
  json["peak_metres"] = film.peak_metres();
  if (motion.max_stretch > 0) json["max_stretch"] = motion.max_stretch;
  for (size_t f = 0; f < film.tip.size(); ++f) {
    json["pixel"].push_back({film.pixel[f].x(), film.pixel[f].y()});
    json["tip"].push_back({film.tip[f].x(), film.tip[f].y(), film.tip[f].z()});
  }
  write_text(folder / "video_motion.json", json.dump(2) + "\n");
}

void write_hidden_truth(const fs::path& folder, const Stage& stage, const std::vector<Camera>& cameras) {
  fs::create_directories(folder / "without_object");
  fs::create_directories(folder / "hidden");
  const Stage bare = stage.without(kObjectId);
  for (const Camera& camera : cameras) {
    write_image(folder / "without_object" / (camera.name + ".png"), take_photo(bare, camera).color);
    // The cameras beside this one see most of what the object hides here, so they are asked first.
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
            if (front.part < 0 || stage.parts()[front.part].id != kObjectId) continue;
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
