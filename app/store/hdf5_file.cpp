#include "app/store/hdf5_file.h"

#include <hdf5.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

template <class T>
hid_t native_type();
template <>
hid_t native_type<float>() {
  return H5T_NATIVE_FLOAT;
}
template <>
hid_t native_type<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
hid_t native_type<int32_t>() {
  return H5T_NATIVE_INT32;
}
template <>
hid_t native_type<uint32_t>() {
  return H5T_NATIVE_UINT32;
}
template <>
hid_t native_type<int64_t>() {
  return H5T_NATIVE_INT64;
}
template <>
hid_t native_type<uint8_t>() {
  return H5T_NATIVE_UINT8;
}

template <class T>
const char* type_name();
template <>
const char* type_name<float>() {
  return "32-bit float";
}
template <>
const char* type_name<double>() {
  return "64-bit float";
}
template <>
const char* type_name<int32_t>() {
  return "32-bit integer";
}
template <>
const char* type_name<uint32_t>() {
  return "unsigned 32-bit integer";
}
template <>
const char* type_name<int64_t>() {
  return "64-bit integer";
}
template <>
const char* type_name<uint8_t>() {
  return "unsigned 8-bit integer";
}

/// Our messages replace the error stack that HDF5 would print.  Files are closed by their handles: its own way to close
/// what is open at the end of the program crashes on a file that a full disk kept from being closed.
void silence() {
  [[maybe_unused]] static const herr_t never_at_exit = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Hdf5Handle space_of(const Shape& shape) {
  const std::vector<hsize_t> dims(shape.begin(), shape.end());
  return {shape.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
          H5Sclose};
}

Hdf5Handle string_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose};
}

std::string text_of(const Shape& shape) {
  std::string text = "[";
  for (size_t n : shape) text += (text.size() > 1 ? ", " : "") + (n == kAny ? std::string("any") : std::to_string(n));
  return text + "]";
}

/// Selects slab `index` of a dataset's space.
void select_slab(hid_t space, const Shape& shape, size_t index) {
  std::vector<hsize_t> start(shape.size(), 0), count(shape.begin(), shape.end());
  start[0] = index;
  count[0] = 1;
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
}

Shape slab_shape(Shape shape) {
  shape[0] = 1;
  return shape;
}

}  // namespace

Hdf5Writer::Hdf5Writer(const fs::path& file) : file_(file.string()) {
  silence();
  const Hdf5Handle properties(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  id_ = Hdf5Handle(H5Fcreate(file_.c_str(), H5F_ACC_TRUNC, properties.get(), H5P_DEFAULT), H5Fclose);
  if (!id_.valid()) fail("the file");
}

void Hdf5Writer::fail(const std::string& name) const {
  throw input_error(file_, name, "cannot be written", "check permissions and free space");
}

void Hdf5Writer::close() {
  if (H5Fflush(id_.get(), H5F_SCOPE_GLOBAL) < 0 || !id_.reset()) fail("the file");
}

void Hdf5Writer::group(const std::string& name) {
  const Hdf5Handle properties(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  const Hdf5Handle group(H5Gcreate2(id_.get(), name.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Gclose);
  if (!group.valid()) fail(name);
}

template <class T>
void Hdf5Writer::dataset(const std::string& name, const T* data, const Shape& shape) {
  const Hdf5Handle space = space_of(shape), properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  const Hdf5Handle set(
      H5Dcreate2(id_.get(), name.c_str(), native_type<T>(), space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      H5Dclose);
  if (!set.valid()) fail(name);
  if (std::find(shape.begin(), shape.end(), size_t{0}) != shape.end()) return;
  if (H5Dwrite(set.get(), native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) fail(name);
}

template <class T>
void Hdf5Writer::slabs(const std::string& name, const Shape& shape, const std::function<const T*(size_t)>& slab) {
  if (std::find(shape.begin(), shape.end(), size_t{0}) != shape.end()) return dataset<T>(name, nullptr, shape);
  const Hdf5Handle space = space_of(shape), part = space_of(slab_shape(shape));
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  const Shape chunk_shape = slab_shape(shape);
  const std::vector<hsize_t> chunk(chunk_shape.begin(), chunk_shape.end());
  H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
  H5Pset_deflate(properties.get(), 1);
  const Hdf5Handle set(
      H5Dcreate2(id_.get(), name.c_str(), native_type<T>(), space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      H5Dclose);
  if (!set.valid()) fail(name);
  for (size_t i = 0; i < shape[0]; ++i) {
    select_slab(space.get(), shape, i);
    if (H5Dwrite(set.get(), native_type<T>(), part.get(), space.get(), H5P_DEFAULT, slab(i)) < 0) fail(name);
  }
}

void Hdf5Writer::link(const std::string& existing, const std::string& name) {
  if (H5Lcreate_hard(id_.get(), existing.c_str(), id_.get(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0) fail(name);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, int64_t type, int64_t space,
                           const void* data) {
  const Hdf5Handle owner(H5Oopen(id_.get(), object.c_str(), H5P_DEFAULT), H5Oclose);
  const Hdf5Handle attribute(H5Acreate2(owner.get(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.valid() || H5Awrite(attribute.get(), type, data) < 0) fail(object + "@" + name);
}

void Hdf5Writer::strings(const std::string& object, const std::string& name, const std::vector<std::string>& values,
                         bool scalar) {
  const Hdf5Handle type = string_type(), space = space_of(scalar ? Shape() : Shape{values.size()});
  std::vector<const char*> pointers;
  for (const std::string& value : values) pointers.push_back(value.c_str());
  attribute(object, name, type.get(), space.get(), pointers.data());
}

void Hdf5Writer::text(const std::string& object, const std::string& name, const std::string& value) {
  strings(object, name, {value}, true);
}

void Hdf5Writer::texts(const std::string& object, const std::string& name, const std::vector<std::string>& values) {
  strings(object, name, values, false);
}

void Hdf5Writer::number(const std::string& object, const std::string& name, double value) {
  attribute(object, name, H5T_NATIVE_DOUBLE, space_of({}).get(), &value);
}

void Hdf5Writer::numbers(const std::string& object, const std::string& name, const std::vector<double>& values) {
  attribute(object, name, H5T_NATIVE_DOUBLE, space_of({values.size()}).get(), values.data());
}

void Hdf5Writer::integers(const std::string& object, const std::string& name, const std::vector<int32_t>& values) {
  attribute(object, name, H5T_NATIVE_INT32, space_of({values.size()}).get(), values.data());
}

void write_hdf5(const fs::path& file, const std::function<void(Hdf5Writer&)>& body) {
  write_atomically(file, [&](const fs::path& temporary) {
    Hdf5Writer writer(temporary);
    body(writer);
    writer.close();
  });
}

Hdf5Reader::Hdf5Reader(const fs::path& file) : file_(file.string()) {
  silence();
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw input_error(file_, "", "does not exist", "check the name");
  if (!fs::is_regular_file(file, ignored)) throw input_error(file_, "", "is not a file", "give an HDF5 file");
  id_ = Hdf5Handle(H5Fopen(file_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!id_.valid()) throw input_error(file_, "", "is not an HDF5 file, or is truncated", "make it again");
}

Error Hdf5Reader::complaint(const std::string& name, const std::string& problem) const {
  return input_error(file_, name, problem, "the file is damaged or of another kind; make it again");
}

bool Hdf5Reader::has(const std::string& name) const {
  // Every step of the path has to exist before the next may be asked for.
  for (size_t at = name.find('/', 1);; at = name.find('/', at + 1)) {
    if (H5Lexists(id_.get(), name.substr(0, at).c_str(), H5P_DEFAULT) <= 0) return false;
    if (at == std::string::npos) return true;
  }
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& name) const {
  return (object == "/" || has(object)) && H5Aexists_by_name(id_.get(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5Reader::names_in(const std::string& group) const {
  if (!has(group)) throw complaint(group, "is missing");
  const Hdf5Handle id(H5Gopen2(id_.get(), group.c_str(), H5P_DEFAULT), H5Gclose);
  H5G_info_t info;
  if (!id.valid() || H5Gget_info(id.get(), &info) < 0) throw complaint(group, "is not a group");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const ssize_t length = H5Lget_name_by_idx(id.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, nullptr, 0, H5P_DEFAULT);
    if (length < 0) throw complaint(group, "cannot be listed");
    std::string name(static_cast<size_t>(length) + 1, '\0');
    H5Lget_name_by_idx(id.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT);
    name.pop_back();
    names.push_back(name);
  }
  return names;
}

Shape Hdf5Reader::shape(const std::string& name) const {
  if (!has(name)) throw complaint(name, "is missing");
  const Hdf5Handle set(H5Dopen2(id_.get(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.valid()) throw complaint(name, "is not a dataset");
  const Hdf5Handle space(H5Dget_space(set.get()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0 || H5Sget_simple_extent_type(space.get()) == H5S_NULL) throw complaint(name, "has no extent");
  std::vector<hsize_t> dims(static_cast<size_t>(rank));
  if (rank > 0) H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr);
  return {dims.begin(), dims.end()};
}

template <class T>
Hdf5Handle Hdf5Reader::open_checked(const std::string& name, const Shape& expected) const {
  const Shape found = shape(name);
  bool equal = found.size() == expected.size();
  for (size_t i = 0; equal && i < found.size(); ++i) equal = expected[i] == kAny || expected[i] == found[i];
  if (!equal) throw complaint(name, "has the shape " + text_of(found) + " instead of " + text_of(expected));
  Hdf5Handle set(H5Dopen2(id_.get(), name.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Handle type(H5Dget_type(set.get()), H5Tclose);
  if (H5Tequal(type.get(), native_type<T>()) <= 0)
    throw complaint(name, std::string("is not of type ") + type_name<T>());
  // A small file may promise a huge array: deflate shrinks at most about 1032 times.
  double bytes = sizeof(T);
  for (size_t n : found) bytes *= static_cast<double>(n);
  if (bytes > 1100.0 * static_cast<double>(H5Dget_storage_size(set.get())) + 4096) {
    throw complaint(name, "declares " + text_of(found) + " values that are not stored");
  }
  return set;
}

template <class T>
std::vector<T> Hdf5Reader::dataset(const std::string& name, const Shape& expected) const {
  const Hdf5Handle set = open_checked<T>(name, expected);
  size_t count = 1;
  for (size_t n : shape(name)) count *= n;
  std::vector<T> data(count);
  if (count > 0 && H5Dread(set.get(), native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()) < 0) {
    throw complaint(name, "cannot be read");
  }
  return data;
}

template <class T>
void Hdf5Reader::slabs(const std::string& name, const Shape& expected,
                       const std::function<void(size_t, const T*)>& use) const {
  const Hdf5Handle set = open_checked<T>(name, expected);
  const Shape found = shape(name);
  size_t count = 1;
  for (size_t i = 1; i < found.size(); ++i) count *= found[i];
  const Hdf5Handle space(H5Dget_space(set.get()), H5Sclose), part = space_of(slab_shape(found));
  std::vector<T> data(count);
  for (size_t i = 0; i < found[0]; ++i) {
    if (count > 0) {
      select_slab(space.get(), found, i);
      if (H5Dread(set.get(), native_type<T>(), part.get(), space.get(), H5P_DEFAULT, data.data()) < 0) {
        throw complaint(name, "cannot be read");
      }
    }
    use(i, data.data());
  }
}

std::string Hdf5Reader::text(const std::string& object, const std::string& name) const {
  const std::string field = object + "@" + name;
  if (!has_attribute(object, name)) throw complaint(field, "is missing");
  const Hdf5Handle attribute(H5Aopen_by_name(id_.get(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                             H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose), space(H5Aget_space(attribute.get()), H5Sclose);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1) {
    throw complaint(field, "is not text");
  }
  if (H5Tis_variable_str(type.get()) > 0) {
    char* value = nullptr;
    const Hdf5Handle memory = string_type();
    H5Tset_cset(memory.get(), H5Tget_cset(type.get()));
    if (H5Aread(attribute.get(), memory.get(), &value) < 0) throw complaint(field, "cannot be read");
    const std::string text = value ? value : "";
    H5free_memory(value);
    return text;
  }
  std::string text(H5Tget_size(type.get()), '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) throw complaint(field, "cannot be read");
  return text.substr(0, text.find('\0'));
}

double Hdf5Reader::number(const std::string& object, const std::string& name) const {
  return numbers(object, name, 1)[0];
}

std::vector<double> Hdf5Reader::numbers(const std::string& object, const std::string& name, size_t count) const {
  const std::string field = object + "@" + name;
  if (!has_attribute(object, name)) throw complaint(field, "is missing");
  const Hdf5Handle attribute(H5Aopen_by_name(id_.get(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                             H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose), space(H5Aget_space(attribute.get()), H5Sclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  std::vector<double> values(count, NAN);
  bool good = (kind == H5T_FLOAT || kind == H5T_INTEGER) &&
              H5Sget_simple_extent_npoints(space.get()) == static_cast<hssize_t>(count) &&
              H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, values.data()) >= 0;
  for (double value : values) good = good && std::isfinite(value);
  if (!good) throw complaint(field, "is not " + std::to_string(count) + " finite number(s)");
  return values;
}

#define PLIANT_INSTANTIATE(T)                                                                                \
  template void Hdf5Writer::dataset(const std::string&, const T*, const Shape&);                             \
  template void Hdf5Writer::slabs(const std::string&, const Shape&, const std::function<const T*(size_t)>&); \
  template std::vector<T> Hdf5Reader::dataset(const std::string&, const Shape&) const;                       \
  template void Hdf5Reader::slabs(const std::string&, const Shape&, const std::function<void(size_t, const T*)>&) const;
PLIANT_INSTANTIATE(float)
PLIANT_INSTANTIATE(double)
PLIANT_INSTANTIATE(int32_t)
PLIANT_INSTANTIATE(uint32_t)
PLIANT_INSTANTIATE(int64_t)
PLIANT_INSTANTIATE(uint8_t)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
