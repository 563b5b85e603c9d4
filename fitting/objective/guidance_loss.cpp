#include "fitting/objective/guidance_loss.h"

#include <algorithm>

namespace pliant {

GuidanceResult GuidanceLoss::ask(std::span<const SimulationState> frames) const {
  std::vector<ImageF> pictures;
  for (size_t f = frames_.lead; f < frames.size(); f += frames_.every) {
    pictures.push_back(picture_of(*object_, camera_, frames[f]));
    for (float& value : pictures.back().data) value = std::clamp(value, 0.0f, 1.0f);
  }
  const int step = guide_->next_step();
  GuidanceResult result = guide_->evaluate(pictures, frames_.fps, step);
  if (!frames_.against_still) return result;
  const GuidanceResult still =
      guide_->evaluate(std::vector<ImageF>(pictures.size(), pictures.front()), frames_.fps, step);
  result.loss -= still.loss;
  for (size_t k = 0; k < pictures.size(); ++k)
    for (size_t i = 0; i < result.gradient[k].data.size(); ++i) result.gradient[k].data[i] -= still.gradient[k].data[i];
  return result;
}

double GuidanceLoss::value(std::span<const SimulationState> frames) const { return ask(frames).loss; }

double GuidanceLoss::value_adjoint(std::span<const SimulationState> frames, double adj_value,
                                   std::span<StateGradient<float>> gradient) const {
  const GuidanceResult result = ask(frames);
  for (size_t k = 0; k < result.gradient.size(); ++k) {
    const size_t f = frames_.lead + k * frames_.every;
    picture_adjoint<float>(
        *object_, camera_, frames[f],
        [&](const ImageF& picture) {
          ImageF adj = result.gradient[k];
          // What is clamped does not change with the picture.
          for (size_t i = 0; i < adj.data.size(); ++i)
            adj.data[i] *= picture.data[i] < 0 || picture.data[i] > 1 ? 0.0f : static_cast<float>(adj_value);
          return adj;
        },
        gradient[f]);
  }
  return result.loss;
}

}  // namespace pliant
