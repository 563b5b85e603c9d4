#include "gaussians/reconstruct/training_state.h"

#include <algorithm>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// Elements of `array` that belong to one of n Gaussians.
template <class Array>
size_t row_width(const Array& array, size_t n) {
  CHECK(n > 0 && array.size() % n == 0);
  return array.size() / n;
}

std::vector<float> with_more_coefficients(const std::vector<float>& rows, size_t n, size_t before, size_t after) {
  std::vector<float> out(n * after, 0.0f);
  for (size_t i = 0; i < n; ++i) std::copy_n(rows.data() + i * before, before, out.data() + i * after);
  return out;
}

}  // namespace

void fit_moments(TrainingState& s) {
  s.position.resize(3 * s.cloud.size());
  s.rotation.resize(4 * s.cloud.size());
  s.log_scale.resize(3 * s.cloud.size());
  s.opacity_logit.resize(s.cloud.size());
  s.sh.resize(s.cloud.sh.size());
  s.attribute_moments.resize(s.attribute.size());
  s.shared_moments.resize(s.shared.size());
  s.exposure_moments.resize(s.exposure.size());
}

void keep_gaussians(TrainingState& state, std::span<const int> indices) {
  const size_t n = state.cloud.size();
  visit_gaussian_arrays(state, [&](const std::string&, auto& array) {
    if (array.empty()) return;
    const size_t width = row_width(array, n);
    std::remove_reference_t<decltype(array)> kept(indices.size() * width);
    for (size_t k = 0; k < indices.size(); ++k)
      std::copy_n(array.begin() + indices[k] * width, width, kept.begin() + k * width);
    array = std::move(kept);
  });
}

void copy_gaussian(TrainingState& state, size_t from, size_t to) {
  const size_t n = state.cloud.size();
  visit_gaussian_arrays(state, [&](const std::string&, auto& array) {
    if (array.empty()) return;
    const size_t width = row_width(array, n);
    std::copy_n(array.begin() + from * width, width, array.begin() + to * width);
  });
}

void clear_moments(TrainingState& state, size_t i) {
  const size_t n = state.cloud.size();
  for (Moments* of : {&state.position, &state.rotation, &state.log_scale, &state.opacity_logit, &state.sh,
                      &state.attribute_moments}) {
    if (of->first.empty()) continue;
    const size_t width = row_width(of->first, n);
    std::fill_n(of->first.begin() + i * width, width, 0.0f);
    std::fill_n(of->second.begin() + i * width, width, 0.0f);
  }
}

void raise_sh_degree(TrainingState& state, int degree) {
  const size_t n = state.cloud.size(), before = 3 * state.cloud.sh_count();
  CHECK(degree >= state.cloud.sh_degree && degree <= 3);
  state.cloud.sh_degree = degree;
  const size_t after = 3 * state.cloud.sh_count();
  if (after == before) return;
  for (std::vector<float>* rows : {&state.cloud.sh, &state.sh.first, &state.sh.second})
    *rows = with_more_coefficients(*rows, n, before, after);
}

}  // namespace pliant
