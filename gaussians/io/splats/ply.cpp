#include "gaussians/io/splats/ply.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <locale>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/text.h"
#include "gaussians/io/splats/cloud_builder.h"
#include "gaussians/io/splats/compressed_ply.h"
#include "gaussians/io/splats/ply_header.h"
#include "gaussians/io/splats/ply_rows.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr float kSurfelThickness = -4.60517f;  // ln of third axis / smaller axis for 2DGS surfels
constexpr int kMostObjectChannels = 64;
constexpr size_t kWrittenRows = 4096;

/// Columns of the parameters of a Gaussian; -1 = absent.
struct Layout {
  int x[3], dc[3], opacity, scale[3], rot[4], filter;
  bool colored = false;  ///< the columns `dc` are red, green and blue and not f_dc_*
  float color_step = 1;  ///< of color per unit of them
  std::vector<int> rest, object;
  int degree = 0;         ///< of the harmonics that are read
  bool degree_4 = false;  ///< the file has more, which are dropped
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
  // `--ply-color-mode rgb` of nerfstudio's export has colors instead of harmonics.
  layout.colored = vertex.find("f_dc_0") < 0 && vertex.find("red") >= 0 && vertex.find("green") >= 0 &&
                   vertex.find("blue") >= 0 && vertex.find("opacity") >= 0;
  const char* colors[] = {"red", "green", "blue"};
  for (int k = 0; k < 3; ++k) {
    layout.x[k] = required(std::string(1, "xyz"[k]));
    layout.dc[k] = required(layout.colored ? colors[k] : "f_dc_" + std::to_string(k));
    layout.scale[k] = k < 2 ? required("scale_" + std::to_string(k)) : vertex.find("scale_2");
  }
  layout.opacity = required("opacity");
  layout.filter = vertex.find("filter_3D");
  for (int k = 0; k < 4; ++k) layout.rot[k] = required("rot_" + std::to_string(k));
  const auto is_rest = [](const PlyProperty& property) { return property.name.rfind("f_rest_", 0) == 0; };
  const auto count = std::count_if(vertex.properties.begin(), vertex.properties.end(), is_rest);
  const int counts[] = {0, 9, 24, 45, 72};
  const auto* degree = std::find(std::begin(counts), std::end(counts), count);
  if (degree == std::end(counts)) {
    throw input_error(file, "property f_rest", "occurs " + std::to_string(count) + " times",
                      "SH degrees 0 to 4 have 0, 9, 24, 45 or 72");
  }
  layout.degree = std::min(static_cast<int>(degree - counts), 3);
  layout.degree_4 = degree - counts > 3;
  // Of each channel the first, which are those of the lower degrees.
  const int stored = static_cast<int>(count) / 3, read = counts[layout.degree] / 3;
  for (int i = 0; i < count; ++i) {
    const int column = required("f_rest_" + std::to_string(i));
    if (i % stored < read) layout.rest.push_back(column);
  }
  for (int i = 0; i < kMostObjectChannels; ++i) {
    const int column = vertex.find("obj_dc_" + std::to_string(i));
    if (column < 0) break;
    layout.object.push_back(column);
  }
  return layout;
}

/// What a Gaussian is after the 3D smoothing filter (Yu et al. 2024, Mip-Splatting, eq. 9) of this standard deviation,
/// which such scenes keep apart: s' = sqrt(s^2 + f^2), o' = o prod(s) / prod(s').
void apply_filter(float filter, SplatRow& row) {
  if (!(filter > 0)) return;
  double gain = 0;  // log
  for (float& log_scale : row.log_scale) {
    const double filtered = 0.5 * std::log(std::exp(2.0 * log_scale) + static_cast<double>(filter) * filter);
    gain += log_scale - filtered;
    log_scale = static_cast<float>(filtered);
  }
  const double opacity = std::exp(gain) / (1 + std::exp(-static_cast<double>(row.opacity_logit)));
  row.opacity_logit = static_cast<float>(std::log(std::max(opacity, 1e-30) / (1 - opacity)));
}

/// The row of the file as a Gaussian.
SplatRow row_of(const Layout& layout, const float* values) {
  SplatRow row;
  for (int k = 0; k < 3; ++k) {
    row.position[k] = values[layout.x[k]];
    row.log_scale[k] = layout.scale[k] < 0 ? 0.0f : values[layout.scale[k]];
    const float dc = values[layout.dc[k]];
    row.sh[k] = layout.colored ? sh_of_color(dc * layout.color_step) : dc;
  }
  if (layout.scale[2] < 0) row.log_scale[2] = std::min(row.log_scale[0], row.log_scale[1]) + kSurfelThickness;
  for (int k = 0; k < 4; ++k) row.rotation[k] = values[layout.rot[k]];
  row.opacity_logit = values[layout.opacity];
  if (layout.filter >= 0) apply_filter(values[layout.filter], row);
  // In the file all red coefficients come first, then green, then blue.
  const int rest = static_cast<int>(layout.rest.size()) / 3;
  for (int k = 0; k < rest; ++k) {
    for (int c = 0; c < 3; ++c) row.sh[3 + 3 * k + c] = values[layout.rest[c * rest + k]];
  }
  return row;
}

/// Whether a comment says how the scene was trained; the last one wins.  In any case: "SplatRenderMode: mip" (Brush,
/// splat-transform), "antialiased 1" and "postshot.anti_aliasing=1" (Postshot).
void read_render_mode(const std::string& comment, bool& antialiased) {
  if (const size_t at = comment.find("splatrendermode:"); at != std::string::npos)
    antialiased = comment.find("mip", at) != std::string::npos;
  for (const std::string key : {"antialiased", "postshot.anti_aliasing"}) {
    size_t at = comment.find(key);
    if (at == std::string::npos) continue;
    at = comment.find_first_not_of(" =:", at + key.size());
    if (at != std::string::npos && (comment[at] == '0' || comment[at] == '1')) antialiased = comment[at] == '1';
  }
}

/// Whether a comment in lower case declares that z is up: "vertical axis: z" (nerfstudio) or a direction near it, as in
/// "vertical axis: 0 0 1" (Brush).
bool declares_z_up(const std::string& comment) {
  const std::string key = "vertical axis: ";
  const size_t at = comment.find(key);
  if (at == std::string::npos) return false;
  if (comment[at + key.size()] == 'z') return true;
  std::istringstream numbers(comment.substr(at + key.size()));
  numbers.imbue(std::locale::classic());
  double x = 0, y = 0, z = 0;
  return numbers >> x >> y >> z && z > 0.77 * std::hypot(x, y, z);  // as is_near_z of up_direction.h
}

/// What the comments of the header say of the whole cloud.
void read_comments(const PlyHeader& header, ReadReport& report) {
  for (const std::string& line : header.comments) {
    const std::string comment = lower_case(line);
    read_render_mode(comment, report.antialiased);
    if (declares_z_up(comment)) report.z_is_up = true;
    // Its exporter misspells itself.
    for (const char* name : {"generated by nerstudio", "generated by nerfstudio"})
      if (comment.find(name) != std::string::npos) report.nerfstudio = true;
  }
}

/// Reads the data behind the header of a PLY that is not compressed.
GaussianCloud read_vertices(std::istream& in, const PlyHeader& header, const std::string& name, uint64_t size,
                            ReadReport& report) {
  const PlyElement* vertex = header.find("vertex");
  if (!vertex) throw input_error(name, "element vertex", "is missing", "this is not a 3DGS PLY");
  Layout layout = find_layout(*vertex, name);
  if (vertex->count > INT32_MAX) {
    throw input_error(name, "element vertex", "has " + std::to_string(vertex->count) + " rows",
                      "at most 2147483647 are supported");
  }
  for (const PlyElement& element : header.elements) {
    if (&element == vertex) break;
    PlyRows(in, header, element, name, size).skip();
  }

  PlyRows rows(in, header, *vertex, name, size);
  rows.check_size();
  if (layout.colored) {
    const std::streampos begin = in.tellg();
    float largest = 0;
    rows.for_each_row([&](const float* values) {
      for (const int column : layout.dc) largest = std::max(largest, values[column]);
    });
    in.clear();
    in.seekg(begin);
    layout.color_step = 1 / ply_full_color(vertex->properties[layout.dc[0]].type, largest);
  }
  CloudBuilder builder(layout.degree, vertex->count, static_cast<int>(layout.object.size()));
  std::vector<float> object(layout.object.size());
  rows.for_each_row([&](const float* values) {
    for (size_t k = 0; k < object.size(); ++k) object[k] = values[layout.object[k]];
    builder.add(row_of(layout, values), object);
  });

  GaussianCloud cloud = builder.finish(report);
  report.format =
      std::string(layout.scale[2] < 0 ? "2DGS" : "3DGS") + " PLY, SH degree " + std::to_string(layout.degree);
  if (layout.scale[2] < 0) {
    report.warnings.push_back(
        "scale_2 is absent (2DGS surfels): the third axis is set 100 times thinner than the others");
  }
  if (layout.degree_4) report.warnings.push_back("harmonics of degree 4 are dropped");
  if (layout.filter >= 0) {
    report.antialiased = true;  // Mip-Splatting has both of its filters
    report.warnings.push_back(
        "filter_3D is present (Mip-Splatting): its screen filter has a variance of 0.1 px^2 unless the training set "
        "another, the one here has 0.3 px^2, so that details of about a pixel look softer");
  }
  return cloud;
}

}  // namespace

GaussianCloud read_ply(const fs::path& file, ReadReport* report) {
  const std::string name = file.string();
  std::error_code failed;
  if (!fs::exists(file, failed)) throw input_error(name, "", "does not exist", "check the name");
  if (!fs::is_regular_file(file, failed)) throw input_error(name, "", "is not a file", "give a PLY file");
  const uint64_t size = fs::file_size(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw input_error(name, "", "cannot be opened", "check its permissions");
  const PlyHeader header = read_ply_header(in, file);
  ReadReport found;
  found.files = {file};
  GaussianCloud cloud = is_compressed_ply(header) ? read_compressed_ply(in, header, name, size, found)
                                                  : read_vertices(in, header, name, size, found);
  read_comments(header, found);
  if (report) *report = std::move(found);
  return cloud;
}

bool is_point_cloud(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string magic(3, ' ');
  if (!in.read(magic.data(), 3) || magic != "ply") return false;
  in.seekg(0);
  const PlyHeader header = read_ply_header(in, file);
  const PlyElement* vertex = header.find("vertex");
  return vertex && vertex->find("x") >= 0 && vertex->find("opacity") < 0;
}

void write_ply(const fs::path& file, const GaussianCloud& cloud, bool antialiased, bool z_is_up) {
  const int rest = cloud.sh_count() - 1;
  std::vector<std::string> names = {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
  for (int i = 0; i < 3 * rest; ++i) names.push_back("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    names.push_back(name);
  }
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (antialiased) header += "comment SplatRenderMode: mip\n";
  if (z_is_up) header += "comment Vertical Axis: z\n";
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
      if ((i + 1) % kWrittenRows == 0 || i + 1 == cloud.size()) {
        out.write(reinterpret_cast<const char*>(block.data()),
                  static_cast<std::streamsize>(block.size() * sizeof(float)));
        block.clear();
      }
    }
    out.close();
    if (!out) throw input_error(file.string(), "", "cannot be written", "check permissions and free space");
  });
}

}  // namespace pliant
