#include "gaussians/reconstruct/trainer.h"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "gaussians/reconstruct/adam_rows.h"
#include "gaussians/reconstruct/densify_classic.h"
#include "gaussians/reconstruct/densify_mcmc.h"
#include "gaussians/reconstruct/exposure.h"
#include "gaussians/reconstruct/schedule.h"
#include "gaussians/reconstruct/start_cloud.h"

namespace pliant {
namespace {

constexpr uint64_t kOrderStream = 0x6f72646572ull, kBackdropStream = 0x6261636b64726f70ull;

/// The order in which a round shows n photos.
std::vector<int> shuffled(size_t n, uint64_t seed, uint64_t round) {
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  Random random(seed, kOrderStream, round);
  for (size_t i = n; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

/// Whether a mark at multiples of `every` lies in (before, now].
bool passes(double before, double now, double every) { return std::floor(now / every) > std::floor(before / every); }

}  // namespace

size_t gaussian_budget(const TrainOptions& options, const TrainingPhotos& photos) {
  if (options.most_gaussians > 0) return options.most_gaussians;
  size_t pixels = 0;
  for (const TrainingPhoto& photo : photos.photos) pixels += photo.held_out ? 0 : photo.pixels.pixels();
  return std::clamp<size_t>(pixels / 100, 20000, 150000);
}

Trainer::Trainer(const TrainOptions& options, const TrainingPhotos& photos, GaussianCloud start,
                 const AttributeTerm* term)
    : options_(options), photos_(photos), term_(term) {
  CHECK(start.size() > 0);
  state_.started_with = start.size();
  state_.cloud = with_sh_degree(start, std::max(0, std::min(start.sh_degree, options.sh_degree)));
  if (term_) term_->start(state_.cloud, state_.attribute, state_.shared);
  if (options_.exposure) {
    for (size_t i = 0; i < photos.photos.size(); ++i)
      state_.exposure.insert(state_.exposure.end(), kNeutralExposure, kNeutralExposure + kExposureSize);
  }
  prepare();
}

Trainer::Trainer(const TrainOptions& options, const TrainingPhotos& photos, TrainingState state,
                 const AttributeTerm* term)
    : options_(options), photos_(photos), term_(term), state_(std::move(state)) {
  const bool fits = state_.cloud.size() > 0 &&
                    state_.exposure.size() == (options.exposure ? photos.photos.size() * kExposureSize : 0) &&
                    state_.attribute_channels() == (term_ ? term_->channels() : 0);
  if (!fits) throw input_error("checkpoint", "", "belongs to other photos or options", "start over with --overwrite");
  prepare();
}

void Trainer::prepare() {
  std::vector<Camera> cameras;
  for (size_t i = 0; i < photos_.photos.size(); ++i) {
    const TrainingPhoto& photo = photos_.photos[i];
    cameras.push_back(photo.camera);
    longest_side_ = std::max({longest_side_, photo.camera.width, photo.camera.height});
    if (!photo.held_out) trained_on_.push_back(static_cast<int>(i));
  }
  if (trained_on_.empty()) throw input_error("photos", "", "are all held out", "give more photos, or hold out fewer");
  extent_ = camera_extent(cameras);
  budget_ = gaussian_budget(options_, photos_);
  fit_moments(state_);
}

double Trainer::progress() const { return training_progress(options_, state_.iteration, state_.seconds); }

bool Trainer::finished() const { return progress() >= 1; }

Trainer::Shown Trainer::show(double progress) const {
  const size_t n = trained_on_.size();
  Shown shown;
  shown.photo = trained_on_[shuffled(n, options_.seed, state_.iteration / n)[state_.iteration % n]];
  shown.level = level_at(options_, progress, longest_side_);
  const TrainingPhoto& photo = photos_.photos[shown.photo];
  photo_at_level(photo, shown.level, shown.camera, shown.target, shown.weight);
  shown.backdrop = options_.render.background;
  if (!options_.changing_backdrop || photo.alpha.empty()) return shown;
  Random random(options_.seed, kBackdropStream, state_.iteration);
  for (float& value : shown.backdrop) value = static_cast<float>(random.uniform());
  // The picture is compared after its exposure, so the colour behind the photo goes through it too.
  ImageF behind(1, 1, 3);
  std::copy_n(shown.backdrop.data(), 3, behind.data.data());
  if (options_.exposure) behind = expose(behind, state_.exposure.data() + shown.photo * kExposureSize);
  change_backdrop(photo, options_.render.background, Vec3f(behind.data[0], behind.data[1], behind.data[2]),
                  shown.target);
  return shown;
}

TrainStep Trainer::step() {
  const auto begin = std::chrono::steady_clock::now();
  const double before = training_progress(options_, state_.iteration, state_.seconds);
  raise_sh_degree(state_, std::max(state_.cloud.sh_degree, sh_degree_at(options_, before)));
  const Shown shown = show(before);

  const int channels = state_.attribute_channels();
  RenderOptions how = options_.render;
  how.background = shown.backdrop;
  RenderTape<float> tape;
  const RenderResult picture = render(state_.cloud, shown.camera, how, state_.attribute, channels, &tape);
  RenderResult adj;
  TrainStep report;
  std::vector<float> adj_exposure, adj_shared(state_.shared.size(), 0.0f), adj_attribute(state_.attribute.size(), 0.0f);
  if (options_.exposure) {
    const float* exposure = state_.exposure.data() + shown.photo * kExposureSize;
    adj_exposure.assign(kExposureSize, 0.0f);
    const ImageF exposed = expose(picture.color, exposure);
    report.loss = photometric_loss_adjoint(options_.loss, exposed, shown.target, shown.weight, 1.0, adj.color).total;
    expose_adjoint(picture.color, exposure, adj.color, adj_exposure.data());
  } else {
    report.loss =
        photometric_loss_adjoint(options_.loss, picture.color, shown.target, shown.weight, 1.0, adj.color).total;
  }
  if (term_) {
    adj.features = ImageF(shown.camera.width, shown.camera.height, channels, 0.0f);
    report.term = term_->adjoint(
        {state_.iteration, before, shown.photo, state_.cloud, state_.attribute, state_.shared, picture.features},
        {adj.features, adj_attribute, adj_shared});
  }
  const bool classic = options_.densification == Densification::kClassic;
  RenderGradient<float> gradient = render_adjoint(state_.cloud, shown.camera, how, state_.attribute, channels, picture,
                                                  adj, &tape, {.screen = classic && before < options_.grow_until});
  for (size_t k = 0; k < adj_attribute.size(); ++k) gradient.features[k] += adj_attribute[k];
  optimise(shown, before, gradient, adj_exposure, adj_shared);

  ++state_.iteration;
  state_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report.progress = training_progress(options_, state_.iteration, state_.seconds);
  // Time that passed since the last step may have led over a mark.
  densify(densified_at_ < 0 ? before : densified_at_, report.progress);
  densified_at_ = report.progress;
  report.iteration = state_.iteration;
  report.gaussians = state_.cloud.size();
  report.width = shown.camera.width;
  report.height = shown.camera.height;
  return report;
}

void Trainer::optimise(const Shown& shown, double progress, RenderGradient<float>& gradient,
                       std::span<const float> adj_exposure, std::span<const float> adj_shared) {
  const bool mcmc = options_.densification == Densification::kMcmc;
  if (mcmc) add_mcmc_regularisers(options_, static_cast<float>(extent_), state_.cloud, gradient.cloud);
  const long step = state_.iteration + 1;
  const float position =
      exponential_rate(options_.position_rate, options_.final_position_rate, progress) * static_cast<float>(extent_);
  const auto uniform = [](size_t width, float rate) { return std::vector<float>(width, rate); };
  GaussianCloud& cloud = state_.cloud;
  adam_rows(flat(cloud.position), flat(gradient.cloud.position), uniform(3, position), step, state_.position);
  adam_rows(flat(cloud.rotation), flat(gradient.cloud.rotation), uniform(4, options_.rotation_rate), step,
            state_.rotation);
  adam_rows(flat(cloud.log_scale), flat(gradient.cloud.log_scale), uniform(3, options_.scale_rate), step,
            state_.log_scale);
  adam_rows(cloud.opacity_logit, gradient.cloud.opacity_logit, uniform(1, options_.opacity_rate), step,
            state_.opacity_logit);
  std::vector<float> color = uniform(3 * cloud.sh_count(), options_.color_rate / 20);
  std::fill_n(color.begin(), 3, options_.color_rate);
  adam_rows(cloud.sh, gradient.cloud.sh, color, step, state_.sh);
  if (term_) {
    adam_rows(state_.attribute, gradient.features, uniform(state_.attribute_channels(), term_->attribute_rate()), step,
              state_.attribute_moments);
    adam_rows(state_.shared, adj_shared, uniform(1, term_->shared_rate()), step, state_.shared_moments);
  }
  if (options_.exposure) {
    expose_better(shown.photo, exponential_rate(options_.exposure_rate, options_.final_exposure_rate, progress),
                  adj_exposure);
  }
  if (mcmc && progress < options_.relocate_until) explore(options_, position, static_cast<float>(extent_), state_);
  if (!gradient.screen.empty())
    gather_screen_gradient(gradient.screen, shown.camera.width, shown.camera.height, state_);
}

void Trainer::expose_better(int photo, float rate, std::span<const float> adj_exposure) {
  // Photos that are not shown keep their exposure: only the row of this one moves.
  const size_t row = photo * kExposureSize;
  Moments& all = state_.exposure_moments;
  Moments of_photo{{all.first.begin() + row, all.first.begin() + row + kExposureSize},
                   {all.second.begin() + row, all.second.begin() + row + kExposureSize}};
  const long shows = state_.iteration / static_cast<long>(trained_on_.size()) + 1;
  adam_rows(std::span(state_.exposure).subspan(row, kExposureSize), adj_exposure,
            std::vector<float>(kExposureSize, rate), shows, of_photo);
  std::copy(of_photo.first.begin(), of_photo.first.end(), all.first.begin() + row);
  std::copy(of_photo.second.begin(), of_photo.second.end(), all.second.begin() + row);
  // Scene and exposures could brighten and darken together; the mean exposure stays neutral.
  for (int k = 0; k < kExposureSize; ++k) {
    float mean = 0;
    for (int i : trained_on_) mean += state_.exposure[i * kExposureSize + k] / trained_on_.size();
    for (int i : trained_on_) state_.exposure[i * kExposureSize + k] += kNeutralExposure[k] - mean;
  }
}

void Trainer::densify(double before, double progress) {
  if (before < options_.refine_from || state_.cloud.size() == 0) return;
  const bool due = state_.iteration % options_.refine_every == 0;
  if (options_.densification == Densification::kMcmc && due && progress < options_.relocate_until) {
    relocate_and_grow(
        options_, std::max(state_.cloud.size(), planned_gaussians(options_, state_.started_with, budget_, progress)),
        state_);
  }
  if (options_.densification == Densification::kClassic && progress < options_.grow_until) {
    if (due) clone_split_prune(options_, static_cast<float>(extent_), budget_, state_);
    if (passes(before, progress, options_.grow_until / (options_.resets + 1))) reset_opacities(state_);
  }
}

void Trainer::measure() {
  const std::vector<PhotoQuality> quality = held_out_quality(state_.cloud, photos_, options_.render, kMostInCurve);
  if (quality.empty()) return;
  CurvePoint point{state_.iteration, state_.seconds, state_.cloud.size(), 0, 0};
  for (const PhotoQuality& q : quality) {
    point.psnr += q.psnr / quality.size();
    point.ssim += q.ssim / quality.size();
  }
  state_.curve.push_back(point);
}

}  // namespace pliant
