#include "gaussians/io/ply.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files.h"
#include "gaussians/io/ply_header.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr float kOpaqueLogit = 20.0f;         // stands for +infinity: sigmoid is 1 in float
constexpr float kSmallestLogScale = -30.0f;   // stands for -infinity
constexpr float kLargestLogScale = 40.0f;     // beyond it squared scales overflow
constexpr float kLargestCoordinate = 1e12f;   // beyond it squared distances overflow
constexpr float kSurfelThickness = -4.60517f; // ln of third axis / smaller axis for 2DGS surfels
constexpr size_t kBlockRows = 4096;

/// Columns of the parameters of a Gaussian; -1 = absent.
struct Layout {
  int x[3], dc[3], opacity, scale[3], rot[4];
  std::vector<int> rest;
  int degree = 0;
};

Layout find_layout(const PlyElement& vertex, const std::string& file) {
  const auto required = [&](const std::string& name) {
    const int index = vertex.find(name);
    if (index < 0) {
      throw input_error(file, "property " + name, "is missing in element vertex",
                        "this is not a 3DGS PLY; a plain point cloud or mesh has no Gaussians");
    }
    return index;
  };
  for (const PlyProperty& property : vertex.properties) {
    if (property.list) {
      throw input_error(file, "property " + property.name, "is a list inside element vertex", "this is not a 3DGS PLY");
    }
  }
  Layout layout;
  for (int k = 0; k < 3; ++k) {
    layout.x[k] = required(std::string(1, "xyz"[k]));
    layout.dc[k] = required("f_dc_" + std::to_string(k));
    layout.scale[k] = k < 2 ? required("scale_" + std::to_string(k)) : vertex.find("scale_2");
  }
  layout.opacity = required("opacity");
  for (int k = 0; k < 4; ++k) layout.rot[k] = required("rot_" + std::to_string(k));
  const auto is_rest = [](const PlyProperty& property) { return property.name.rfind("f_rest_", 0) == 0; };
  const auto count = std::count_if(vertex.properties.begin(), vertex.properties.end(), is_rest);
  const int counts[] = {0, 9, 24, 45};
  const auto* degree = std::find(std::begin(counts), std::end(counts), count);
  if (degree == std::end(counts)) {
    throw input_error(file, "property f_rest", "occurs " + std::to_string(count) + " times",
                      "SH degrees 0 to 3 have 0, 9, 24 or 45");
  }
  layout.degree = static_cast<int>(degree - counts);
  for (int i = 0; i < count; ++i) layout.rest.push_back(required("f_rest_" + std::to_string(i)));
  return layout;
}

/// Reads rows of one element as floats, ascii or binary.
class RowReader {
 public:
  RowReader(std::istream& in, const PlyHeader& header, const PlyElement& element, std::string file, uint64_t size)
      : in_(in), element_(element), file_(std::move(file)), ascii_(header.ascii), size_(size) {
    for (const PlyProperty& property : element.properties) offset_.push_back(row_bytes_), row_bytes_ += ply_size(property.type);
  }

  /// Compares the promised rows with the bytes that are left, before anything is allocated.
  void check_size() {
    const uint64_t left = bytes_left();
    // In text a value takes a character and a separator; the last one may lack the separator.
    const uint64_t row = ascii_ ? 2 * element_.properties.size() : row_bytes_;
    const uint64_t available = ascii_ ? left + 1 : left;
    if (row > 0 && element_.count > available / row) {
      throw input_error(file_, "element " + element_.name,
                        "the header promises " + std::to_string(element_.count) + " rows but only " +
                            std::to_string(left) + " bytes follow (room for " + std::to_string(available / row) + ")",
                        "the file is truncated or its header is wrong");
    }
  }

  /// Passes over the whole element.
  void skip() {
    if (!ascii_ && !element_.has_list()) {
      check_size();
      in_.seekg(static_cast<std::streamoff>(element_.count * row_bytes_), std::ios::cur);
      return;
    }
    if (element_.properties.empty()) return;
    for (uint64_t row = 0; row < element_.count; ++row) {
      for (const PlyProperty& property : element_.properties) {
        const double length = property.list ? read_scalar(property, property.count_type) : 1;
        if (!(length >= 0) || length > static_cast<double>(bytes_left())) throw truncated(property);
        if (ascii_) {
          for (double k = 0; k < length; ++k) read_scalar(property, property.type);
        } else {
          const auto bytes = static_cast<uint64_t>(length) * ply_size(property.type);
          if (bytes > bytes_left()) throw truncated(property);
          in_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
        }
      }
    }
  }

  /// Calls use(row values) for every row.
  template <class Use>
  void for_each_row(Use&& use) {
    std::vector<float> values(element_.properties.size());
    std::vector<char> block;
    for (uint64_t row = 0; row < element_.count; ++row) {
      if (ascii_) {
        for (size_t i = 0; i < values.size(); ++i) {
          values[i] = static_cast<float>(read_scalar(element_.properties[i], element_.properties[i].type));
        }
      } else {
        if (row % kBlockRows == 0) {
          block.resize(std::min<uint64_t>(kBlockRows, element_.count - row) * row_bytes_);
          in_.read(block.data(), static_cast<std::streamsize>(block.size()));
          if (!in_) throw truncated(element_.properties.back());
        }
        const char* bytes = block.data() + (row % kBlockRows) * row_bytes_;
        for (size_t i = 0; i < values.size(); ++i) {
          if (element_.properties[i].type == PlyType::kFloat) std::memcpy(&values[i], bytes + offset_[i], 4);
          else values[i] = static_cast<float>(ply_value(element_.properties[i].type, bytes + offset_[i]));
        }
      }
      use(values.data());
    }
  }

 private:
  uint64_t bytes_left() {
    const std::streamoff at = in_.tellg();
    return at < 0 || static_cast<uint64_t>(at) > size_ ? 0 : size_ - static_cast<uint64_t>(at);
  }

  Error truncated(const PlyProperty& property) const {
    return input_error(file_, "property " + property.name,
                       "the data of element " + element_.name + " end early", "the file is truncated");
  }

  double read_scalar(const PlyProperty& property, PlyType type) {
    if (!ascii_) {
      char bytes[8];
      if (!in_.read(bytes, static_cast<std::streamsize>(ply_size(type)))) throw truncated(property);
      return ply_value(type, bytes);
    }
    if (!(in_ >> word_)) throw truncated(property);
    const char* begin = word_.data() + (word_[0] == '+' ? 1 : 0);
    double value = 0;
    const auto [end, failed] = std::from_chars(begin, word_.data() + word_.size(), value);
    if (end != word_.data() + word_.size() || (failed != std::errc() && failed != std::errc::result_out_of_range)) {
      throw input_error(file_, "property " + property.name, "has the value '" + word_.substr(0, 40) + "'",
                        "it must be a number");
    }
    return failed == std::errc() ? value : 0.0;
  }

  std::istream& in_;
  const PlyElement& element_;
  std::string file_, word_;
  bool ascii_;
  uint64_t size_;
  size_t row_bytes_ = 0;
  std::vector<size_t> offset_;
};

/// Appends one row; false when it holds values that no Gaussian can have.
bool append_row(const Layout& layout, const float* row, GaussianCloud& cloud, size_t& zero_rotations) {
  Vec3f x, log_scale;
  Vec4f rotation;
  for (int k = 0; k < 3; ++k) {
    x[k] = row[layout.x[k]];
    log_scale[k] = layout.scale[k] < 0 ? 0.0f : row[layout.scale[k]];
    if (log_scale[k] == -INFINITY) log_scale[k] = kSmallestLogScale;
  }
  if (layout.scale[2] < 0) log_scale[2] = std::min(log_scale[0], log_scale[1]) + kSurfelThickness;
  for (int k = 0; k < 4; ++k) rotation[k] = row[layout.rot[k]];
  float opacity = row[layout.opacity];
  if (opacity == INFINITY) opacity = kOpaqueLogit;
  bool good = x.allFinite() && x.cwiseAbs().maxCoeff() <= kLargestCoordinate && log_scale.allFinite() &&
              log_scale.maxCoeff() <= kLargestLogScale && rotation.allFinite() && std::isfinite(opacity);
  for (int c = 0; c < 3; ++c) good = good && std::isfinite(row[layout.dc[c]]);
  for (int i : layout.rest) good = good && std::isfinite(row[i]);
  if (!good) return false;
  if (!(rotation.norm() > 1e-12f)) rotation = Vec4f(1, 0, 0, 0), ++zero_rotations;
  cloud.position.push_back(x);
  cloud.rotation.push_back(rotation);
  cloud.log_scale.push_back(log_scale);
  cloud.opacity_logit.push_back(opacity);
  for (int c = 0; c < 3; ++c) cloud.sh.push_back(row[layout.dc[c]]);
  // In the file all red coefficients come first, then green, then blue.
  const int rest = static_cast<int>(layout.rest.size()) / 3;
  for (int k = 0; k < rest; ++k) {
    for (int c = 0; c < 3; ++c) cloud.sh.push_back(row[layout.rest[c * rest + k]]);
  }
  return true;
}

/// Whether a comment says how the scene was trained (Brush, Postshot); the last one wins.
void read_render_mode(const std::string& comment, bool& antialiased) {
  size_t at = comment.find("SplatRenderMode:");
  if (at != std::string::npos) antialiased = comment.find("mip", at) != std::string::npos;
  at = comment.find("antialiased ");
  if (at != std::string::npos) antialiased = comment.compare(at + 12, 1, "1") == 0;
}

}  // namespace

GaussianCloud read_ply(const fs::path& file, ReadReport* report) {
  const std::string name = file.string();
  std::error_code failed;
  if (!fs::exists(file, failed)) throw input_error(name, "", "does not exist", "check the name");
  if (!fs::is_regular_file(file, failed)) throw input_error(name, "", "is not a file", "name a PLY file");
  const uint64_t size = fs::file_size(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw input_error(name, "", "cannot be opened", "check its permissions");
  const PlyHeader header = read_ply_header(in, file);
  const PlyElement* vertex = header.find("vertex");
  if (header.find("chunk") && vertex && vertex->find("packed_position") >= 0) {
    throw input_error(name, "element chunk", "this is a compressed PLY, which is not read yet",
                      "save it as a standard PLY, for example with: splat-transform in.compressed.ply out.ply");
  }
  if (!vertex) throw input_error(name, "element vertex", "is missing", "this is not a 3DGS PLY");
  const Layout layout = find_layout(*vertex, name);
  if (vertex->count > INT32_MAX) {
    throw input_error(name, "element vertex", "has " + std::to_string(vertex->count) + " rows",
                      "at most 2147483647 are supported");
  }
  for (const PlyElement& element : header.elements) {
    if (&element == vertex) break;
    RowReader(in, header, element, name, size).skip();
  }

  ReadReport found;
  GaussianCloud cloud;
  cloud.sh_degree = layout.degree;
  RowReader rows(in, header, *vertex, name, size);
  rows.check_size();
  cloud.position.reserve(vertex->count), cloud.rotation.reserve(vertex->count), cloud.log_scale.reserve(vertex->count);
  cloud.opacity_logit.reserve(vertex->count), cloud.sh.reserve(vertex->count * cloud.sh_count() * 3);
  size_t zero_rotations = 0;
  rows.for_each_row([&](const float* row) { found.dropped += !append_row(layout, row, cloud, zero_rotations); });

  found.rows = vertex->count;
  found.format = std::string(layout.scale[2] < 0 ? "2DGS" : "3DGS") + " PLY, SH degree " + std::to_string(layout.degree);
  for (const std::string& comment : header.comments) read_render_mode(comment, found.antialiased);
  if (found.dropped > 0) {
    found.warnings.push_back(std::to_string(found.dropped) + " of " + std::to_string(found.rows) +
                             " Gaussians with NaN, infinite or absurd values were left out");
  }
  if (zero_rotations > 0) {
    found.warnings.push_back(std::to_string(zero_rotations) + " Gaussians have a zero quaternion; no rotation is used");
  }
  if (layout.scale[2] < 0) {
    found.warnings.push_back("scale_2 is absent (2DGS surfels): the third axis is taken 100 times thinner than the others");
  }
  if (report) *report = std::move(found);
  return cloud;
}

void write_ply(const fs::path& file, const GaussianCloud& cloud, bool antialiased) {
  const int rest = cloud.sh_count() - 1;
  std::vector<std::string> names = {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
  for (int i = 0; i < 3 * rest; ++i) names.push_back("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    names.push_back(name);
  }
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (antialiased) header += "comment SplatRenderMode: mip\n";
  header += "element vertex " + std::to_string(cloud.size()) + "\n";
  for (const std::string& name : names) header += "property float " + name + "\n";
  header += "end_header\n";

  write_atomically(file, [&](const fs::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out.write(header.data(), static_cast<std::streamsize>(header.size()));
    std::vector<float> block;
    for (size_t i = 0; i < cloud.size(); ++i) {
      const float* sh = cloud.sh_of(i);
      block.insert(block.end(), cloud.position[i].data(), cloud.position[i].data() + 3);
      block.insert(block.end(), 3, 0.0f);
      block.insert(block.end(), sh, sh + 3);
      for (int c = 0; c < 3; ++c) {
        for (int k = 1; k <= rest; ++k) block.push_back(sh[3 * k + c]);
      }
      block.push_back(cloud.opacity_logit[i]);
      block.insert(block.end(), cloud.log_scale[i].data(), cloud.log_scale[i].data() + 3);
      block.insert(block.end(), cloud.rotation[i].data(), cloud.rotation[i].data() + 4);
      if ((i + 1) % kBlockRows == 0 || i + 1 == cloud.size()) {
        out.write(reinterpret_cast<const char*>(block.data()), static_cast<std::streamsize>(block.size() * sizeof(float)));
        block.clear();
      }
    }
    out.close();
    if (!out) throw input_error(file.string(), "", "cannot be written", "check permissions and free space");
  });
}

}  // namespace pliant
