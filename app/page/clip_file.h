#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Numbers of a clip.html: sections of bytes, which the page unpacks one after the other, and a header that names the
/// arrays in them and how to read them.
struct ClipFile {
  nlohmann::json header = {{"format", "pliant-clip"}, {"version", 1}, {"arrays", nlohmann::json::array()}};
  std::map<std::string, std::string> sections;  ///< as they are in memory

  /// Appends an array to a section.  `values` [product of shape] of uint8, uint16, uint32, float or double;
  /// with a range, integers q of b bits stand for low + q (high - low) / (2^b - 1).
  template <class V>
  void add(const std::string& section, const std::string& name, const std::vector<size_t>& shape,
           std::span<const V> values, const std::vector<double>& range = {});
};

/// Sections as they are in the file: compressed (zlib, RFC 1950) and in base64.  Those that have not changed since they
/// were last asked for are not packed again.
class SectionPacker {
 public:
  /// Packs all sections; returns the bytes that they take.
  size_t pack(const ClipFile& file);
  /// Of a section that was packed.
  const std::string& packed(const std::string& section) const { return known_.at(section).packed; }

 private:
  struct Section {
    std::string bytes, packed;
  };
  std::map<std::string, Section> known_;
};

}  // namespace pliant
