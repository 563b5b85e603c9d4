#include "app/page/clip_file.h"

#include <type_traits>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/io/files/base64.h"
#include "gaussians/io/files/compression.h"

namespace pliant {
namespace {

template <class V>
std::string type_name() {
  const std::string bits = std::to_string(8 * sizeof(V));
  if (std::is_floating_point_v<V>) return "f" + bits;
  return (std::is_signed_v<V> ? "i" : "u") + bits;
}

}  // namespace

template <class V>
void ClipFile::add(const std::string& section, const std::string& name, const std::vector<size_t>& shape,
                   std::span<const V> values, const std::vector<double>& range) {
  size_t count = 1;
  for (const size_t extent : shape) count *= extent;
  CHECK_MSG(count == values.size(), "shape of a clip's array");
  std::string& bytes = sections[section];
  constexpr size_t kAlign = sizeof(V) > 4 ? sizeof(V) : 4;  // views of typed arrays begin at multiples of their size
  bytes.resize((bytes.size() + kAlign - 1) / kAlign * kAlign);
  nlohmann::json row = {
      {"name", name}, {"section", section}, {"offset", bytes.size()}, {"type", type_name<V>()}, {"shape", shape}};
  if (!range.empty()) {
    row["low"] = range.at(0);
    row["high"] = range.at(1);
  }
  header["arrays"].push_back(std::move(row));
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

template void ClipFile::add(const std::string&, const std::string&, const std::vector<size_t>&,
                            std::span<const uint8_t>, const std::vector<double>&);
template void ClipFile::add(const std::string&, const std::string&, const std::vector<size_t>&,
                            std::span<const uint16_t>, const std::vector<double>&);
template void ClipFile::add(const std::string&, const std::string&, const std::vector<size_t>&,
                            std::span<const uint32_t>, const std::vector<double>&);
template void ClipFile::add(const std::string&, const std::string&, const std::vector<size_t>&, std::span<const float>,
                            const std::vector<double>&);
template void ClipFile::add(const std::string&, const std::string&, const std::vector<size_t>&, std::span<const double>,
                            const std::vector<double>&);

size_t SectionPacker::pack(const ClipFile& file) {
  std::vector<Section*> changed;
  for (const auto& [name, bytes] : file.sections) {
    Section& section = known_[name];
    if (section.bytes == bytes && !section.packed.empty()) continue;
    section.bytes = bytes;
    changed.push_back(&section);
  }
  parallel_for(
      static_cast<std::ptrdiff_t>(changed.size()),
      [&](std::ptrdiff_t k) { changed[k]->packed = base64(zlib_compressed(changed[k]->bytes)); }, 1);
  size_t size = 0;
  for (const auto& [name, bytes] : file.sections) size += packed(name).size();
  return size;
}

}  // namespace pliant
