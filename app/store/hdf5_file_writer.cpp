#include <algorithm>

#include "app/store/hdf5_file.h"
#include "app/store/hdf5_types.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace fs = std::filesystem;

namespace pliant {

Hdf5Writer::Hdf5Writer(const fs::path& file) : file_(file.string()) {
  silence_hdf5();
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
  const Hdf5Handle space = hdf5_space(shape), properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  const Hdf5Handle set(
      H5Dcreate2(id_.get(), name.c_str(), hdf5_type<T>().id, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      H5Dclose);
  if (!set.valid()) fail(name);
  if (std::find(shape.begin(), shape.end(), size_t{0}) != shape.end()) return;
  if (H5Dwrite(set.get(), hdf5_type<T>().id, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) fail(name);
}

template <class T>
void Hdf5Writer::slabs(const std::string& name, const Shape& shape, const std::function<const T*(size_t)>& slab) {
  if (std::find(shape.begin(), shape.end(), size_t{0}) != shape.end()) return dataset<T>(name, nullptr, shape);
  const Hdf5Handle space = hdf5_space(shape), part = hdf5_space(slab_shape(shape));
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  const Shape chunk_shape = slab_shape(shape);
  const std::vector<hsize_t> chunk(chunk_shape.begin(), chunk_shape.end());
  H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
  H5Pset_deflate(properties.get(), 1);
  const Hdf5Handle set(
      H5Dcreate2(id_.get(), name.c_str(), hdf5_type<T>().id, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      H5Dclose);
  if (!set.valid()) fail(name);
  for (size_t i = 0; i < shape[0]; ++i) {
    select_hdf5_slab(space.get(), shape, i);
    if (H5Dwrite(set.get(), hdf5_type<T>().id, part.get(), space.get(), H5P_DEFAULT, slab(i)) < 0) fail(name);
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
  const Hdf5Handle type = hdf5_string_type(), space = hdf5_space(scalar ? Shape() : Shape{values.size()});
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
  attribute(object, name, H5T_NATIVE_DOUBLE, hdf5_space({}).get(), &value);
}

void Hdf5Writer::numbers(const std::string& object, const std::string& name, const std::vector<double>& values) {
  attribute(object, name, H5T_NATIVE_DOUBLE, hdf5_space({values.size()}).get(), values.data());
}

void Hdf5Writer::integers(const std::string& object, const std::string& name, const std::vector<int32_t>& values) {
  attribute(object, name, H5T_NATIVE_INT32, hdf5_space({values.size()}).get(), values.data());
}

void write_hdf5(const fs::path& file, const std::function<void(Hdf5Writer&)>& body) {
  write_atomically(file, [&](const fs::path& temporary) {
    Hdf5Writer writer(temporary);
    body(writer);
    writer.close();
  });
}

#define PLIANT_INSTANTIATE(T)                                                    \
  template void Hdf5Writer::dataset(const std::string&, const T*, const Shape&); \
  template void Hdf5Writer::slabs(const std::string&, const Shape&, const std::function<const T*(size_t)>&);
PLIANT_FOR_HDF5_TYPES(PLIANT_INSTANTIATE)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
