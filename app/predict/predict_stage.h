#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "app/simulate/simulate_stage.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

constexpr const char* kAnswers = "llm_answers";  ///< folder of a run directory

struct PriorQuestion;

/// What an earlier prediction took an object for, by its label or a material of the table; both empty = nothing.
struct TakenFor {
  std::string label, material;
};

/// predict: what the object is made of, from its name and its shape -> objects/.../predicted.h5.
struct PredictStage {
  std::string label;               ///< what the object is; empty = the name that it has
  std::string material;            ///< of the table, instead of a label
  std::optional<double> softness;  ///< of E in its band; none = 0.5, and no material is asked for by it
  std::string weights;             ///< of train-predictor; empty = those that ship
  std::string llm_url, llm_model;
  MaterialValues given;  ///< command line's, which are kept
  TakenFor known;        ///< counts where no label or material is named; by it E, nu and rho of the scene file stay
  std::filesystem::path answers;  ///< folder of the language model's answers; empty = kAnswers of the run
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(PredictStage& stage);
/// Throws Error{kUsage} for options that contradict each other, and for a material, or a label without a language
/// model, that the table does not know.
void check_predict_stage(const PredictStage& stage);
/// Whether a label, a material, a softness or a language model is named, by which the E of the scene file does not
/// count.
bool asks_for_material(const PredictStage& stage);
/// What of the scene file's E, nu and rho counts: none of them beside a label or a material, no E beside a softness or
/// a language model.
MaterialValues kept_of_file(const PredictStage& stage, const MaterialValues& file);
StageInputs<PredictStage> inputs_of(const RunDirectory& run, const Scene& scene, const PredictStage& stage);
nlohmann::json run_predict(const Context& context, RunDirectory& run, const Scene& scene, const PredictStage& stage);

/// What is asked of an object of this name, without a language model.
PriorQuestion question_of(const PredictStage& stage, const std::string& name);

/// Where neither a label nor a material is named: takes over what the prediction that is there took this object for,
/// and the language model where that alone knows the label.
void keep_known_object(const RunDirectory& run, PredictStage& stage);
/// Takes the options of the prediction that is there, if any.  Throws Error{kUsage} where it was made with a network of
/// its own, whose file is not known.
void take_last_options(const RunDirectory& run, PredictStage& stage);

/// Whether `run` has to predict: a value of the material is neither on the command line nor in the scene file, or the
/// command line asks for a prediction.
bool needs_prediction(const Scene& scene, const PredictStage& stage, const SimulateStage& simulate);

/// Where nobody says how large the scene is: its object gets the usual height of what it is named [m], or that at which
/// its longest extent is the usual one, by which `scene` is scaled.  Once the prediction is there,
/// record_assumed_height keeps it.
std::optional<double> assume_height(const Context& context, const RunDirectory& run, Scene& scene,
                                    const PredictStage& stage);

}  // namespace pliant
