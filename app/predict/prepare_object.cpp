#include "app/predict/prepare_object.h"

#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"

namespace pliant {

nlohmann::json prepare_object(const Context& context, RunDirectory& run, Scene& scene, const ObjectStages& stages,
                              SimulateStage& simulate) {
  run_extract(context, run, scene, stages.extract);
  const bool predicts = needs_prediction(scene, stages.predict, simulate);
  if (predicts) {
    assume_height(context, run, scene, stages.predict);
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

}  // namespace pliant
