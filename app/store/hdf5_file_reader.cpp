#include <cmath>

#include "app/store/hdf5_file.h"
#include "app/store/hdf5_types.h"
#include "gaussians/base/error.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

std::string text_of(const Shape& shape) {
  std::string text = "[";
  for (size_t n : shape) text += (text.size() > 1 ? ", " : "") + (n == kAny ? std::string("any") : std::to_string(n));
  return text + "]";
}

}  // namespace

Hdf5Reader::Hdf5Reader(const fs::path& file) : file_(file.string()) {
  silence_hdf5();
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
  if (H5Tequal(type.get(), hdf5_type<T>().id) <= 0)
    throw complaint(name, std::string("is not of type ") + hdf5_type<T>().name);
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
  if (count > 0 && H5Dread(set.get(), hdf5_type<T>().id, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()) < 0) {
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
  const Hdf5Handle space(H5Dget_space(set.get()), H5Sclose), part = hdf5_space(slab_shape(found));
  std::vector<T> data(count);
  for (size_t i = 0; i < found[0]; ++i) {
    if (count > 0) {
      select_hdf5_slab(space.get(), found, i);
      if (H5Dread(set.get(), hdf5_type<T>().id, part.get(), space.get(), H5P_DEFAULT, data.data()) < 0) {
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
    const Hdf5Handle memory = hdf5_string_type();
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

#define PLIANT_INSTANTIATE(T)                                                          \
  template std::vector<T> Hdf5Reader::dataset(const std::string&, const Shape&) const; \
  template void Hdf5Reader::slabs(const std::string&, const Shape&, const std::function<void(size_t, const T*)>&) const;
PLIANT_FOR_HDF5_TYPES(PLIANT_INSTANTIATE)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
