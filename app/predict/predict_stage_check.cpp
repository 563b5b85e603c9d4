#include "app/predict/object_prior.h"
#include "app/predict/predict_stage.h"
#include "fitting/predict/label_match.h"
#include "gaussians/base/error.h"

namespace pliant {

void check_predict_stage(const PredictStage& stage) {
  if (!stage.material.empty() && !stage.label.empty())
    throw usage_error("predict", "--material", "was given together with --label", "leave one of them out");
  if (!stage.material.empty() && !stage.llm_url.empty())
    throw usage_error("predict", "--llm-url", "does nothing with --material, which is looked up in the table",
                      "leave one of them out");
  if (stage.llm_url.empty() != stage.llm_model.empty())
    throw usage_error("predict", stage.llm_url.empty() ? "--llm-model" : "--llm-url", "was given without the other",
                      "give --llm-url and --llm-model, or neither");
  if (stage.given.young && stage.softness)
    throw usage_error("predict", "--softness", "does nothing with --young, which sets the mean",
                      "leave one of them out");
  if (!stage.material.empty()) find_material(material_table(), stage.material);
  // A language model may know what the table does not.
  if (!stage.label.empty() && stage.llm_url.empty() && !match_label(material_table(), stage.label))
    throw unknown_label(stage.label);
}

bool asks_for_material(const PredictStage& stage) {
  return !stage.label.empty() || !stage.material.empty() || stage.softness || !stage.llm_url.empty();
}

MaterialValues kept_of_file(const PredictStage& stage, const MaterialValues& file) {
  MaterialValues kept = file;
  if (asks_for_material(stage)) kept.young.reset();
  if (stage.label.empty() && stage.material.empty()) return kept;
  kept.poisson.reset();
  kept.density.reset();
  return kept;
}

}  // namespace pliant
