#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "segmentation/labels/sparse_view.h"

namespace pliant {

/// What is optimised: attributes y and the classifier that all views share.  The same shape holds the gradient.
template <class T>
struct SemanticModel {
  int classes = 0;
  std::vector<T> attribute;   ///< y [N, 16]
  std::vector<T> classifier;  ///< [C, 16]
  std::vector<T> bias;        ///< [C]

  void resize(size_t gaussians, int class_count);
  void set_zero();
};

/// Class probabilities [C] of one blended or per-Gaussian attribute: softmax(classifier * s + bias).
template <class T>
void class_softmax(const SemanticModel<T>& model, const T* s, T* probability);

/// Cross entropy between softmax(classifier * (W y) + bias) and the class of each row (-1 = unlabelled, left out),
/// averaged over labelled rows and divided by ln C (Sim Anything supplement, eq. 1; Ye et al. 2024, eq. 4).
template <class T, class Weight>
T semantic_loss(const SparseView<Weight>& W, std::span<const int> target, const SemanticModel<T>& model);

/// The same value; adds its derivatives with respect to y, classifier and bias to `gradient`:
/// dL/dy = W^T ((softmax - onehot) classifier) / (n ln C).
template <class T, class Weight>
T semantic_loss_adjoint(const SparseView<Weight>& W, std::span<const int> target, const SemanticModel<T>& model,
                        SemanticModel<T>& gradient);

/// The same loss of attributes S [rows, 16] that are blended already; writes dL/dS [rows, 16] where there is a class
/// and adds the derivatives of classifier and bias.
template <class T>
T blended_semantic_loss_adjoint(std::span<const T> S, std::span<const int> target, const SemanticModel<T>& model,
                                std::span<T> adj_S, SemanticModel<T>& gradient);

/// Grouping term (Ye et al. 2024, eq. 5): weight / C times the mean over anchors and their neighbours of
/// KL(P_anchor || P_neighbour) between class distributions.  `neighbours` [N, k] holds -1 where there are fewer.
template <class T>
T grouping_loss(std::span<const int> anchors, std::span<const int> neighbours, int k, T weight,
                const SemanticModel<T>& model);

/// The same value; adds its derivatives, through the anchors and through the neighbours, to `gradient`.
template <class T>
T grouping_loss_adjoint(std::span<const int> anchors, std::span<const int> neighbours, int k, T weight,
                        const SemanticModel<T>& model, SemanticModel<T>& gradient);

}  // namespace pliant
