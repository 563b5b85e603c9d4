// What a simulation depends on, and what it may not be made from.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/simulate/object_material.h"
#include "app/simulate/simulate_stage.h"
#include "app/store/velocity.h"
#include "gaussians/base/error.h"
#include "physics/laws/law.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Whether the fitted motion starts by itself; after a fit to markers it is a load that moves the body.
bool starts_moving(const fs::path& file) {
  const VelocityFile v = read_velocity(file);
  const auto zero = [](const Vec3f& x) { return x.isZero(0); };
  return !std::all_of(v.velocity.begin(), v.velocity.end(), zero) ||
         !std::all_of(v.displacement.begin(), v.displacement.end(), zero);
}

/// Whether a file is a fit's, which a simulation without it leaves as it is.
bool is_output_of_fit(const RunDirectory& run, const std::string& file) {
  if (!is_fitted(run)) return false;
  const json& outputs = run.manifest()["stages"]["fit"]["outputs"];
  return std::find(outputs.begin(), outputs.end(), file) != outputs.end();
}

/// Throws Error{kUsage} for a prediction that is not of the object, the scale and the scene file as they are now.
void check_predicted(const RunDirectory& run, const Scene& scene) {
  std::string of = prediction_is_of(run, scene);
  if (const std::string changed = of.empty() ? changed_since_prediction(run, scene) : ""; !changed.empty())
    of = "made before scene.json was changed (" + changed + ")";
  if (!of.empty())
    throw usage_error("simulate", "", "would use a prediction " + of,
                      "run `pliant predict` again, or give --young, --poisson and --density");
}

/// What the command line says nothing of, beside its own E, is as predicted; a prediction has the values of the scene
/// file where these count.  Of a scene file that says it all and has changed since, the present values count.
void take_predicted(const RunDirectory& run, const Scene& scene, MaterialValues& typed) {
  const json& prediction = run.summary("predict", "");
  const MaterialValues& file = scene.settings.material;
  const bool known = (typed.poisson || file.poisson) && (typed.density || file.density);
  const std::string changed = changed_since_prediction(run, scene);
  if (!known && !changed.empty())
    throw usage_error("simulate", "",
                      "would take nu or rho from a prediction made before scene.json was changed (" + changed + ")",
                      "run `pliant predict` again, or give --poisson and --density");
  if (!typed.poisson && changed.empty()) typed.poisson = prediction["poisson"].get<double>();
  if (!typed.density && changed.empty()) typed.density = prediction["density"].get<double>();
  if (typed.law.empty() && file.law.empty()) take_law(prediction["material"], typed);
}

}  // namespace

StageInputs<SimulateStage> inputs_of(const RunDirectory& run, const Scene& scene, const SimulateStage& stage) {
  const std::string folder = object_folder(run);
  check_seeded(run);
  const bool physgaussian = !stage.physgaussian.empty();
  const bool fitted = !physgaussian && stage.use_fit && is_fitted(run) && !stage.material.young;
  const bool unfinished = is_refit_unfinished(run);
  if (!stage.use_fit && !is_fitted(run) && !unfinished)
    throw usage_error("simulate", "--no-fit", "does nothing: nothing was fitted here", "leave it out");
  if (unfinished && stage.use_fit && !physgaussian && !stage.material.young && stage.material_file.empty())
    throw usage_error("simulate", "", "would not use the fit: one that is to replace it is unfinished",
                      "repeat that `pliant fit`, or ignore it with --no-fit");
  if (const std::string of = fit_is_of(run, scene); fitted && !of.empty())
    throw usage_error("simulate", "", "would use a fit made with " + of,
                      "run `pliant fit` again, or ignore the fit with --no-fit");
  // Fields come from files that the user gives, else from the fit: the material, and how the motion started, once more.
  const bool given = !stage.material_file.empty(), started = !stage.velocity_file.empty();
  const bool predicted = !physgaussian && !given && !fitted && !stage.material.young && run.has("predict");
  if (predicted) check_predicted(run, scene);
  const fs::path velocity_file = started ? fs::path(stage.velocity_file) : run / (folder + "/velocity.h5");
  const bool replay = started || (fitted && !given && stage.interactions.empty() && starts_moving(velocity_file));

  if (replay && stage.push != SimulateStage().push)
    throw usage_error("simulate", "--auto-push", "does nothing where the fitted motion is replayed",
                      "leave it out, or ignore the fit with --no-fit");

  StageInputs<SimulateStage> in;
  in.options = stage;
  in.parts = {ScenePart::kUp, ScenePart::kMetresPerUnit, ScenePart::kMaterial};
  in.files = {{"particles", run / (folder + "/particles.h5")}};
  in.outputs = {folder + "/trajectory.h5", "interactions.json"};
  if (given)
    in.files["material"] = stage.material_file;
  else if (fitted)
    in.files["material"] = run / (folder + "/material.h5");
  else if (predicted)
    in.files["material"] = run / (folder + "/predicted.h5");
  const std::string material = folder + "/material.h5";
  const bool of_fit = is_output_of_fit(run, material);
  if (!given && !fitted && !of_fit) in.outputs.push_back(material);
  if (physgaussian && of_fit) in.outputs.push_back(folder + "/physgaussian_material.h5");
  if (fitted || replay) in.files["velocity"] = velocity_file;
  const bool pushed = !physgaussian && !replay && stage.interactions.empty();
  if (pushed || physgaussian) in.files["object"] = run / (folder + "/object.ply");
  if (stage.obstacles) in.files["background"] = run / "background.ply";
  if (pushed || stage.obstacles) in.parts.insert({ScenePart::kCameras, ScenePart::kVideoCamera});
  in.scene = only(in.parts, scene);
  in.found = extracted(run, {"name", "height", "contact"});
  in.found["replay"] = replay;
  in.found["started"] = started;
  // Said here as well, because command line, scene file and fit say it together.
  in.found["fitted"] = fitted;
  const bool fields = given || fitted || predicted;
  if (fields) {
    in.files["object"] = run / (folder + "/object.ply");
    in.outputs.push_back("stiffness.png");
  }
  if (predicted) {
    const json& prediction = run.manifest()["stages"]["predict"]["summary"];
    in.found["predicted"] = prediction["understood"];
    if (in.options.material.law.empty() && in.scene.settings.material.law.empty())
      take_law(prediction["material"], in.options.material);
  }
  if (!physgaussian && !given && !fitted && !predicted && predicts_object(run))
    take_predicted(run, in.scene, in.options.material);
  if (!physgaussian)
    in.found["material"] = material_to_json(check_material(in.scene, in.options.material,
                                                           predicted ? SetBy::kPrediction
                                                           : fields  ? SetBy::kFields
                                                                     : SetBy::kNothing));
  // Motions of earlier versions do not say what the law remembers in the first frame.
  if (!physgaussian && has_memory(parse_law(in.found["material"]["law"]))) in.found["memory"] = 1;
  return in;
}

}  // namespace pliant
