#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "app/store/hdf5_file.h"
#include "gaussians/base/error.h"
#include "gaussians/base/types.h"

namespace pliant {

inline void write_vectors(Hdf5Writer& out, const std::string& name, const std::vector<Vec3f>& values) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  out.dataset(name, values.empty() ? nullptr : values.data()->data(), {values.size(), 3});
}

/// A dataset [count, 3] of finite floats.
inline std::vector<Vec3f> read_vectors(const Hdf5Reader& in, const std::string& name, size_t count = kAny) {
  const std::vector<float> flat = in.dataset<float>(name, {count, 3});
  std::vector<Vec3f> values(flat.size() / 3);
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = Vec3f(flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]);
    if (!values[i].allFinite())
      throw in.complaint(name, "holds a value that is not finite in row " + std::to_string(i));
  }
  return values;
}

/// Rows first.
inline void write_matrices(Hdf5Writer& out, const std::string& name, const std::vector<Mat3f>& matrices) {
  std::vector<float> rows;
  for (const Mat3f& M : matrices)
    for (int k = 0; k < 9; ++k) rows.push_back(M(k / 3, k % 3));
  out.dataset(name, rows.data(), {matrices.size(), 3, 3});
}

/// A dataset [count, 3, 3] of finite floats.
inline std::vector<Mat3f> read_matrices(const Hdf5Reader& in, const std::string& name, size_t count) {
  const std::vector<float> rows = in.dataset<float>(name, {count, 3, 3});
  std::vector<Mat3f> matrices(count);
  for (size_t i = 0; i < count; ++i) {
    for (int k = 0; k < 9; ++k) matrices[i](k / 3, k % 3) = rows[9 * i + k];
    if (!matrices[i].allFinite())
      throw in.complaint(name, "holds a value that is not finite in row " + std::to_string(i));
  }
  return matrices;
}

/// A dataset [count] of finite floats.
inline std::vector<float> read_finite(const Hdf5Reader& in, const std::string& name, size_t count) {
  std::vector<float> values = in.dataset<float>(name, {count});
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i]))
      throw in.complaint(name, "holds a value that is not finite in row " + std::to_string(i));
  }
  return values;
}

}  // namespace pliant
