#include "app/evaluate/metric_table.h"

#include <nlohmann/json.hpp>

#include "app/evaluate/metrics.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

using nlohmann::json;

namespace pliant {

const std::vector<Metric>& metric_table() {
  static const std::vector<Metric> table = {
      // images, repair
      {"psnr", "PSNR", "dB", true, 0},
      {"ssim", "SSIM", "", true, 0},
      {"ms_ssim", "MS-SSIM", "", true, 0},
      {"mse", "MSE", "", false, 1},
      {"gain_over_opencv", "PSNR over inpainting", "dB", true, 0},
      {"consistency_psnr", "Consistency of views", "dB", true, 0},
      {"outside.psnr", "PSNR outside the hole", "dB", true, 0},
      // segmentation, lerf-mask, nvos
      {"miou", "mIoU", "", true, 0},
      {"boundary_miou", "mBIoU", "", true, 0},
      {"accuracy", "Accuracy", "", true, 0},
      // material
      {"log10_young_error", "Error of log10 E", "decades", false, 0},
      {"poisson_error", "Error of nu", "", false, 0},
      {"density_relative_error", "Relative error of density", "", false, 1},
      // trajectory, motion, slices
      {"relative_error", "Motion error / motion", "", false, 1},
      {"position_error_mean", "Position error / height", "", false, 0},
      {"tip_error_mean", "Tip error / height", "", false, 0},
      {"peak_error", "Relative error of the peak", "", false, 1},
      {"frequency_error", "Relative error of frequency", "", false, 1},
      {"damping_error", "Relative error of damping", "", false, 1},
      {"amplitude_error", "Relative error of amplitude", "", false, 1},
      {"flow_error", "Relative error of flow", "", false, 1},
      {"row_rmse", "RMSE of the row's slice", "", false, 1},
      {"column_rmse", "RMSE of the column's slice", "", false, 1},
  };
  return table;
}

namespace {

/// The metric of the table that has a key, else the one that has its last part: "unseen.frequency_error" is read as
/// "frequency_error".  Null where there is neither.
const Metric* metric_of(const std::string& key) {
  const std::string last = key.substr(key.rfind('.') + 1);
  const Metric* found = nullptr;
  for (const Metric& metric : metric_table()) {
    if (metric.key == key) return &metric;
    if (metric.key == last) found = &metric;
  }
  return found;
}

}  // namespace

Metric metric_named(const std::string& text, const std::string& option) {
  std::vector<std::string> known;
  for (const Metric& metric : metric_table()) {
    if (metric.key == text) return metric;
    known.push_back(metric.key);
  }
  if (const size_t colon = text.rfind(':'); colon != std::string::npos && colon > 0) {
    const std::string key = text.substr(0, colon), direction = text.substr(colon + 1);
    if (direction == "higher" || direction == "lower") {
      const Metric* metric = metric_of(key);
      if (!metric) return {key, key, "", direction == "higher", 0};
      const std::string better = metric->higher_is_better ? "higher" : "lower";
      if (direction != better)
        throw usage_error("evaluate", option,
                          "is '" + text + "', but " + metric->title + " is better when it is " + better,
                          "write '" + (metric->key == key ? key : key + ":" + better) + "'");
      if (metric->key == key) return *metric;
      return {key, key, metric->unit, metric->higher_is_better, metric->failure};
    }
  }
  throw usage_error("evaluate", option, "is '" + text + "', which is not a metric of evaluate",
                    "did you mean '" + nearest_name(text, known) + "'? Write others as KEY:higher or KEY:lower");
}

json metric_value(const json& result, const std::string& key) {
  const json* found = find_value(result, key);
  if (found && found->is_number()) return *found;
  const size_t dot = key.rfind('.');
  const json* owner = dot == std::string::npos ? &result : find_value(result, key.substr(0, dot));
  const bool identical = owner && owner->is_object() && owner->value("identical", false);
  if (found && identical && key.substr(dot == std::string::npos ? 0 : dot + 1) == "psnr") return kPsnrOfIdentical;
  return nullptr;
}

}  // namespace pliant
