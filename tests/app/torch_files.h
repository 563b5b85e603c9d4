#pragma once

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

inline std::string little_endian(uint64_t value, int bytes) {
  std::string out;
  for (int k = 0; k < bytes; ++k) out += static_cast<char>(k < 8 ? value >> (8 * k) & 255 : 0);
  return out;
}

/// A zip archive whose entries are stored, as torch.save writes it.
inline std::string zip_archive(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string data, directory;
  for (const auto& [name, bytes] : entries) {
    const auto sum = crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
    const std::string common = little_endian(0, 2) + little_endian(0, 2) + little_endian(0, 4) + little_endian(sum, 4) +
                               little_endian(bytes.size(), 4) + little_endian(bytes.size(), 4) +
                               little_endian(name.size(), 2) + little_endian(0, 2);
    directory += "PK\x01\x02" + little_endian(20, 2) + little_endian(20, 2) + common + little_endian(0, 10) +
                 little_endian(data.size(), 4) + name;
    data += "PK\x03\x04" + little_endian(20, 2) + common + name + bytes;
  }
  return data + directory + "PK\x05\x06" + little_endian(0, 4) + little_endian(entries.size(), 2) +
         little_endian(entries.size(), 2) + little_endian(directory.size(), 4) + little_endian(data.size(), 4) +
         little_endian(0, 2);
}

inline std::string pickled(const std::string& text) { return "X" + little_endian(text.size(), 4) + text; }
inline std::string pickled(int64_t number) {
  if (number >= 0 && number < 256) return "K" + little_endian(static_cast<uint64_t>(number), 1);
  return "J" + little_endian(static_cast<uint64_t>(number), 4);
}
inline std::string pickled(const std::vector<int64_t>& numbers) {
  std::string out = "(";
  for (int64_t number : numbers) out += pickled(number);
  return out + "t";
}

/// The call that rebuilds a tensor over storage `key`.
inline std::string tensor_pickle(const std::string& type, int key, int64_t count, int64_t offset,
                                 const std::vector<int64_t>& shape, const std::vector<int64_t>& stride) {
  return "ctorch._utils\n_rebuild_tensor_v2\n((" + pickled("storage") + "ctorch\n" + type + "\n" +
         pickled(std::to_string(key)) + pickled("cuda:0") + pickled(count) + "tQ" + pickled(offset) + pickled(shape) +
         pickled(stride) + "\x89" + "ccollections\nOrderedDict\n)RtR";
}

/// An OrderedDict with the `_metadata` attribute that state dicts have.
inline std::string pickle_of(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string out = std::string("\x80\x02", 2) + "ccollections\nOrderedDict\n" + std::string("q\0", 2) + ")Rq\x01(";
  for (const auto& [name, value] : entries) out += pickled(name) + value;
  return out + "u}" + pickled("_metadata") + std::string("h\0", 2) + ")R(" + pickled("") + "}" + pickled("version") +
         "K\x01susb.";
}

/// State dict of Conv2d(inputs -> classes, 1 x 1) with its weight in storage 0 and its bias in storage 1.
inline std::string conv_pickle(int64_t classes, int64_t inputs) {
  return pickle_of(
      {{"weight", tensor_pickle("FloatStorage", 0, classes * inputs, 0, {classes, inputs, 1, 1}, {inputs, 1, 1, 1})},
       {"bias", tensor_pickle("FloatStorage", 1, classes, 0, {classes}, {1})}});
}

inline std::string floats(const std::vector<float>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
}

inline std::string torch_archive(const std::string& name, const std::string& pickle,
                                 const std::vector<std::string>& storages) {
  std::vector<std::pair<std::string, std::string>> entries = {{name + "/data.pkl", pickle}};
  for (size_t k = 0; k < storages.size(); ++k) entries.emplace_back(name + "/data/" + std::to_string(k), storages[k]);
  entries.emplace_back(name + "/version", "3\n");
  return zip_archive(entries);
}

}  // namespace pliant
