#include "fitting/distribution/safetensors.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "gaussians/io/files/byte_reader.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

namespace pliant {
namespace {

using nlohmann::json;
constexpr uint64_t kLongestHeader = 1 << 20;

std::string name_of(const std::vector<int64_t>& shape) {
  std::string out = "[";
  for (const int64_t n : shape) out += (out.size() > 1 ? ", " : "") + std::to_string(n);
  return out + "]";
}

/// First byte and the one behind the last of each array that was parsed.
using Places = std::vector<std::pair<uint64_t, uint64_t>>;

SafeTensors::Array parse_array(const std::string& name, const json& entry, std::string_view data,
                               const std::string& file, Places& places) {
  const auto fail = [&](const std::string& problem) {
    return input_error(file, name, problem, "the file is damaged or of another program; use the bundled weights");
  };
  if (!entry.is_object() || !entry.contains("dtype") || !entry.contains("shape") || !entry.contains("data_offsets"))
    throw fail("has no dtype, shape or data_offsets");
  if (entry["dtype"] != "F32") throw fail("has type " + entry["dtype"].dump() + ", not F32");
  const json &shape = entry["shape"], &offsets = entry["data_offsets"];
  if (!shape.is_array() || shape.size() > 8 || !offsets.is_array() || offsets.size() != 2)
    throw fail("has no such shape");
  SafeTensors::Array array;
  uint64_t count = 1;
  for (const json& n : shape) {
    if (!n.is_number_unsigned() || n.get<uint64_t>() > data.size()) throw fail("has an impossible shape");
    array.shape.push_back(n.get<int64_t>());
    count *= n.get<uint64_t>();
    if (count > data.size()) throw fail("is larger than the file");
  }
  if (!offsets[0].is_number_unsigned() || !offsets[1].is_number_unsigned()) throw fail("has no such offsets");
  const uint64_t begin = offsets[0], end = offsets[1];
  if (begin > end || end > data.size()) throw fail("lies beyond the end of the file, which is truncated");
  if (end - begin != 4 * count)
    throw fail("has " + std::to_string(end - begin) + " bytes for the shape " + name_of(array.shape));
  for (const auto& [from, to] : places)
    if (begin < to && from < end) throw fail("shares bytes with another array");
  places.emplace_back(begin, end);
  array.values.resize(count);
  if (count) std::memcpy(array.values.data(), data.data() + begin, 4 * count);
  return array;
}

}  // namespace

const std::vector<float>& SafeTensors::values(const std::string& name, const std::vector<int64_t>& shape,
                                              const std::string& file) const {
  const auto found = arrays.find(name);
  if (found == arrays.end()) throw input_error(file, name, "is missing", "these are not the weights of this network");
  if (found->second.shape != shape)
    throw input_error(file, name, "has the shape " + name_of(found->second.shape) + ", not " + name_of(shape),
                      "these are not the weights of this network");
  return found->second.values;
}

const std::string& SafeTensors::text(const std::string& name, const std::string& file) const {
  const auto found = metadata.find(name);
  if (found == metadata.end())
    throw input_error(file, "__metadata__." + name, "is missing", "these are not the weights of this network");
  return found->second;
}

SafeTensors parse_safetensors(std::string_view bytes, const std::string& file) {
  ByteReader reader(bytes, file);
  const uint64_t length = reader.take<uint64_t>("header length");
  if (length > kLongestHeader)
    throw input_error(file, "header length", "is " + std::to_string(length), "this is no safetensors file of ours");
  const json header = parse_json(std::string(reader.take_bytes(length, "header")), file, "header");
  if (!header.is_object()) throw input_error(file, "header", "is not a JSON object", "this is no safetensors file");
  const std::string_view data = reader.take_bytes(reader.left(), "data");
  SafeTensors out;
  Places places;
  for (const auto& [name, entry] : header.items()) {
    if (name != "__metadata__") {
      out.arrays[name] = parse_array(name, entry, data, file, places);
      continue;
    }
    if (!entry.is_object()) throw input_error(file, name, "is not a JSON object", "the file is damaged");
    for (const auto& [key, value] : entry.items()) {
      if (!value.is_string()) throw input_error(file, name + "." + key, "is no text", "the file is damaged");
      out.metadata[key] = value.get<std::string>();
    }
  }
  return out;
}

SafeTensors read_safetensors(const std::filesystem::path& file) {
  return parse_safetensors(read_text(file), file.string());
}

void write_safetensors(const std::filesystem::path& file, const SafeTensors& content) {
  json header = json::object();
  if (!content.metadata.empty()) header["__metadata__"] = content.metadata;
  std::string data;
  for (const auto& [name, array] : content.arrays) {
    const size_t begin = data.size();
    data.append(reinterpret_cast<const char*>(array.values.data()), 4 * array.values.size());
    header[name] = {{"dtype", "F32"}, {"shape", array.shape}, {"data_offsets", {begin, data.size()}}};
  }
  std::string text = header.dump();
  text.resize((text.size() + 7) / 8 * 8, ' ');  // so that the data are aligned
  const uint64_t length = text.size();
  std::string bytes(reinterpret_cast<const char*>(&length), sizeof length);
  write_text(file, bytes + text + data);
}

}  // namespace pliant
