#include "app/import/physdreamer_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "app/import/state_dict.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

std::string text_of(const std::vector<int64_t>& shape) {
  std::string out;
  for (const int64_t n : shape) out += (out.empty() ? "" : " x ") + std::to_string(n);
  return out;
}

/// Names in an order in which numbers count as numbers.
bool before(const std::string& a, const std::string& b) {
  size_t i = 0, j = 0;
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      size_t m = i, n = j;
      while (m < a.size() && digit(a[m])) ++m;
      while (n < b.size() && digit(b[n])) ++n;
      const int x = std::stoi(a.substr(i, std::min<size_t>(m - i, 9))),
                y = std::stoi(b.substr(j, std::min<size_t>(n - j, 9)));
      if (x != y) return x < y;
      i = m;
      j = n;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

}  // namespace

PhysDreamerField read_physdreamer_field(const std::filesystem::path& file, int channels) {
  const std::map<std::string, StateTensor> tensors = read_state_dict(file);
  std::vector<std::string> names;
  for (const auto& [name, tensor] : tensors) names.push_back(name);
  std::sort(names.begin(), names.end(), before);
  const auto refused = [&](const std::string& name, const std::string& problem) {
    return input_error(file.string(), name, problem,
                       "it must be a field of PhysDreamer: three planes and linear layers");
  };

  PhysDreamerField field;
  field.channels = channels;
  int planes = 0;
  for (const std::string& name : names) {
    const StateTensor& t = tensors.at(name);
    const size_t d = t.shape.size();
    if (d != 3 && d != 4) continue;
    if ((d == 4 && t.shape[0] != 1) || t.shape[d - 2] != t.shape[d - 1])
      throw refused(name, "has the shape " + text_of(t.shape) + ", which is not a feature plane");
    if (planes == 0) {
      field.features = static_cast<int>(t.shape[d - 3]);
      field.resolution = static_cast<int>(t.shape[d - 2]);
    }
    if (t.shape[d - 3] != field.features || t.shape[d - 2] != field.resolution)
      throw refused(name, "has the shape " + text_of(t.shape) + ", unlike the previous plane");
    field.parameters.insert(field.parameters.end(), t.data.begin(), t.data.end());
    ++planes;
  }
  if (planes != 3) throw refused("", fmt::format("has {} feature planes, 3 are needed", planes));
  if (const auto box = tensors.find("aabb"); box != tensors.end()) {
    const StateTensor& t = box->second;
    if (t.shape != std::vector<int64_t>{2, 3})
      throw refused("aabb", "has the shape " + text_of(t.shape) + ", but a box has 2 x 3");
    for (size_t a = 0; a < 3; ++a)
      if (!(t.data[a] < t.data[a + 3])) throw refused("aabb", "has a low end that is not below its high end");
    field.box = {Vec3d(t.data[0], t.data[1], t.data[2]), Vec3d(t.data[3], t.data[4], t.data[5])};
  }

  int64_t width = field.features;
  for (const std::string& name : names) {
    const StateTensor& weight = tensors.at(name);
    const size_t end = name.rfind("weight");
    if (weight.shape.size() != 2 || end == std::string::npos || end + 6 != name.size()) continue;
    const auto bias = tensors.find(name.substr(0, end) + "bias");
    if (weight.shape[1] != width)
      throw refused(name, fmt::format("has the shape {}, but its input has {} values", text_of(weight.shape), width));
    if (bias == tensors.end() || bias->second.shape != std::vector<int64_t>{weight.shape[0]})
      throw refused(name, "has no bias of its size");
    if (field.layers > 0 && field.hidden > 0 && weight.shape[1] != field.hidden)
      throw refused(name, "follows layers of another width");
    width = weight.shape[0];
    if (field.layers == 0) field.hidden = static_cast<int>(width);
    field.parameters.insert(field.parameters.end(), weight.data.begin(), weight.data.end());
    field.parameters.insert(field.parameters.end(), bias->second.data.begin(), bias->second.data.end());
    ++field.layers;
  }
  if (field.layers == 0) throw refused("", "has no linear layer");
  if (width != channels) throw refused("", fmt::format("outputs {} values per point, {} are needed", width, channels));
  return field;
}

}  // namespace pliant
