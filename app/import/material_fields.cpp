#include "app/import/material_fields.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/npy.h"
#include "gaussians/io/files/zip_archive.h"
#include "gaussians/io/splats/ply_rows.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr uint64_t kMostBytes = uint64_t{1} << 32;
constexpr double kSameBox = 0.1;     // of the largest extent, by which the box of a field may be beside the object's
constexpr double kSameShape = 0.2;   // of the largest extent, by which their proportions may differ
constexpr double kSamePlace = 0.25;  // the same as kSameBox for samples of one scene, which may be few

using Columns = std::map<std::string, std::vector<double>>;

Columns read_voxels(const fs::path& file) {
  ZipArchive zip(file);
  const std::vector<std::string> names = zip.names();
  const std::string entry = "voxel_data.npy";
  if (std::find(names.begin(), names.end(), entry) == names.end())
    throw input_error(file.string(), entry, "is missing in the archive", "give an .npz of VoMP");
  return read_npy_columns(zip.read(entry, kMostBytes), file.string() + ":" + entry);
}

/// Whether data of a row follow.
bool has_another_row(std::istream& in, const PlyHeader& header, const PlyElement& element, uint64_t size) {
  if (header.ascii) return static_cast<bool>(in >> std::ws) && in.peek() != std::istream::traits_type::eof();
  const std::streamoff at = in.tellg();
  return at >= 0 && size >= static_cast<uint64_t>(at) + element.row_bytes();
}

Columns read_vertices(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  const PlyHeader header = read_ply_header(in, file);
  const PlyElement* vertex = header.find("vertex");
  if (!vertex) throw input_error(file.string(), "element vertex", "is missing", "give a PLY with points");
  const uint64_t size = fs::file_size(file);
  for (const PlyElement& element : header.elements) {
    if (&element == vertex) break;
    PlyRows(in, header, element, file.string(), size).skip();
  }
  PlyRows rows(in, header, *vertex, file.string(), size);
  rows.check_size();
  Columns out;
  for (const PlyProperty& property : vertex->properties) out[property.name];
  rows.for_each_row([&](const float* values) {
    for (size_t k = 0; k < vertex->properties.size(); ++k) out[vertex->properties[k].name].push_back(values[k]);
  });
  if (vertex == &header.elements.back() && has_another_row(in, header, *vertex, size))
    throw input_error(file.string(), "element vertex",
                      fmt::format("the header declares {} rows, but more follow", vertex->count),
                      "correct the number in the header");
  return out;
}

/// [low, high] without the outermost points, which may be stray ones.
Eigen::AlignedBox3f box_of(const std::vector<Vec3f>& points) {
  constexpr double kStray = 0.002;
  Eigen::AlignedBox3f box;
  Vec3f low, high;
  std::vector<float> values(points.size());
  for (int k = 0; k < 3; ++k) {
    for (size_t i = 0; i < points.size(); ++i) values[i] = points[i][k];
    std::sort(values.begin(), values.end());
    const size_t cut = static_cast<size_t>(kStray * static_cast<double>(values.size()));
    low[k] = values[cut];
    high[k] = values[values.size() - 1 - cut];
  }
  box.extend(low);
  box.extend(high);
  return box;
}

/// The largest one between their corners along an axis.
float distance_of(const Eigen::AlignedBox3f& a, const Eigen::AlignedBox3f& b) {
  return std::max((a.min() - b.min()).cwiseAbs().maxCoeff(), (a.max() - b.max()).cwiseAbs().maxCoeff());
}

std::string box_text(const Eigen::AlignedBox3f& box) {
  const Vec3f size = box.sizes();
  return fmt::format("{:.3g} x {:.3g} x {:.3g}", size.x(), size.y(), size.z());
}

std::vector<float> floats_of(const std::vector<double>& values) { return {values.begin(), values.end()}; }

}  // namespace

bool is_material_field(const fs::path& file) { return file.extension() == ".npz" || file.extension() == ".ply"; }

MaterialFile read_material_field(const fs::path& file) {
  const bool voxels = file.extension() == ".npz";
  const Columns columns = voxels ? read_voxels(file) : read_vertices(file);
  const auto column = [&](const char* name) -> const std::vector<double>& {
    const auto found = columns.find(name);
    if (found == columns.end())
      throw input_error(file.string(), name, "is missing",
                        voxels ? "x, y, z, youngs_modulus, poissons_ratio and density are needed"
                               : "x, y, z, E, nu and density are needed");
    return found->second;
  };
  const std::vector<double>&young = column(voxels ? "youngs_modulus" : "E"),
        &poisson = column(voxels ? "poissons_ratio" : "nu"), &density = column("density");
  const std::vector<double>&x = column("x"), &y = column("y"), &z = column("z");
  if (young.empty()) throw input_error(file.string(), "", "has no points", "give a field with at least one");
  MaterialFile m;
  for (size_t i = 0; i < young.size(); ++i) {
    const auto refuse = [&](const char* name, double value) {
      return input_error(file.string(), name, fmt::format("is {} in row {}", value, i), "remove that row");
    };
    m.position.push_back(Eigen::Vector3d(x[i], y[i], z[i]).cast<float>());
    if (!m.position.back().allFinite()) throw refuse("x, y, z", NAN);
    if (!(young[i] > 0) || !std::isfinite(young[i])) throw refuse(voxels ? "youngs_modulus" : "E", young[i]);
    if (!(poisson[i] > -1 && poisson[i] < 0.5)) throw refuse(voxels ? "poissons_ratio" : "nu", poisson[i]);
    if (!(density[i] > 0) || !std::isfinite(density[i])) throw refuse("density", density[i]);
  }
  m.young = floats_of(young);
  m.poisson = floats_of(poisson);
  m.density = floats_of(density);
  m.source = voxels ? "VoMP" : "PLY";
  return m;
}

std::vector<Vec3f> placed_in(const fs::path& file, const std::vector<Vec3f>& positions,
                             const std::vector<Vec3f>& object) {
  const Eigen::AlignedBox3f from = box_of(positions), to = box_of(object);
  const float largest = to.sizes().maxCoeff();
  if (distance_of(from, to) < kSameBox * largest) return positions;
  const float scale = largest / std::max(from.sizes().maxCoeff(), 1e-20f);
  if ((scale * from.sizes() - to.sizes()).cwiseAbs().maxCoeff() > kSameShape * largest)
    throw input_error(file.string(), "x, y, z",
                      "fill a box of " + box_text(from) + ", but the object's is " + box_text(to),
                      "give the field of this object, with the axes of the scene");
  std::vector<Vec3f> out;
  for (const Vec3f& x : positions) out.push_back(to.center() + scale * (x - from.center()));
  return out;
}

void check_place(const fs::path& file, const std::string& field, const std::vector<Vec3f>& positions,
                 const std::vector<Vec3f>& object) {
  const Eigen::AlignedBox3f from = box_of(positions), to = box_of(object);
  if (distance_of(from, to) <= kSamePlace * to.sizes().maxCoeff()) return;
  const auto text = [](const Eigen::AlignedBox3f& box) {
    const Vec3f centre = box.center();
    return fmt::format("{} around ({:.3g}, {:.3g}, {:.3g})", box_text(box), centre.x(), centre.y(), centre.z());
  };
  throw input_error(file.string(), field, fmt::format("fill a box of {}, but the object's is {}", text(from), text(to)),
                    "give positions of this object in the units and axes of the scene");
}

void write_material_field(const fs::path& file, const MaterialFile& m) {
  CHECK(!m.position.empty() && m.position.size() == m.young.size());
  std::vector<std::vector<float>> place(3);
  if (file.extension() == ".npz") {
    const Eigen::AlignedBox3f box = box_of(m.position);
    const float scale = 1 / std::max(box.sizes().maxCoeff(), 1e-20f);
    for (const Vec3f& x : m.position)
      for (int k = 0; k < 3; ++k) place[k].push_back(scale * (x - box.center())[k]);
    write_zip(file, "voxel_data.npy",
              npy_of_columns({{"x", place[0]},
                              {"y", place[1]},
                              {"z", place[2]},
                              {"youngs_modulus", m.young},
                              {"poissons_ratio", m.poisson},
                              {"density", m.density}}));
  } else if (file.extension() == ".ply") {
    std::string out = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", m.young.size());
    for (const char* name : {"x", "y", "z", "density", "E", "nu"}) out += fmt::format("property float {}\n", name);
    out += "end_header\n";
    for (size_t i = 0; i < m.young.size(); ++i)
      for (const float value :
           {m.position[i].x(), m.position[i].y(), m.position[i].z(), m.density[i], m.young[i], m.poisson[i]})
        out.append(reinterpret_cast<const char*>(&value), sizeof value);
    write_text(file, out);
  } else {
    throw usage_error("--material", file.string(), "is neither .npz nor .ply", "end the name with .npz or .ply");
  }
}

}  // namespace pliant
