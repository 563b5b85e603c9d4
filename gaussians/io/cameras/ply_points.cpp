#include "gaussians/io/cameras/ply_points.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply_header.h"
#include "gaussians/io/splats/ply_rows.h"

namespace fs = std::filesystem;

namespace pliant {

SparsePoints read_ply_points(const fs::path& file) {
  SparsePoints points;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw input_error(file.string(), "", "cannot be opened", "check its permissions");
  const PlyHeader header = read_ply_header(in, file);
  const PlyElement* vertex = header.find("vertex");
  int column[6];
  const char* names[] = {"x", "y", "z", "red", "green", "blue"};
  for (int k = 0; k < 6; ++k) {
    column[k] = vertex ? vertex->find(names[k]) : -1;
    if (k < 3 && column[k] < 0)
      throw input_error(file.string(), std::string("property ") + names[k], "is missing", "give a point cloud");
  }
  if (vertex->has_list()) throw input_error(file.string(), "element vertex", "holds a list", "give a point cloud");
  const bool colored = column[3] >= 0 && column[4] >= 0 && column[5] >= 0;
  float largest = 0;  // of the colors
  for (const PlyElement& element : header.elements) {
    PlyRows rows(in, header, element, file.string(), fs::file_size(file));
    if (&element != vertex) {
      rows.skip();
      continue;
    }
    rows.check_size();
    rows.for_each_row([&](const float* row) {
      const Vec3f x(row[column[0]], row[column[1]], row[column[2]]);
      if (!x.allFinite()) return;
      Vec3f color = Vec3f::Zero();
      for (int k = 0; k < 3 && colored; ++k)
        if (const float value = row[column[3 + k]]; std::isfinite(value)) color[k] = value;
      largest = std::max(largest, color.maxCoeff());
      points.position.push_back(x);
      points.color.push_back(color);
    });
    break;
  }
  const float full = colored ? ply_full_color(vertex->properties[column[3]].type, largest) : 1;
  for (Vec3f& color : points.color)
    color = colored ? Vec3f((color / full).cwiseMax(0.0f).cwiseMin(1.0f)) : Vec3f(Vec3f::Constant(0.5f));
  if (const uint64_t skipped = vertex->count - points.position.size(); skipped > 0)
    points.warnings.push_back(file.string() + ": " + std::to_string(skipped) + " of " + std::to_string(vertex->count) +
                              " points have a position that is not finite and are left out");
  points.file = file;
  points.source = std::to_string(points.position.size()) + " points of " + file.string();
  return points;
}

void write_ply_points(const fs::path& file, const SparsePoints& points) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points.position.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                      "property uchar green\nproperty uchar blue\nend_header\n";
  for (size_t i = 0; i < points.position.size(); ++i) {
    bytes.append(reinterpret_cast<const char*>(points.position[i].data()), 3 * sizeof(float));
    for (int c = 0; c < 3; ++c) bytes.push_back(static_cast<char>(std::lround(255 * points.color[i][c])));
  }
  write_text(file, bytes);
}

}  // namespace pliant
