#pragma once

#include <hdf5.h>

#include <cstdint>
#include <type_traits>
#include <vector>

#include "app/store/hdf5_file.h"

namespace pliant {

/// How a file stores values of a type, and the words for it.
struct Hdf5Type {
  hid_t id;
  const char* name;
};
template <class T>
Hdf5Type hdf5_type() {
  if constexpr (std::is_same_v<T, float>) {
    return {H5T_NATIVE_FLOAT, "32-bit float"};
  } else if constexpr (std::is_same_v<T, double>) {
    return {H5T_NATIVE_DOUBLE, "64-bit float"};
  } else if constexpr (std::is_same_v<T, int32_t>) {
    return {H5T_NATIVE_INT32, "32-bit integer"};
  } else if constexpr (std::is_same_v<T, uint32_t>) {
    return {H5T_NATIVE_UINT32, "unsigned 32-bit integer"};
  } else if constexpr (std::is_same_v<T, int64_t>) {
    return {H5T_NATIVE_INT64, "64-bit integer"};
  } else {
    static_assert(std::is_same_v<T, uint8_t>);
    return {H5T_NATIVE_UINT8, "unsigned 8-bit integer"};
  }
}

/// Our messages replace the error stack that HDF5 would print.  Files are closed by their handles: its own way to close
/// what is open at the end of the program crashes on a file that a full disk kept from being closed.
inline void silence_hdf5() {
  [[maybe_unused]] static const herr_t never_at_exit = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// Extent of a dataset or an attribute; that of a single value for no dimensions.
inline Hdf5Handle hdf5_space(const Shape& shape) {
  const std::vector<hsize_t> dims(shape.begin(), shape.end());
  return {shape.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
          H5Sclose};
}

/// Text of any length, in UTF-8.
inline Hdf5Handle hdf5_string_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose};
}

/// Selects slab `index` of a dataset's space.
inline void select_hdf5_slab(hid_t space, const Shape& shape, size_t index) {
  std::vector<hsize_t> start(shape.size(), 0), count(shape.begin(), shape.end());
  start[0] = index;
  count[0] = 1;
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
}

/// Extent of one slab.
inline Shape slab_shape(Shape shape) {
  shape[0] = 1;
  return shape;
}

/// Numbers that datasets are read and written as.
#define PLIANT_FOR_HDF5_TYPES(apply) \
  apply(float) apply(double) apply(int32_t) apply(uint32_t) apply(int64_t) apply(uint8_t)

}  // namespace pliant
