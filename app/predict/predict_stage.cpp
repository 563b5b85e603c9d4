#include "app/predict/predict_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/predict/object_prior.h"
#include "app/predict/object_samples.h"
#include "app/run/attach_scene.h"
#include "app/seed/body_pieces.h"
#include "app/seed/fill_stage.h"
#include "app/seed/particle_budget.h"
#include "app/simulate/clip_camera.h"
#include "app/simulate/object_material.h"
#include "app/simulate/simulated_body.h"
#include "app/store/material.h"
#include "app/store/solid.h"
#include "fitting/distribution/object_distribution.h"
#include "fitting/modal/sway.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/render.h"
#include "physics/body/pieces.h"
#include "physics/laws/material.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr double kHighestFrequency = 15;  // Hz, half the frame rate of a clip: what sways faster does not show
constexpr double kSlowestSoftened = 3;    // Hz, of what is made softer so that a clip is simulated in good time
constexpr int kSwayParticles = 1000;
constexpr double kUsualSoftness = 0.5;

/// What is asked of the table, and with --llm-url of a language model, which sees one view of the object.
PriorQuestion question_with_view(const StageInputs<PredictStage>& in, const GaussianCloud& object,
                                 const RunDirectory& run) {
  const PredictStage& stage = in.options;
  PriorQuestion question = question_of(stage, in.found["name"]);
  if (stage.llm_url.empty()) return question;
  question.llm = {.url = stage.llm_url,
                  .model = stage.llm_model,
                  .key = llm_key(stage.llm_url),
                  .cache = stage.answers.empty() ? run / kAnswers : stage.answers};
  const std::filesystem::path view = run / "llm_view.png";
  RenderOptions options;
  options.antialiased = in.scene.report.antialiased;
  options.background = in.scene.settings.background_color();
  write_image(view, render(object, clip_camera(in.scene, "", robust_bounds(object)), options).color);
  question.view = read_text(view);
  return question;
}

/// E(x), nu(x) and rho(x) around the means; parts that are not simulated do not count in these.
MaterialDistribution distribute(const SolidFile& file, const SolidSamples& samples, const GaussianCloud& object,
                                const Scene& scene, const std::string& weights, const Band& young,
                                const MaterialMeans& means) {
  const std::vector<Vec3f> colours = nearest_colours(object, file.samples.position);
  std::vector<float> moving = samples.volume;
  for (size_t i = 0; i < moving.size(); ++i)
    if (!file.simulated[i]) moving[i] = 0;
  return object_distribution(weights.empty() ? shipped_network() : read_network(weights),
                             {samples, colours, {}, scene.up.cast<float>(), {young.low, young.typical, young.high}},
                             moving, means);
}

/// The largest held piece of the simulated part as few particles.
Particles coarse_body(const SolidFile& file, const SolidSamples& samples, const ElasticSamples& solid,
                      const std::vector<Interaction>& pins, uint64_t seed) {
  std::vector<int> moving;
  for (size_t i = 0; i < samples.size(); ++i)
    if (file.simulated[i]) moving.push_back(static_cast<int>(i));
  // What floats apart from the body is not held, and would never sway back.
  const SolidSamples all = samples.select(moving);
  const float reach = 2 * static_cast<float>(std::cbrt(all.total_volume() / kSwayParticles));
  const Pieces pieces = find_pieces(all.position, all.volume, reach);
  std::vector<Region> regions;
  for (const Interaction& pin : pins) regions.push_back(pin.region);
  const int held = largest_held(pieces, all.position, regions);
  std::vector<int> body;
  for (size_t i = 0; i < moving.size(); ++i)
    if (pieces.piece[i] == held) body.push_back(moving[i]);
  DriverOptions options;
  options.count = kSwayParticles;
  options.seed = seed;
  const SolidSamples part = samples.select(body);
  return make_particles<float>(kmeans_drivers(options, part), part, solid.select(body), 1);
}

/// How fast `body` sways, in the softer of two level directions.  None where it sways too slowly to measure.
std::optional<double> frequency_of(const Particles& body, std::vector<Interaction> pins, const SolidSamples& samples,
                                   const Scene& scene) {
  if (pins.empty()) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3f& x : samples.position) {
      low = std::min(low, scene.up.dot(x.cast<double>()));
      high = std::max(high, scene.up.dot(x.cast<double>()));
    }
    pins.emplace_back().type = InteractionType::kPin;
    pins.back().region = Region::half_space(scene.up * (low + kHeldShare * (high - low)), scene.up);
  }
  SwayOptions sway;
  sway.direction = scene.up.unitOrthogonal();
  const std::optional<double> one = sway_frequency(sway, body, pins);
  sway.direction = scene.up.cross(sway.direction);
  const std::optional<double> other = sway_frequency(sway, body, pins);
  if (!one || !other) return std::nullopt;
  return std::min(*one, *other);
}

/// Whether such a thing is known to sway.
bool sways(const ObjectPrior& prior) { return prior.frequency && prior.frequency->typical > 0; }

/// The frequency that the object is to have at the usual softness, [Hz], where with its typical E it has `frequency`.
double wanted_frequency(const ObjectPrior& prior, double frequency) {
  if (prior.guessed) return prior.frequency->typical;
  const double low = sways(prior) ? prior.frequency->low : 0,
               high = sways(prior) ? prior.frequency->high : kHighestFrequency;
  const double most = std::min(high, kHighestFrequency);
  return std::clamp(frequency, std::min(low, most), most);
}

/// E at a softness / typical E; `by_frequency`: that of a guess, whose band is one of frequencies.
double softness_factor(const ObjectPrior& prior, bool by_frequency, double softness) {
  if (!by_frequency) return at_softness(prior.young, softness) / prior.young.typical;
  const double faster = at_softness(*prior.frequency, softness) / prior.frequency->typical;
  return faster * faster;
}

double first_of(const std::optional<double>& a, const std::optional<double>& b, double otherwise) {
  return a ? *a : b.value_or(otherwise);
}

json predict_object(const Context& context, const RunDirectory& run, const StageInputs<PredictStage>& in,
                    const std::string& provenance) {
  const PredictStage& stage = in.options;
  const Scene& scene = in.scene;
  const SolidFile file = read_solid(in.files.at("solid"));
  const SolidSamples samples = samples_in_metres(file, scene.metres_per_unit);
  const GaussianCloud object = read_ply(in.files.at("object"));
  ObjectPrior prior = object_prior(question_with_view(in, object, run));
  if (!prior.warning.empty()) context.progress.warn(prior.warning);
  const MaterialValues scene_file = kept_of_file(stage, scene.settings.material);
  const bool young_given = stage.given.young || scene_file.young;
  const MaterialMeans means = {first_of(stage.given.young, scene_file.young, prior.young.typical),
                               first_of(stage.given.poisson, scene_file.poisson, prior.poisson.typical),
                               first_of(stage.given.density, scene_file.density, prior.density.typical)};
  const MaterialDistribution field = distribute(file, samples, object, scene, stage.weights, prior.young, means);

  ElasticSamples solid{field.young, field.poisson, field.density};
  const std::vector<Interaction> pins = pins_of(file.pinned_json, scene);
  const Particles body = coarse_body(file, samples, solid, pins, context.seed);
  const std::optional<double> shown = frequency_of(body, pins, samples, scene);
  CoarseCost cost = cost_of(body, kSwayParticles);
  double factor = 1, frequency = shown.value_or(0);
  if (shown && !young_given) {
    frequency = wanted_frequency(prior, *shown);
    // A guess, and what is made softer than it is, sways no faster than few particles can be simulated in good time.
    if (prior.guessed || frequency < *shown)
      frequency = std::clamp(*shown * kUsualParticleSteps / particle_steps(cost, kFewestParticles),
                             std::min(sways(prior) ? prior.frequency->low : kSlowestSoftened, frequency), frequency);
    factor = (frequency / *shown) * (frequency / *shown);
  }
  // The band is that of the typical E, whichever E of it is asked for.
  Band young_band = {prior.young.low * factor, prior.young.typical * factor, prior.young.high * factor};
  if (prior.guessed && shown) {
    const double slower = young_given ? 1 : frequency / prior.frequency->typical;
    for (double Band::*end : {&Band::low, &Band::typical, &Band::high})
      young_band.*end = means.young * std::pow(slower * (*prior.frequency).*end / *shown, 2);
  }
  std::string words = prior.source;
  if (std::abs(factor - 1) > 1e-3 && !prior.guessed)
    words += fmt::format("; E multiplied by {:.3g}, because with {:.3g} Pa it would sway at {:.3g} Hz", factor,
                         means.young, *shown);
  const double softness = stage.softness.value_or(kUsualSoftness);
  if (!young_given) {
    const double stiffer = softness_factor(prior, prior.guessed && shown, softness);
    frequency *= std::sqrt(stiffer);
    factor *= stiffer;
  }
  for (float& E : solid.young) E *= static_cast<float>(factor);
  cost.steps_per_second *= std::sqrt(factor);
  const double young = means.young * factor;
  write_material(run / in.outputs[0],
                 {solid.young, solid.poisson, solid.density, "predicted for '" + prior.name + "'",
                  file.samples.position, file.samples.volume, field.sigma},
                 provenance);
  context.progress.say(
      fmt::format("predict: {}{}: E {:.3g} Pa on average ({}), nu {:.2f}, rho {:.4g} kg/m^3, sways at {}",
                  prior.guessed ? "unknown, assumed to be a " : "", prior.name, young,
                  young_given ? "as given" : fmt::format("{:.2g} to {:.2g}", young_band.low, young_band.high),
                  means.poisson, means.density, shown ? fmt::format("{:.2g} Hz", frequency) : "an unknown frequency"));
  if (prior.guessed)
    context.progress.say(
        "predict: E is a guess chosen for a visible sway; set the object with --label, or its softness with --softness "
        "0..1");
  json given = json::array();
  if (young_given) given.push_back("young");
  if (stage.given.poisson || scene_file.poisson) given.push_back("poisson");
  if (stage.given.density || scene_file.density) given.push_back("density");
  const ObjectMaterial law{young, means.poisson, means.density, prior.law};
  return {{"understood", prior.name},
          {"guessed", prior.guessed},
          {"unanswered", prior.unanswered},
          {"source", words},
          {"softness", softness},
          {"given", given},
          {"young", young},
          {"young_band", band_json(young_band)},
          {"poisson", means.poisson},
          {"poisson_band", band_json(prior.poisson)},
          {"density", means.density},
          {"density_band", band_json(prior.density)},
          {"frequency_hz", shown ? json(frequency) : json()},
          {"frequency_band", prior.frequency ? band_json(*prior.frequency) : json()},
          {"cost", to_json(cost)},
          {"material", material_to_json(law)},
          {"object", identity_of_object(run)}};
}

}  // namespace

StageInputs<PredictStage> inputs_of(const RunDirectory& run, const Scene& scene, const PredictStage& stage) {
  check_predict_stage(stage);
  check_filled(run);
  StageInputs<PredictStage> in;
  in.options = stage;
  in.parts = {ScenePart::kUp, ScenePart::kMetresPerUnit, ScenePart::kMaterial};
  if (!stage.llm_url.empty()) in.parts.insert({ScenePart::kDrawing, ScenePart::kCameras, ScenePart::kVideoCamera});
  in.scene = only(in.parts, scene);
  const std::string folder = object_folder(run);
  in.files = {{"solid", run / (folder + "/solid.h5")}, {"object", run / (folder + "/object.ply")}};
  in.found = extracted(run, {"name"});
  if (!stage.known.label.empty()) in.found["known"]["label"] = stage.known.label;
  if (!stage.known.material.empty()) in.found["known"]["material"] = stage.known.material;
  in.outputs = {folder + "/predicted.h5"};
  return in;
}

json run_predict(const Context& context, RunDirectory& run, const Scene& scene, const PredictStage& stage) {
  StageInputs<PredictStage> in = inputs_of(run, scene, stage);
  // A service that gave nothing is asked the same again; where another question fails, that prediction stays.
  if (!stage.llm_url.empty() && run.has("predict") && run.summary("predict", "").value("unanswered", false) &&
      first_difference(run.manifest()["stages"]["predict"], record_of(key_of(in), context.seed)).empty())
    run.forget("predict");
  return run_stage(context, run, std::move(in), predict_object);
}

bool needs_prediction(const Scene& scene, const PredictStage& stage, const SimulateStage& simulate) {
  if (!simulate.material_file.empty() || !simulate.physgaussian.empty()) return false;
  const MaterialValues &typed = simulate.material, &file = scene.settings.material;
  const bool known = (typed.young || file.young) && (typed.poisson || file.poisson) && (typed.density || file.density);
  return !known || asks_for_material(stage);
}

OptionTable options_of(PredictStage& stage) {
  OptionTable table{
      "predict",
      {{.name = "label",
        .field = &stage.label,
        .help = "What the object is, such as 'potted palm' (default: its name)",
        .value = "TEXT"},
       {.name = "material",
        .field = &stage.material,
        .help = "Material from the table, instead of a label (see pliant predict --list)",
        .value = "NAME"},
       {.name = "softness",
        .field = &stage.softness,
        .help = "E in its predicted range: 0 = stiffest, 1 = softest (default: 0.5)",
        .low = 0,
        .high = 1},
       {.name = "weights",
        .field = &stage.weights,
        .help = "Material network from train-predictor (default: the bundled one)",
        .value = "FILE",
        .exists = true,
        .recorded = Recorded::kContents},
       {.name = "llm-url",
        .field = &stage.llm_url,
        .help =
            "OpenAI-compatible service asked for the material; key: PLIANT_LLM_KEY (api.openai.com: or OPENAI_API_KEY)",
        .value = "URL"},
       {.name = "llm-model", .field = &stage.llm_model, .help = "Model of that service", .value = "NAME"}}};
  for (Option& option : material_options(stage.given)) table.options.push_back(std::move(option));
  return table;
}

}  // namespace pliant
