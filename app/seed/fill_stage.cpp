#include "app/seed/fill_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/import/physgaussian_space.h"
#include "app/run/attach_scene.h"
#include "app/seed/object_pins.h"
#include "gaussians/io/splats/ply.h"
#include "physics/body/driving_particles.h"
#include "physics/body/interior_fill.h"
#include "physics/body/pieces.h"
#include "physics/body/silhouette_outset.h"
#include "physics/body/thin_parts.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr int kSamplesPerDriver = 8;

/// Dense samples of the solid, refined until the simulated part, which `pins` say, has enough of them for every driver.
SolidSamples sample_solid(const Context& context, const FillOptions& first, const GaussianCloud& object, int drivers,
                          const std::function<std::vector<Region>(const SolidSamples&)>& pins_of,
                          std::vector<Region>& pins, FillSummary& summary, SimulatedPart& part) {
  FillOptions options = first;
  const auto fill = [&] {
    SolidSamples filled = fill_interior(options, object, &summary);
    filled.rod = find_rods(filled);
    return filled;
  };
  SolidSamples samples = fill();
  pins = pins_of(samples);
  part = select_simulated(samples, pins, drivers);
  const double wanted = static_cast<double>(kSamplesPerDriver) * drivers;
  constexpr double kMostSamples = 4e6;
  const double grow = std::min(wanted / static_cast<double>(std::max<size_t>(part.kept.size(), 1)),
                               kMostSamples / options.target_count);
  if (part.kept.size() < 0.8 * wanted && grow > 1) {
    options.target_count = static_cast<int>(options.target_count * grow);
    samples = fill();
    part = select_simulated(samples, pins, drivers);
  }
  const float cell = part.cell_size;
  const BridgeSummary bridged = bridge_gaps({0.5f * cell, 3 * cell, cell}, object, samples);
  if (bridged.bridges > 0) {
    context.progress.say(
        fmt::format("seed: {} gaps in the surface bridged with {} samples", bridged.bridges, bridged.samples));
    samples.rod.clear();
    samples.rod = find_rods(samples);
    part = select_simulated(samples, pins, drivers);
    summary.volume = samples.total_volume();
  }
  return samples;
}

/// Driving particles, eight to a cell, that fill `volume` with the cells of a configuration of PhysGaussian.
int particles_of_configuration(const Context& context, const std::string& file, double volume,
                               const GaussianCloud& object) {
  constexpr int kMost = 2000000;
  const PhysGaussianConfig config = read_physgaussian_config(file);
  const double cell = config.cell_size() / simulation_space(config, object, physgaussian_members(config, object)).scale;
  const double wanted = 8 * volume / (cell * cell * cell);
  if (wanted > kMost)
    context.progress.warn(fmt::format("the configuration's cells need {:.3g} particles; {} are used", wanted, kMost));
  return static_cast<int>(std::clamp<double>(wanted, 200, kMost));
}

json fill_object(const Context& context, const RunDirectory& run, const StageInputs<FillStage>& in,
                 const std::string& provenance) {
  const FillStage& stage = in.options;
  const Scene& scene = in.scene;
  const bool configured = !stage.physgaussian.empty();
  const GaussianCloud object = read_ply(in.files.at("object"));
  FillOptions fill;
  fill.seed = context.seed;
  if (!scene.cameras_are_orbit) {
    RenderOptions render;
    render.antialiased = scene.report.antialiased;
    fill.outset = silhouette_outset(object, scene.cameras, render);
  }
  int particles = stage.particles.value_or(kUsualParticles);
  FillSummary filled;
  if (configured) {
    fill.target_count = kSamplesPerDriver * particles;
    fill_interior(fill, object, &filled);
    particles = particles_of_configuration(context, stage.physgaussian, filled.volume, object);
  }
  fill.target_count = kSamplesPerDriver * particles;
  const auto pins_of = [&](const SolidSamples& samples) {
    return configured ? std::vector<Region>{} : object_pins(context, scene, stage, in.found, object, samples);
  };
  SimulatedPart part;
  SolidFile file;
  std::vector<Region> pins;
  file.samples = sample_solid(context, fill, object, particles, pins_of, pins, filled, part);
  file.samples.thickness.resize(file.samples.size());
  file.simulated.assign(file.samples.size(), 0);
  for (const int i : part.kept) file.simulated[i] = 1;
  file.volume = filled.volume;
  json rows = json::array();
  for (const Region& pin : pins) rows.push_back(region_to_json(pin));
  file.pinned_json = rows.dump();
  write_solid(run / in.outputs[0], file, provenance);
  if (pins.empty() && !configured && in.found.contains("contact"))
    context.progress.say("seed: nothing is fixed, the object lies free on '" +
                         in.found["contact"]["support"].get<std::string>() + "'");
  else if (pins.empty() && !configured)
    context.progress.warn("the object is not pinned and will fall (give --pin-below, or pinned regions in scene.json)");
  return {{"samples", file.samples.size()},
          {"particles", particles},
          {"outset", fill.outset},
          {"volume", filled.volume},
          {"thin_samples", filled.thin_samples}};
}

}  // namespace

std::vector<Region> pinned_regions(const SolidFile& solid, const Scene& scene) {
  std::vector<Region> pins;
  for (const json& row : json::parse(solid.pinned_json))
    pins.push_back(parse_region(row, {scene.metres_per_unit, scene.up}, "solid.h5"));
  return pins;
}

StageInputs<FillStage> inputs_of(const RunDirectory& run, const Scene& scene, const FillStage& stage) {
  StageInputs<FillStage> in;
  in.options = stage;
  // Pictures of the cameras tell how large the solid is.
  in.parts = {ScenePart::kDrawing, ScenePart::kCameras, ScenePart::kUp, ScenePart::kPinned};
  in.scene = only(in.parts, scene);
  const std::string folder = object_folder(run);
  in.files["object"] = run / (folder + "/object.ply");
  in.found = extracted(run, {"contact"});
  in.outputs = {folder + "/solid.h5"};
  return in;
}

json run_fill(const Context& context, RunDirectory& run, const Scene& scene, const FillStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), fill_object);
}

OptionTable options_of(FillStage& stage) {
  return {"fill",
          {{.name = "particles",
            .field = &stage.particles,
            .help = "Number of driving particles, which sets the grid resolution [8000; fewer where a stiff material "
                    "is predicted]",
            .value = "N",
            .low = 200,
            .high = 1e7},
           {.name = "pin-below",
            .field = &stage.pin_below,
            .help = "Fix material below this height along up [scene units]",
            .value = "H"},
           {.name = "no-pin-contact",
            .field = &stage.pin_contact,
            .help = "Do not fix the object where it touches its support, nor its lowest tenth if it has no support",
            .off = true},
           {.name = "physgaussian",
            .field = &stage.physgaussian,
            .help = "Fill the object on the grid of this PhysGaussian configuration",
            .value = "FILE",
            .exists = true,
            .recorded = Recorded::kContents}}};
}

}  // namespace pliant
