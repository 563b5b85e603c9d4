#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/predict/object_prior.h"
#include "app/predict/predict_stage.h"
#include "app/run/attach_scene.h"
#include "fitting/predict/label_match.h"

namespace pliant {

std::optional<double> assume_height(const Context& context, const RunDirectory& run, Scene& scene,
                                    const PredictStage& stage) {
  const nlohmann::json& typed = run.scene();
  std::optional<double> height;
  if (!typed.contains("metres_per_unit") && !typed.contains("object_height") && !scene.settings.metres_per_unit) {
    // What was assumed of an object before this one does not hold.
    scene.object_height = 0;
    scene.metres_per_unit = 1;
    PriorQuestion question = question_of(stage, extracted(run, {"name"})["name"]);
    // Of a label that only the language model may know, no height is known.
    if (!question.label.empty() && !stage.llm_url.empty() && !match_label(material_table(), question.label))
      question.label = question.name = "";
    const ObjectPrior prior = object_prior(question);
    if (prior.height) {
      height = scene.object_height = prior.height->typical;
      context.progress.say(
          fmt::format("scale: the object is assumed to be {:g} m high, typical of '{}' (override with --object-height)",
                      prior.height->typical, prior.name));
    }
  }
  scale_to_height(run, scene);
  return height;
}

}  // namespace pliant
