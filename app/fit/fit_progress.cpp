#include "app/fit/fit_progress.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/store/fit_checkpoint.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

constexpr const char* kCheckpoint = "fit/checkpoint.h5";

/// Where an interrupted fit goes on.
std::string place_of(const FitCheckpoint& checkpoint) {
  const size_t iterations = checkpoint.velocity.rows.size() + checkpoint.gradient.rows.size();
  if (iterations > 0) return fmt::format("after {} iterations of an interrupted fit", iterations);
  size_t steps = checkpoint.markers.refinement.loss.size() + checkpoint.markers.simulated.size();
  if (steps > 0) return fmt::format("after {} steps of an interrupted fit", steps);
  for (const GaussNewtonState& refinement : checkpoint.vibration.refinements) steps += refinement.loss.size() - 1;
  const std::string from = checkpoint.field ? "field" : checkpoint.homogeneous ? "best uniform E" : "modes";
  return steps == 0 ? fmt::format("from the {} of an interrupted fit", from)
                    : fmt::format("after {} steps from the {} of an interrupted fit", steps, from);
}

std::shared_ptr<FitCheckpoint> kept_checkpoint(const Context& context, const fs::path& file,
                                               const std::string& provenance) {
  auto checkpoint = std::make_shared<FitCheckpoint>();
  if (fs::exists(file)) {
    nlohmann::json before = nlohmann::json::parse(read_fit_checkpoint_provenance(file), nullptr, false);
    leave_out_paths(before);
    const bool same = before == nlohmann::json::parse(provenance);
    if (same) *checkpoint = read_fit_checkpoint(file);
    context.progress.say(same ? "fit: resuming " + place_of(*checkpoint)
                              : "fit: starting over; the interrupted fit had other options or inputs, or is from "
                                "another version of Pliant");
  }
  checkpoint->provenance_json = provenance;
  fs::create_directories(file.parent_path());
  return checkpoint;
}

}  // namespace

MaterialFitProgress kept_progress(const Context& context, const RunDirectory& run, const std::string& provenance) {
  const fs::path file = run / kCheckpoint;
  const std::shared_ptr<FitCheckpoint> checkpoint = kept_checkpoint(context, file, provenance);
  const auto write = [checkpoint, file] { write_fit_checkpoint(file, *checkpoint); };
  MaterialFitProgress kept;
  kept.homogeneous = checkpoint->homogeneous;
  kept.field = checkpoint->field;
  kept.vibration = checkpoint->vibration;
  kept.velocity = checkpoint->velocity;
  kept.gradient = checkpoint->gradient;
  kept.posterior = checkpoint->posterior;
  kept.keep_vibration = [=](const VibrationFitState& state) {
    checkpoint->vibration = state;
    write();
  };
  kept.keep_homogeneous = [=](const VibrationFit& fit) {
    checkpoint->homogeneous = fit;
    checkpoint->vibration = {};
    write();
  };
  kept.keep_field = [=](const VibrationFit& fit) {
    checkpoint->field = fit;
    checkpoint->vibration = {};
    write();
  };
  kept.keep_posterior = [=](const PosteriorState& state) {
    checkpoint->posterior = state;
    write();
  };
  const auto go_on = [&context] { return !(context.interrupted && context.interrupted()); };
  kept.keep_velocity = [=](const GradientFitState& state) { return checkpoint->velocity = state, write(), go_on(); };
  kept.keep_gradient = [=](const GradientFitState& state) { return checkpoint->gradient = state, write(), go_on(); };
  return kept;
}

KeptMarkerFit kept_marker_fit(const Context& context, const RunDirectory& run, const std::string& provenance) {
  const fs::path file = run / kCheckpoint;
  const std::shared_ptr<FitCheckpoint> checkpoint = kept_checkpoint(context, file, provenance);
  return {checkpoint->markers, [=, &context](const MarkerFitState& state) {
            checkpoint->markers = state;
            write_fit_checkpoint(file, *checkpoint);
            if (context.interrupted && context.interrupted())
              throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command again");
          }};
}

void forget_progress(const RunDirectory& run) { fs::remove(run / kCheckpoint); }

}  // namespace pliant
