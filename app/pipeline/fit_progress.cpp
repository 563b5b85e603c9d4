#include "app/pipeline/fit_progress.h"

#include <fmt/format.h>

#include "app/store/fit_checkpoint.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

constexpr const char* kCheckpoint = "fit/checkpoint.h5";

}  // namespace

MaterialFitProgress kept_progress(const Context& context, const RunDirectory& run, const std::string& provenance) {
  const fs::path file = run / kCheckpoint;
  auto checkpoint = std::make_shared<FitCheckpoint>();
  if (fs::exists(file) && read_fit_checkpoint_provenance(file) == provenance) {
    *checkpoint = read_fit_checkpoint(file);
    context.progress.say(checkpoint->gradient.rows.empty() ? "fit: goes on from the best constant of an interrupted fit"
                                                           : fmt::format("fit: goes on after {} iterations of an interrupted fit", checkpoint->gradient.rows.size()));
  }
  checkpoint->provenance_json = provenance;
  MaterialFitProgress kept{checkpoint->homogeneous, checkpoint->field, checkpoint->gradient, {}, {}, {}};
  kept.keep_homogeneous = [checkpoint, file](const VibrationFit& fit) {
    checkpoint->homogeneous = fit;
    write_fit_checkpoint(file, *checkpoint);
  };
  kept.keep_field = [checkpoint, file](const VibrationFit& fit) {
    checkpoint->field = fit;
    write_fit_checkpoint(file, *checkpoint);
  };
  kept.keep_gradient = [checkpoint, file, &context](const GradientFitState& state) {
    checkpoint->gradient = state;
    const bool stop = context.interrupted && context.interrupted();
    if (stop || state.rows.size() % 5 == 0) write_fit_checkpoint(file, *checkpoint);
    return !stop;
  };
  return kept;
}

void forget_progress(const RunDirectory& run) { fs::remove(run / kCheckpoint); }

}  // namespace pliant
