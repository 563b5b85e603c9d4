#include <nlohmann/json.hpp>

#include "app/predict/object_prior.h"
#include "app/predict/predict_stage.h"
#include "app/run/attach_scene.h"
#include "fitting/predict/label_match.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

PriorQuestion question_of(const PredictStage& stage, const std::string& name) {
  const TakenFor& known = stage.known;
  return {stage.material.empty() ? known.material : stage.material,
          stage.label,
          known.label.empty() ? name : known.label,
          {},
          {}};
}

void keep_known_object(const RunDirectory& run, PredictStage& stage) {
  if (!stage.label.empty() || !stage.material.empty() || !run.has("predict")) return;
  const json& record = run.manifest()["stages"]["predict"];
  const json of = record["summary"].value("object", json());
  if (of.is_object() ? !is_present_object(run, of) : !predicts_object(run)) return;
  PredictStage last;
  take_recorded(record["options"], options_of(last));
  const json kept = record["found"].value("known", json::object());
  const bool asked = !last.label.empty() || !last.material.empty();
  stage.known.label = asked ? last.label : kept.value("label", "");
  // A language model is asked instead of the table.
  if (stage.llm_url.empty()) stage.known.material = asked ? last.material : kept.value("material", "");
  const std::string& label = stage.known.label;
  if (label.empty() || !stage.llm_url.empty() || match_label(material_table(), label)) return;
  // What the table does not know is asked of the same language model again, whose answer is there.
  stage.llm_url = last.llm_url;
  stage.llm_model = last.llm_model;
}

void take_last_options(const RunDirectory& run, PredictStage& stage) {
  const json last = run.last_record("predict");
  if (last.is_null()) return;
  if (last["inputs"].contains("weights"))
    throw usage_error("predict", "--preview", "would replace a prediction made with --weights",
                      "give the options of that prediction again");
  take_recorded(last["options"], options_of(stage));
}

}  // namespace pliant
