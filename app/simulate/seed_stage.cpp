#include "app/simulate/seed_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/import/physgaussian_space.h"
#include "app/run/attach_scene.h"
#include "app/simulate/body_pieces.h"
#include "app/simulate/given_fields.h"
#include "app/store/particles.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "physics/body/adaptive_drivers.h"
#include "physics/body/interior_fill.h"
#include "physics/body/pieces.h"
#include "physics/body/silhouette_outset.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr int kSamplesPerDriver = 8;
constexpr double kHeldShare = 0.1;  // of the height, from below, of an object that nothing holds or carries

/// What holds the object, in scene units: the scene file's regions, --pin-below, and the contact with the support.
std::vector<Region> pinned_regions(const Context& context, const Scene& scene, const SeedStage& stage,
                                   const GaussianCloud& object, const json& extract) {
  std::vector<Region> pins;
  for (const SceneFile::Region& region : scene.settings.pinned) {
    const Vec3d low = region.low.cast<double>();
    pins.push_back(region.sphere ? Region::sphere(low, region.high.x()) : Region::box(low, region.high.cast<double>()));
  }
  if (stage.pin_below) pins.push_back(Region::half_space(scene.up * *stage.pin_below, scene.up));
  if (stage.pin_contact && !stage.pin_below && extract.contains("contact")) {
    const json& contact = extract["contact"];
    const Vec3d point(contact["point"][0], contact["point"][1], contact["point"][2]);
    const Vec3d normal(contact["normal"][0], contact["normal"][1], contact["normal"][2]);
    pins.push_back(Region::half_space(point + normal * contact["band"].get<double>(), normal));
    context.progress.say(fmt::format("seed: fixed where it touches '{}'", contact["support"].get<std::string>()));
  }
  if (pins.empty() && stage.pin_contact) {
    const Framing framing = robust_framing(object, scene.up);
    const double height = framing.high.z() - framing.low.z();
    pins.push_back(Region::half_space(scene.up * (framing.low.z() + kHeldShare * height), scene.up));
    context.progress.say(
        "seed: nothing carries the object, so that its lowest tenth is fixed (--pin-below fixes another part, "
        "--no-pin-contact none)");
  }
  return pins;
}

/// Dense samples of the solid, refined until the simulated part has enough of them for every driver.
SolidSamples sample_solid(const Context& context, const FillOptions& first, const GaussianCloud& object,
                          const std::vector<Region>& pins, int drivers, FillSummary& summary, SimulatedPart& part) {
  FillOptions options = first;
  SolidSamples samples = fill_interior(options, object, &summary);
  part = select_simulated(samples, pins, drivers);
  const double wanted = static_cast<double>(kSamplesPerDriver) * drivers;
  if (part.kept.size() < 0.8 * wanted) {
    const double grow = std::min(wanted / part.kept.size(), 4e6 / options.target_count);
    options.target_count = static_cast<int>(options.target_count * grow);
    samples = fill_interior(options, object, &summary);
    part = select_simulated(samples, pins, drivers);
  }
  const float cell = part.cell_size;
  const BridgeSummary bridged = bridge_gaps({0.5f * cell, 3 * cell, cell}, object, samples);
  if (bridged.bridges > 0) {
    context.progress.say(
        fmt::format("seed: {} gaps in the surface bridged with {} samples", bridged.bridges, bridged.samples));
    part = select_simulated(samples, pins, drivers);
  }
  return samples;
}

/// Driving particles, eight to a cell, that fill the object with the cells of a configuration of PhysGaussian.
int particles_of_configuration(const Context& context, const std::string& file, const FillOptions& fill,
                               const GaussianCloud& object) {
  constexpr int kMost = 2000000;
  const PhysGaussianConfig config = read_physgaussian_config(file);
  const double cell = config.cell_size() / simulation_space(config, object, physgaussian_members(config, object)).scale;
  FillSummary filled;
  fill_interior(fill, object, &filled);
  const double wanted = 8 * filled.volume / (cell * cell * cell);
  if (wanted > kMost)
    context.progress.warn(fmt::format("the configuration's cells need {:.3g} particles; {} are used", wanted, kMost));
  return static_cast<int>(std::clamp<double>(wanted, 200, kMost));
}

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

json seed_object(const Context& context, const RunDirectory& run, const StageInputs<SeedStage>& in,
                 const std::string& provenance) {
  const SeedStage& stage = in.options;
  const Scene& scene = in.scene;
  const bool configured = !stage.physgaussian.empty(), adaptive = stage.drivers == "pgas",
             given = !stage.material_file.empty();
  const GaussianCloud object = read_ply(in.files.at("object"));
  const std::vector<Region> pins =
      configured ? std::vector<Region>{} : pinned_regions(context, scene, stage, object, in.found);
  FillOptions fill;
  fill.seed = context.seed;
  if (!scene.cameras_are_orbit) {
    RenderOptions render;
    render.antialiased = scene.report.antialiased;
    fill.outset = silhouette_outset(object, scene.cameras, render);
  }
  const int particles =
      configured ? particles_of_configuration(context, stage.physgaussian, fill, object) : stage.particles;
  fill.target_count = kSamplesPerDriver * particles;
  FillSummary filled;
  SimulatedPart part;
  const SolidSamples samples = sample_solid(context, fill, object, pins, particles, filled, part);

  ParticleFile file;
  file.solid_position = samples.position;
  file.solid_volume = samples.volume;
  DriverOptions options;
  options.count = particles;
  options.seed = context.seed;
  DrivingParticles drivers;
  ElasticSamples material;
  if (adaptive) {
    material = given ? given_material(stage.material_file, file) : ElasticSamples::homogeneous(samples.size(), 1, 0, 1);
    part = select_simulated(samples, pins, particles, material.young);
  }
  const BodyPieces body = find_body_pieces(samples, pins, part);
  tell_loose(context, body);
  write_pieces(run, object, scene.up, samples, body);
  if (adaptive) {
    if (!given)
      context.progress.say(
          "seed: E is assumed to be uniform, so pgas places particles evenly (--material F.h5 gives E(x))");
    drivers = pgas_drivers(options, samples.select(part.kept), material.select(part.kept).young);
  } else {
    drivers = kmeans_drivers(options, samples.select(part.kept));
  }
  file.solid_driver.assign(samples.size(), -1);
  for (size_t k = 0; k < part.kept.size(); ++k) file.solid_driver[part.kept[k]] = drivers.sample_driver[k];
  file.driving_position = drivers.position;
  file.driving_volume = drivers.volume;
  file.driving_thickness = drivers.thickness;
  file.driving_rod = drivers.rod;
  file.cell_size = drivers.cell_size;
  file.metres_per_unit = scene.metres_per_unit;
  const json held = pins_of_part(pins, samples, part);
  file.pinned_json = held.dump();
  write_particles(run / in.outputs[0], file, provenance);

  const double cube = scene.metres_per_unit * scene.metres_per_unit * scene.metres_per_unit;
  context.progress.say(fmt::format(
      "seed: {} driving particles by {}, cells of {:.4g} units, {:.4g} liters simulated of {:.4g}", drivers.size(),
      stage.drivers, drivers.cell_size, 1000 * part.volume * cube, 1000 * filled.volume * cube));
  const size_t thin =
      static_cast<size_t>(std::count_if(drivers.thickness.begin(), drivers.thickness.end(),
                                        [&](float t) { return t > 0 && t < kThinCells * drivers.cell_size; }));
  if (thin > 0)
    context.progress.warn(
        fmt::format("{} of {} driving particles are in parts thinner than {} cells; they are simulated with their mass "
                    "and an equivalent stiffness (more --particles give smaller cells)",
                    thin, drivers.size(), kThinCells));
  if (pins.empty() && !configured)
    context.progress.warn("the object is not pinned and will fall (give --pin-below, or pinned regions in scene.json)");
  return {{"samples", samples.size()},
          {"drivers", drivers.size()},
          {"placed_by", stage.drivers},
          {"cell_size", drivers.cell_size},
          {"outset", fill.outset},
          {"volume", filled.volume},
          {"simulated_volume", part.volume},
          {"thin_samples", filled.thin_samples},
          {"thin_drivers", thin},
          {"pieces", pieces_json(body)},
          {"pinned", held}};
}

}  // namespace

StageInputs<SeedStage> inputs_of(const RunDirectory& run, const Scene& scene, const SeedStage& stage) {
  if (!stage.material_file.empty() && stage.drivers != "pgas")
    throw usage_error("seed", "--material", "does nothing with --sampling " + stage.drivers,
                      "give --sampling pgas, or leave it out");
  StageInputs<SeedStage> in;
  in.options = stage;
  // Pictures of the cameras tell how large the solid is.
  in.parts = {ScenePart::kAntialiased, ScenePart::kCameras, ScenePart::kUp, ScenePart::kMetresPerUnit,
              ScenePart::kPinned};
  in.scene = only(in.parts, scene);
  const std::string folder = object_folder(run);
  in.files["object"] = run / (folder + "/object.ply");
  in.found = extracted(run, {"contact"});
  in.outputs = {folder + "/particles.h5", "pieces.png"};
  return in;
}

json run_seed(const Context& context, RunDirectory& run, const Scene& scene, const SeedStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), seed_object);
}

OptionTable options_of(SeedStage& stage) {
  return {"seed",
          {{.name = "particles",
            .field = &stage.particles,
            .help = "Number of driving particles, which sets the grid resolution",
            .low = 200,
            .high = 1e7},
           {.name = "sampling",
            .field = &stage.drivers,
            .help = "Particle placement: kmeans, or pgas (Poisson disks, denser where E is small)",
            .choices = {"kmeans", "pgas"},
            .formerly = "drivers"},
           {.name = "material",
            .field = &stage.material_file,
            .help = "E(x) for pgas, a material.h5 of any particles (default: uniform)",
            .value = "FILE",
            .exists = true,
            .recorded = Recorded::kContents},
           {.name = "pin-below",
            .field = &stage.pin_below,
            .help = "Fix material below this height along up [scene units]",
            .value = "H"},
           {.name = "no-pin-contact",
            .field = &stage.pin_contact,
            .help = "Do not fix the object where it touches its support, nor its lowest tenth where nothing carries it",
            .off = true},
           {.name = "physgaussian",
            .field = &stage.physgaussian,
            .help = "Fill the object on the grid of this PhysGaussian configuration",
            .value = "FILE",
            .exists = true,
            .recorded = Recorded::kContents}}};
}

}  // namespace pliant
