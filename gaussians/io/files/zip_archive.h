#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Reads files out of a zip archive.  Sizes, offsets and checksums are verified; entries whose data overlap are
/// refused.  Throws Error{kInput} naming the archive and the entry.
class ZipArchive {
 public:
  explicit ZipArchive(const std::filesystem::path& file);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;

  /// Names of the entries, in the order of the archive's directory; at most 65536 are listed.
  std::vector<std::string> names();
  /// Contents of the entry, which may have at most `most` bytes.
  std::string read(const std::string& entry, uint64_t most);

 private:
  std::string file_;
  uint64_t file_bytes_ = 0;
  void* zip_ = nullptr;
  std::vector<std::pair<uint64_t, uint64_t>> taken_;  // begin and end of the data of the entries read
};

/// Writes an archive with one entry, stored as it is; atomic, and equal contents give equal bytes.  Throws
/// Error{kInput} naming the file.
void write_zip(const std::filesystem::path& file, const std::string& entry, const std::string& bytes);

}  // namespace pliant
