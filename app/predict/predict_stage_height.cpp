#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/predict/object_prior.h"
#include "app/predict/predict_stage.h"
#include "app/run/attach_scene.h"
#include "fitting/predict/label_match.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace {

/// The longest extent of the extracted object, along its first principal axis, over its height.
double longest_over_height(const RunDirectory& run) {
  const GaussianCloud object = read_ply(run / (object_folder(run) + "/object.ply"));
  Vec3d sum = Vec3d::Zero();
  Mat3d squares = Mat3d::Zero();
  double total = 0;
  for (size_t i = 0; i < object.size(); ++i) {
    const double opacity = sigmoid(object.opacity_logit[i]);
    const Vec3d x = object.position[i].cast<double>();
    total += opacity;
    sum += opacity * x;
    squares += opacity * x * x.transpose();
  }
  const Vec3d mean = sum / total;
  const Vec3d axis = symmetric_eigen3(squares / total - mean * mean.transpose()).vectors.col(2);
  const Framing along = robust_framing(object, axis);
  const double height = extracted(run, {"height"})["height"];
  return std::max(1.0, (along.high.z() - along.low.z()) / height);
}

}  // namespace

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
      const double size = prior.height->typical;
      height = scene.object_height = prior.longest ? size / longest_over_height(run) : size;
      const std::string length = prior.longest ? fmt::format("{:g} m long, ", size) : "";
      context.progress.say(
          fmt::format("scale: the object is assumed to be {}{:.3g} m high, typical of '{}' (override with "
                      "--object-height)",
                      length, *height, prior.name));
    }
  }
  scale_to_height(run, scene);
  return height;
}

}  // namespace pliant
