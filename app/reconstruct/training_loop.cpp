#include "app/reconstruct/training_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/reconstruct/schedule.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace {

constexpr int kMeasurements = 20;          // of held-out photos, evenly spread over the progress
constexpr double kMeasuringShare = 0.05;   // most of a limited time that they may take
constexpr double kCheckpointSeconds = 60;  // between two checkpoints, unless iterations are asked for

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Moving average over about the last `length` values.
class Average {
 public:
  explicit Average(double length) : share_(1 / length) {}
  void add(double value) {
    value_ = count_++ == 0 ? value : value_ + std::max(share_, 1.0 / count_) * (value - value_);
  }
  double value() const { return value_; }

 private:
  double share_, value_ = 0;
  int count_ = 0;
};

/// Time that is left when an iteration takes `per_iteration` now: later ones have larger photos and more Gaussians.
double seconds_left(const TrainOptions& options, const Trainer& trainer, double per_iteration, int longest_side) {
  const double progress = trainer.progress();
  if (options.seconds > 0) return (1 - progress) * options.seconds;
  const auto cost = [&](double at) {
    const double gaussians = options.densification == Densification::kNone
                                 ? trainer.state().cloud.size()
                                 : planned_gaussians(options, trainer.state().started_with, trainer.budget(), at);
    return std::pow(4.0, -level_at(options, at, longest_side)) * (0.3 + 0.7 * gaussians / trainer.budget());
  };
  const int samples = 64;
  double mean = 0;
  for (int i = 0; i < samples; ++i) mean += cost(progress + (1 - progress) * (i + 0.5) / samples) / samples;
  return (1 - progress) * options.iterations * per_iteration * mean / cost(progress);
}

/// The held-out photo in the middle, or the first photo of all.
const TrainingPhoto& shown_photo(const TrainingPhotos& photos) {
  std::vector<const TrainingPhoto*> held_out;
  for (const TrainingPhoto& photo : photos.photos)
    if (photo.held_out) held_out.push_back(&photo);
  return held_out.empty() ? photos.photos.front() : *held_out[held_out.size() / 2];
}

void write_preview(const std::filesystem::path& file, const TrainingPhoto& photo, const GaussianCloud& cloud,
                   const RenderOptions& options) {
  Camera camera;
  ImageF target, weight;
  photo_at_level(photo, 0, camera, target, weight);
  const ImageF picture = render(cloud, camera, options).color;
  ImageF both(2 * target.width, target.height, 3);
  const size_t row = static_cast<size_t>(target.width) * 3;
  for (int y = 0; y < target.height; ++y) {
    std::copy_n(target.at(0, y), row, both.at(0, y));
    std::copy_n(picture.at(0, y), row, both.at(target.width, y));
  }
  write_image(file, both);
}

}  // namespace

void train_to_end(const Context& context, const ReconstructStage& stage, const TrainingPhotos& photos, Trainer& trainer,
                  const std::filesystem::path& preview, const std::function<void(const TrainingState&)>& save) {
  int longest_side = 0;
  for (const TrainingPhoto& photo : photos.photos)
    longest_side = std::max({longest_side, photo.camera.width, photo.camera.height});
  Average loss(50), duration(30);
  auto last_save = Clock::now();
  double before = trainer.progress(), measuring = 0;
  context.progress.begin("reconstruct", 1000);
  while (!trainer.finished()) {
    auto start = Clock::now();
    const TrainStep step = trainer.step();
    duration.add(seconds_since(start));
    loss.add(step.loss);
    if (!std::isfinite(step.loss)) {
      context.progress.end();
      throw numerical_error("reconstruct", fmt::format("the loss is not finite at iteration {}", step.iteration),
                            "repeat the command to resume from the last checkpoint, or start over with another --seed");
    }
    start = Clock::now();
    const bool marked = std::floor(step.progress * kMeasurements) > std::floor(before * kMeasurements);
    before = step.progress;
    if (marked &&
        (stage.train.seconds == 0 || trainer.finished() || measuring <= kMeasuringShare * trainer.state().seconds)) {
      trainer.measure();
      write_preview(preview, shown_photo(photos), trainer.state().cloud, stage.train.render);
      measuring += seconds_since(start);
    }
    const bool due = stage.checkpoint_every > 0 ? step.iteration % stage.checkpoint_every == 0
                                                : seconds_since(last_save) > kCheckpointSeconds;
    if (due || context.interrupted() || trainer.finished()) {
      trainer.spend(seconds_since(start));
      start = Clock::now();
      save(trainer.state());
      last_save = Clock::now();
    }
    trainer.spend(seconds_since(start));
    const std::vector<CurvePoint>& curve = trainer.state().curve;
    context.progress.done(static_cast<int>(1000 * step.progress),
                          fmt::format("iteration {}, {} Gaussians, {}x{}, loss {:.4f}{}", step.iteration,
                                      step.gaussians, step.width, step.height, loss.value(),
                                      curve.empty() ? "" : fmt::format(", held out {:.2f} dB", curve.back().psnr)),
                          seconds_left(stage.train, trainer, duration.value(), longest_side));
    if (context.interrupted() && !trainer.finished()) {
      context.progress.end();
      throw Error(Failure::kInterrupted, "reconstruct", "",
                  fmt::format("interrupted after iteration {}", step.iteration), "repeat the command to resume");
    }
  }
  context.progress.end();
}

}  // namespace pliant
