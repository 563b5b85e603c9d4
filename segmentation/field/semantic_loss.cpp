#include "segmentation/field/semantic_loss.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr int kY = kSemanticChannels;

template <class T>
using Attribute = Eigen::Array<T, kY, 1>;

/// log softmax(classifier * s + bias) into out [C].
template <class T>
void log_softmax(const SemanticModel<T>& model, const T* s, T* out) {
  const Eigen::Map<const Attribute<T>> x(s);
  T largest = -INFINITY;
  for (int c = 0; c < model.classes; ++c) {
    out[c] = model.bias[c] + (x * Eigen::Map<const Attribute<T>>(model.classifier.data() + c * kY)).sum();
    largest = std::max(largest, out[c]);
  }
  T sum = 0;
  for (int c = 0; c < model.classes; ++c) sum += std::exp(out[c] - largest);
  const T shift = largest + std::log(sum);
  for (int c = 0; c < model.classes; ++c) out[c] -= shift;
}

/// ds = classifier^T dlogits.
template <class T>
Attribute<T> pull_back(const SemanticModel<T>& model, const T* dlogits) {
  Attribute<T> ds = Attribute<T>::Zero();
  for (int c = 0; c < model.classes; ++c)
    ds += dlogits[c] * Eigen::Map<const Attribute<T>>(model.classifier.data() + c * kY);
  return ds;
}

/// Adds dlogits s^T and dlogits to the classifier's gradient.
template <class T>
void add_outer(const T* dlogits, const T* s, int classes, T* classifier, T* bias) {
  const Eigen::Map<const Attribute<T>> x(s);
  for (int c = 0; c < classes; ++c) {
    Eigen::Map<Attribute<T>>(classifier + c * kY) += dlogits[c] * x;
    bias[c] += dlogits[c];
  }
}

double log_classes(int classes) { return classes > 1 ? std::log(static_cast<double>(classes)) : 1.0; }

/// Cross entropy of blended attributes S [rows, 16]; with `gradient` also dL/dS and what the classifier gets.
template <class T>
T blended_cross_entropy(std::span<const T> S, std::span<const int> target, const SemanticModel<T>& model,
                        std::span<T> dS, SemanticModel<T>* gradient) {
  CHECK(S.size() == target.size() * kY);
  const int C = model.classes;
  const std::ptrdiff_t rows = static_cast<std::ptrdiff_t>(target.size());
  const std::ptrdiff_t labelled = std::count_if(target.begin(), target.end(), [](int c) { return c >= 0; });
  if (labelled == 0) return T(0);
  const T scale = T(1 / (static_cast<double>(labelled) * log_classes(C)));

  // Fixed blocks of rows; their sums are added in order.
  constexpr std::ptrdiff_t kBlock = 1024;
  const std::ptrdiff_t blocks = (rows + kBlock - 1) / kBlock;
  std::vector<T> loss(blocks, T(0));
  std::vector<SemanticModel<T>> partial(gradient ? blocks : 0);
  parallel_for(blocks, [&](std::ptrdiff_t b) {
    std::vector<T> logits(C);
    if (gradient) partial[b].resize(0, C);
    for (std::ptrdiff_t r = b * kBlock; r < std::min(rows, (b + 1) * kBlock); ++r) {
      if (target[r] < 0) continue;
      const T* s = S.data() + r * kY;
      log_softmax(model, s, logits.data());
      loss[b] -= logits[target[r]] * scale;
      if (!gradient) continue;
      for (int c = 0; c < C; ++c) logits[c] = (std::exp(logits[c]) - (c == target[r] ? T(1) : T(0))) * scale;
      Eigen::Map<Attribute<T>>(dS.data() + r * kY) = pull_back(model, logits.data());
      add_outer(logits.data(), s, C, partial[b].classifier.data(), partial[b].bias.data());
    }
  });
  T total = 0;
  for (T value : loss) total += value;
  if (!gradient) return total;
  for (const SemanticModel<T>& part : partial) {
    for (size_t i = 0; i < part.classifier.size(); ++i) gradient->classifier[i] += part.classifier[i];
    for (int c = 0; c < C; ++c) gradient->bias[c] += part.bias[c];
  }
  return total;
}

template <class T, class Weight>
T cross_entropy(const SparseView<Weight>& W, std::span<const int> target, const SemanticModel<T>& model,
                SemanticModel<T>* gradient) {
  std::vector<T> S, dS(gradient ? W.rows() * kY : 0, T(0));
  multiply<T>(W, model.attribute, S);
  const T total = blended_cross_entropy<T>(S, target, model, dS, gradient);
  if (gradient) multiply_transposed<T>(W, dS, gradient->attribute);
  return total;
}

template <class T>
T grouping(std::span<const int> anchors, std::span<const int> neighbours, int k, T weight,
           const SemanticModel<T>& model, SemanticModel<T>* gradient) {
  const int C = model.classes;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(anchors.size());
  auto neighbour = [&](std::ptrdiff_t a, int j) { return neighbours[static_cast<size_t>(anchors[a]) * k + j]; };
  std::ptrdiff_t pairs = 0;
  for (std::ptrdiff_t a = 0; a < n; ++a)
    for (int j = 0; j < k; ++j) pairs += neighbour(a, j) >= 0;
  if (pairs == 0) return T(0);
  const T scale = weight / (static_cast<T>(pairs) * static_cast<T>(C));

  // Each anchor writes the logit derivatives of itself and of its neighbours to a place of its own.
  const size_t stride = static_cast<size_t>(k + 1) * C;
  std::vector<T> loss(n, T(0)), dlogits(gradient ? n * stride : 0, T(0));
  parallel_for(
      n,
      [&](std::ptrdiff_t a) {
        std::vector<T> log_p(C), log_q(C);
        log_softmax(model, model.attribute.data() + static_cast<size_t>(anchors[a]) * kY, log_p.data());
        for (int j = 0; j < k; ++j) {
          if (neighbour(a, j) < 0) continue;
          log_softmax(model, model.attribute.data() + static_cast<size_t>(neighbour(a, j)) * kY, log_q.data());
          T kl = 0;
          for (int c = 0; c < C; ++c) kl += std::exp(log_p[c]) * (log_p[c] - log_q[c]);
          loss[a] += kl * scale;
          if (!gradient) continue;
          T *dp = dlogits.data() + a * stride, *dq = dp + (j + 1) * C;
          for (int c = 0; c < C; ++c) {
            const T p = std::exp(log_p[c]);
            dp[c] += scale * p * (log_p[c] - log_q[c] - kl);
            dq[c] = scale * (std::exp(log_q[c]) - p);
          }
        }
      },
      16);
  T total = 0;
  for (T value : loss) total += value;
  if (!gradient) return total;
  for (std::ptrdiff_t a = 0; a < n; ++a) {
    for (int j = 0; j <= k; ++j) {
      const int p = j == 0 ? anchors[a] : neighbour(a, j - 1);
      if (p < 0) continue;
      const T* d = dlogits.data() + a * stride + j * C;
      Eigen::Map<Attribute<T>>(gradient->attribute.data() + static_cast<size_t>(p) * kY) += pull_back(model, d);
      add_outer(d, model.attribute.data() + static_cast<size_t>(p) * kY, C, gradient->classifier.data(),
                gradient->bias.data());
    }
  }
  return total;
}

}  // namespace

template <class T>
void SemanticModel<T>::resize(size_t gaussians, int class_count) {
  classes = class_count;
  attribute.assign(gaussians * kY, T(0));
  classifier.assign(static_cast<size_t>(classes) * kY, T(0));
  bias.assign(classes, T(0));
}

template <class T>
void SemanticModel<T>::set_zero() {
  std::fill(attribute.begin(), attribute.end(), T(0));
  std::fill(classifier.begin(), classifier.end(), T(0));
  std::fill(bias.begin(), bias.end(), T(0));
}

template <class T>
void class_softmax(const SemanticModel<T>& model, const T* s, T* probability) {
  log_softmax(model, s, probability);
  for (int c = 0; c < model.classes; ++c) probability[c] = std::exp(probability[c]);
}

template <class T, class Weight>
T semantic_loss(const SparseView<Weight>& W, std::span<const int> target, const SemanticModel<T>& model) {
  return cross_entropy<T, Weight>(W, target, model, nullptr);
}

template <class T, class Weight>
T semantic_loss_adjoint(const SparseView<Weight>& W, std::span<const int> target, const SemanticModel<T>& model,
                        SemanticModel<T>& gradient) {
  return cross_entropy<T, Weight>(W, target, model, &gradient);
}

template <class T>
T blended_semantic_loss_adjoint(std::span<const T> S, std::span<const int> target, const SemanticModel<T>& model,
                                std::span<T> adj_S, SemanticModel<T>& gradient) {
  CHECK(adj_S.size() == S.size());
  return blended_cross_entropy<T>(S, target, model, adj_S, &gradient);
}

template <class T>
T grouping_loss(std::span<const int> anchors, std::span<const int> neighbours, int k, T weight,
                const SemanticModel<T>& model) {
  return grouping<T>(anchors, neighbours, k, weight, model, nullptr);
}

template <class T>
T grouping_loss_adjoint(std::span<const int> anchors, std::span<const int> neighbours, int k, T weight,
                        const SemanticModel<T>& model, SemanticModel<T>& gradient) {
  return grouping<T>(anchors, neighbours, k, weight, model, &gradient);
}

#define PLIANT_INSTANTIATE(T, Weight)                                                                           \
  template T semantic_loss(const SparseView<Weight>&, std::span<const int>, const SemanticModel<T>&);           \
  template T semantic_loss_adjoint(const SparseView<Weight>&, std::span<const int>, const SemanticModel<T>&,    \
                                   SemanticModel<T>&);                                                          \
  template T blended_semantic_loss_adjoint(std::span<const T>, std::span<const int>, const SemanticModel<T>&,   \
                                           std::span<T>, SemanticModel<T>&);                                    \
  template struct SemanticModel<T>;                                                                             \
  template void class_softmax(const SemanticModel<T>&, const T*, T*);                                           \
  template T grouping_loss(std::span<const int>, std::span<const int>, int, T, const SemanticModel<T>&);        \
  template T grouping_loss_adjoint(std::span<const int>, std::span<const int>, int, T, const SemanticModel<T>&, \
                                   SemanticModel<T>&);
PLIANT_INSTANTIATE(float, uint16_t)
PLIANT_INSTANTIATE(double, double)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
