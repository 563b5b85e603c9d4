#include "app/predict/prepare_object.h"

#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"

namespace pliant {

nlohmann::json prepare_object(const Context& context, RunDirectory& run, Scene& scene, const ObjectStages& stages,
                              SimulateStage& simulate) {
  run_extract(context, run, scene, stages.extract);
  const bool predicts = needs_prediction(scene, stages.predict, simulate);
  std::optional<double> height;
  if (predicts) {
    height = assume_height(context, run, scene, stages.predict);
  } else {
    forget_assumed_height(run, scene);
    scale_by_object(run, scene);
  }
  if (stages.repair) run_repair(context, run, scene, *stages.repair);
  run_fill(context, run, scene, stages.seed.fill);
  nlohmann::json prediction;
  if (predicts) {
    PredictStage predict = stages.predict;
    predict.given = simulate.material;
    prediction = run_predict(context, run, scene, predict);
    record_assumed_height(run, height);
    for (auto* value : {&simulate.material.young, &simulate.material.poisson, &simulate.material.density})
      value->reset();
  } else {
    run.forget("predict");
  }
  SeedStage seed = stages.seed;
  if (seed.drivers == "pgas") seed.material_file = simulate.material_file;
  run_drivers(context, run, scene, seed);
  return prediction;
}

void start_from_prediction(const nlohmann::json& prediction, const Scene& scene, const PredictStage& asked,
                           MaterialValues& material) {
  const MaterialValues file = kept_of_file(asked, scene.settings.material);
  if (!material.young && !file.young) material.young = prediction["young"];
  if (!file.poisson && !material.poisson) material.poisson = prediction["poisson"];
  if (!file.density && !material.density) material.density = prediction["density"];
}

}  // namespace pliant
