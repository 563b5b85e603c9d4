#include "app/seed/seed_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/run/attach_scene.h"
#include "app/seed/body_pieces.h"
#include "app/seed/particle_budget.h"
#include "app/simulate/given_fields.h"
#include "gaussians/base/error.h"
#include "gaussians/io/splats/ply.h"
#include "physics/body/adaptive_drivers.h"
#include "physics/body/links.h"

namespace pliant {
using nlohmann::json;

namespace {

/// Pins without those that hold only samples that are not simulated: they hold nothing that could move.
json pins_of_part(const std::vector<Region>& pins, const SolidSamples& samples, const SimulatedPart& part) {
  json rows = json::array();
  for (const Region& pin : pins) {
    const auto holds = [&](const Vec3f& x) { return pin.signed_distance(x.cast<double>()) < 0; };
    const bool some =
        std::any_of(part.kept.begin(), part.kept.end(), [&](int i) { return holds(samples.position[i]); });
    if (some || std::none_of(samples.position.begin(), samples.position.end(), holds))
      rows.push_back(region_to_json(pin));
  }
  return rows;
}

/// Driving particles in the solid, and what is simulated of it.
struct Seeded {
  ParticleFile file;
  SimulatedPart part;
  BodyPieces body;
};

/// `count` driving particles, by K-means, or where `young` [S] is not empty by PGAS; more where one would lie in two
/// parts that do not hang together.
Seeded place_drivers(const Context& context, const GaussianCloud& object, const SolidFile& solid,
                     const std::vector<Region>& pins, int count, const std::vector<float>& young) {
  const SolidSamples& samples = solid.samples;
  Seeded out;
  out.part = young.empty() ? select_simulated(samples, pins, count) : select_simulated(samples, pins, count, young);
  out.body = find_body_pieces(samples, pins, out.part);
  const std::vector<int>& kept = out.part.kept;
  DriverOptions options;
  options.count = count;
  options.seed = context.seed;
  const SolidSamples part = samples.select(kept);
  DrivingParticles drivers;
  if (young.empty()) {
    drivers = kmeans_drivers(options, part);
  } else {
    std::vector<float> of_kept;
    for (const int i : kept) of_kept.push_back(young[i]);
    drivers = pgas_drivers(options, part, of_kept);
  }
  const SampleLinks links(object, part, static_cast<float>(drivers.cell_size));
  separate_drivers([&](int i, int k) { return links.linked(i, k); }, part, drivers);
  ParticleFile& file = out.file;
  file.driving_links = link_drivers(links, part, kPieceReach * static_cast<float>(drivers.cell_size), drivers);
  file.solid_position = samples.position;
  file.solid_volume = samples.volume;
  file.solid_driver.assign(samples.size(), -1);
  for (size_t k = 0; k < kept.size(); ++k) file.solid_driver[kept[k]] = drivers.sample_driver[k];
  file.solid_follows = followed_samples(samples, out.part, out.body);
  file.driving_position = std::move(drivers.position);
  file.driving_volume = std::move(drivers.volume);
  file.driving_thickness = std::move(drivers.thickness);
  file.driving_rod = std::move(drivers.rod);
  file.cell_size = drivers.cell_size;
  return out;
}

void tell(const Context& context, const Seeded& seeded, const SeedStage& stage, const Scene& scene, double volume,
          size_t thin) {
  const ParticleFile& file = seeded.file;
  const double cube = std::pow(scene.metres_per_unit, 3);
  context.progress.say(
      fmt::format("seed: {} driving particles ({}), cell size {:.4g} units, {:.4g} of {:.4g} liters simulated",
                  file.driving_position.size(), stage.drivers, file.cell_size, 1000 * seeded.part.volume * cube,
                  1000 * volume * cube));
  if (thin > 0)
    context.progress.warn(
        fmt::format("{} of {} driving particles are in parts thinner than {} cells; they are simulated with their mass "
                    "and an equivalent stiffness (more --particles give smaller cells)",
                    thin, file.driving_position.size(), kThinCells));
}

json seed_object(const Context& context, const RunDirectory& run, const StageInputs<SeedStage>& in,
                 const std::string& provenance) {
  const SeedStage& stage = in.options;
  const Scene& scene = in.scene;
  const GaussianCloud object = read_ply(in.files.at("object"));
  const SolidFile solid = read_solid(in.files.at("solid"));
  const std::vector<Region> pins = pinned_regions(solid, scene);
  int count = in.found["particles"];
  std::vector<float> young;
  if (stage.drivers == "pgas") {
    const bool known = in.files.count("material");
    if (!known)
      context.progress.say(
          "seed: E is assumed to be uniform, so pgas places particles evenly (--material F.h5 gives E(x))");
    young = known ? given_material(in.files.at("material"), solid.samples.position, &context.progress).young
                  : std::vector<float>(solid.samples.size(), 1.0f);
  }
  if (in.found.contains("cost")) {
    const int affordable = affordable_count(cost_from_json(in.found["cost"]), count);
    if (affordable < count)
      context.progress.say(
          fmt::format("seed: {} driving particles instead of {}, because this material is stiff and needs short time "
                      "steps (override with --particles)",
                      affordable, count));
    count = affordable;
  }
  Seeded seeded = place_drivers(context, object, solid, pins, count, young);
  tell_loose(context, seeded.body);
  write_pieces(run, object, scene.up, solid.samples, seeded.body);
  ParticleFile& file = seeded.file;
  file.metres_per_unit = scene.metres_per_unit;
  const json held = pins_of_part(pins, solid.samples, seeded.part);
  file.pinned_json = held.dump();
  write_particles(run / in.outputs[0], file, provenance);

  const std::vector<float>& thickness = file.driving_thickness;
  const size_t thin = static_cast<size_t>(std::count_if(
      thickness.begin(), thickness.end(), [&](float t) { return t > 0 && t < kThinCells * file.cell_size; }));
  tell(context, seeded, stage, scene, solid.volume, thin);
  return {{"samples", solid.samples.size()},
          {"drivers", file.driving_position.size()},
          {"placed_by", stage.drivers},
          {"cell_size", file.cell_size},
          {"outset", in.found["outset"]},
          {"volume", solid.volume},
          {"simulated_volume", seeded.part.volume},
          {"thin_samples", in.found["thin_samples"]},
          {"thin_drivers", thin},
          {"links", file.driving_links.size()},
          {"pieces", pieces_json(seeded.body)},
          {"pinned", held}};
}

}  // namespace

StageInputs<SeedStage> inputs_of(const RunDirectory& run, const Scene& scene, const SeedStage& stage) {
  if (!stage.material_file.empty() && stage.drivers != "pgas")
    throw usage_error("seed", "--material", "does nothing with --sampling " + stage.drivers,
                      "give --sampling pgas, or leave it out");
  StageInputs<SeedStage> in;
  in.options = stage;
  in.parts = {ScenePart::kUp, ScenePart::kMetresPerUnit};
  in.scene = only(in.parts, scene);
  const std::string folder = object_folder(run);
  in.files["object"] = run / (folder + "/object.ply");
  in.files["solid"] = run / (folder + "/solid.h5");
  const json& filled = run.summary("fill", "run `pliant seed` first");
  in.found = {
      {"particles", filled["particles"]}, {"outset", filled["outset"]}, {"thin_samples", filled["thin_samples"]}};
  // A prediction for other samples, which `predict` has yet to replace, says nothing.
  const bool predicted = run.has("predict") && reads_present(run, "predict", "solid");
  if (!stage.material_file.empty())
    in.files["material"] = stage.material_file;
  else if (predicted && stage.drivers == "pgas")
    in.files["material"] = run / (folder + "/predicted.h5");
  // How many particles are used where nobody says.
  if (predicted && !stage.fill.particles && stage.fill.physgaussian.empty())
    in.found["cost"] = run.summary("predict", "")["cost"];
  in.outputs = {folder + "/particles.h5", "pieces.png"};
  return in;
}

json run_drivers(const Context& context, RunDirectory& run, const Scene& scene, const SeedStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), seed_object);
}

json run_seed(const Context& context, RunDirectory& run, const Scene& scene, const SeedStage& stage) {
  run_fill(context, run, scene, stage.fill);
  return run_drivers(context, run, scene, stage);
}

OptionTable options_of(SeedStage& stage) {
  OptionTable table = options_of(stage.fill);
  table.stage = "seed";
  table.options.insert(table.options.begin() + 1,
                       {{.name = "sampling",
                         .field = &stage.drivers,
                         .help = "Particle placement: kmeans, or pgas (Poisson disks, denser where E is small)",
                         .choices = {"kmeans", "pgas"},
                         .formerly = "drivers"},
                        {.name = "material",
                         .field = &stage.material_file,
                         .help = "E(x) for pgas, a material.h5 of any particles (default: predicted, else uniform)",
                         .value = "FILE",
                         .exists = true,
                         .recorded = Recorded::kContents}});
  return table;
}

}  // namespace pliant
