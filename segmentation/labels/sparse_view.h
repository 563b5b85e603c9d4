#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/blend_weights.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// The matrix W of one view for chosen pixels ("rows"), stored twice: by rows for S = W y and by columns for
/// dL/dy = W^T dL/dS, so that every sum has one owner and the result does not depend on threads.
template <class Weight>
struct SparseView {
  double unit = 1;                     ///< what a stored weight of 1 stands for
  std::vector<uint32_t> row_start;     ///< [rows + 1]
  std::vector<uint32_t> gaussian;      ///< [entries]
  std::vector<Weight> weight;          ///< [entries]
  std::vector<uint32_t> column;        ///< Gaussians with an entry, ascending
  std::vector<uint32_t> column_start;  ///< [columns + 1]
  std::vector<uint32_t> row;           ///< [entries] rows of a column, ascending
  std::vector<Weight> column_weight;   ///< [entries]

  size_t rows() const { return row_start.empty() ? 0 : row_start.size() - 1; }
  size_t bytes() const {
    return weight.size() * 2 * (sizeof(uint32_t) + sizeof(Weight)) +
           (row_start.size() + 2 * column.size()) * sizeof(uint32_t);
  }

  /// Fills the columns from the rows.
  void index_columns(size_t gaussians) {
    std::vector<uint32_t> count(gaussians + 1, 0);
    for (uint32_t p : gaussian) ++count[p];
    column.clear();
    column_start.assign(1, 0);
    for (size_t p = 0; p < gaussians; ++p) {
      if (count[p] == 0) continue;
      column.push_back(static_cast<uint32_t>(p));
      const uint32_t begin = column_start.back();
      column_start.push_back(begin + count[p]);
      count[p] = begin;  // next free place of this column
    }
    row.resize(gaussian.size());
    column_weight.resize(gaussian.size());
    for (uint32_t r = 0; r < rows(); ++r)
      for (uint32_t e = row_start[r]; e < row_start[r + 1]; ++e) {
        const uint32_t place = count[gaussian[e]]++;
        row[place] = r;
        column_weight[place] = weight[e];
      }
  }
};

/// 16-bit fixed point: weights lie in [0, 1), the error is at most 7.7e-6.
using CompactView = SparseView<uint16_t>;

/// Rows of `weights` for the given pixels, in 16-bit fixed point.
CompactView compact_view(const BlendWeights& weights, std::span<const uint32_t> pixels, size_t gaussians);

/// S [rows, 16] = W y.
template <class T, class Weight>
void multiply(const SparseView<Weight>& W, std::span<const T> y, std::vector<T>& S) {
  using Row = Eigen::Array<T, kSemanticChannels, 1>;
  S.resize(W.rows() * kSemanticChannels);
  parallel_for(
      static_cast<std::ptrdiff_t>(W.rows()),
      [&](std::ptrdiff_t r) {
        Row sum = Row::Zero();
        for (uint32_t e = W.row_start[r]; e < W.row_start[r + 1]; ++e)
          sum +=
              static_cast<T>(W.weight[e]) * Eigen::Map<const Row>(y.data() + size_t(W.gaussian[e]) * kSemanticChannels);
        Eigen::Map<Row>(S.data() + r * kSemanticChannels) = sum * static_cast<T>(W.unit);
      },
      512);
}

/// dy [N, 16] += W^T dS.
template <class T, class Weight>
void multiply_transposed(const SparseView<Weight>& W, std::span<const T> dS, std::span<T> dy) {
  using Row = Eigen::Array<T, kSemanticChannels, 1>;
  parallel_for(
      static_cast<std::ptrdiff_t>(W.column.size()),
      [&](std::ptrdiff_t k) {
        Row sum = Row::Zero();
        for (uint32_t e = W.column_start[k]; e < W.column_start[k + 1]; ++e)
          sum += static_cast<T>(W.column_weight[e]) *
                 Eigen::Map<const Row>(dS.data() + size_t(W.row[e]) * kSemanticChannels);
        Eigen::Map<Row>(dy.data() + size_t(W.column[k]) * kSemanticChannels) += sum * static_cast<T>(W.unit);
      },
      256);
}

}  // namespace pliant
