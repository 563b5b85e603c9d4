#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pliant {

using Shape = std::vector<size_t>;
constexpr size_t kAny = static_cast<size_t>(-1);  ///< in an expected shape: any length

/// Identifier of an HDF5 object that is released with it.
class Hdf5Handle {
 public:
  using Close = int (*)(int64_t);
  Hdf5Handle() = default;
  Hdf5Handle(int64_t id, Close close) : id_(id), close_(close) {}
  ~Hdf5Handle() { reset(); }
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(other.id_), close_(other.close_) { other.id_ = -1; }
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    reset();
    id_ = other.id_;
    close_ = other.close_;
    other.id_ = -1;
    return *this;
  }
  int64_t get() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// Releases the object; false when that failed, for a file on a full disk.
  bool reset() {
    const bool good = id_ < 0 || close_(id_) >= 0;
    id_ = -1;
    return good;
  }

 private:
  int64_t id_ = -1;
  Close close_ = nullptr;
};

/// Writes one HDF5 file.  Equal contents give equal bytes: no times are stored.
/// T is float, double, int32_t, uint32_t, int64_t or uint8_t.
class Hdf5Writer {
 public:
  explicit Hdf5Writer(const std::filesystem::path& file);
  void close();

  void group(const std::string& name);
  template <class T>
  void dataset(const std::string& name, const T* data, const Shape& shape);
  /// Writes shape[0] slabs one after the other, each a compressed chunk.
  template <class T>
  void slabs(const std::string& name, const Shape& shape, const std::function<const T*(size_t)>& slab);
  void link(const std::string& existing, const std::string& name);  ///< hard link
  /// Attributes of an existing group or dataset.
  void text(const std::string& object, const std::string& name, const std::string& value);
  void texts(const std::string& object, const std::string& name, const std::vector<std::string>& values);
  void number(const std::string& object, const std::string& name, double value);
  void numbers(const std::string& object, const std::string& name, const std::vector<double>& values);
  void integers(const std::string& object, const std::string& name, const std::vector<int32_t>& values);

 private:
  void strings(const std::string& object, const std::string& name, const std::vector<std::string>& values, bool scalar);
  void attribute(const std::string& object, const std::string& name, int64_t type, int64_t space, const void* data);
  [[noreturn]] void fail(const std::string& name) const;

  std::string file_;
  Hdf5Handle id_;
};

/// Writes a file atomically: `body` fills it.
void write_hdf5(const std::filesystem::path& file, const std::function<void(Hdf5Writer&)>& body);

/// Reads one HDF5 file; everything that is not as expected is an Error{kInput} naming the file and the dataset.
class Hdf5Reader {
 public:
  explicit Hdf5Reader(const std::filesystem::path& file);

  const std::string& file() const { return file_; }
  bool has(const std::string& name) const;
  bool has_attribute(const std::string& object, const std::string& name) const;
  std::vector<std::string> names_in(const std::string& group) const;
  Shape shape(const std::string& name) const;
  template <class T>
  std::vector<T> dataset(const std::string& name, const Shape& expected) const;
  /// Hands the slabs of a dataset [shape[0], ...] to `use`, one after the other.
  template <class T>
  void slabs(const std::string& name, const Shape& expected, const std::function<void(size_t, const T*)>& use) const;
  std::string text(const std::string& object, const std::string& name) const;
  double number(const std::string& object, const std::string& name) const;
  std::vector<double> numbers(const std::string& object, const std::string& name, size_t count) const;  ///< finite
  /// An Error{kInput} about `name`.
  class Error complaint(const std::string& name, const std::string& problem) const;

 private:
  template <class T>
  Hdf5Handle open_checked(const std::string& name, const Shape& expected) const;

  std::string file_;
  Hdf5Handle id_;
};

}  // namespace pliant
