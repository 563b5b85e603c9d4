#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace pliant {

/// Refuses a header that promises more than any real file of `file_bytes` bytes holds (256 bytes for each, and a
/// mebibyte), before anything is allocated.  Throws Error{kInput} naming file and field.
void check_expansion(uint64_t promised_bytes, uint64_t file_bytes, const std::string& file, const std::string& field);

/// Decompresses a gzip stream piece by piece, so that its own header can be judged first.
class GzipReader {
 public:
  GzipReader(std::string_view compressed, std::string file);
  ~GzipReader();
  GzipReader(const GzipReader&) = delete;

  /// Fills `out`.  Throws Error{kInput} naming `field` when the stream is damaged or ends early.
  void read(std::span<char> out, const std::string& field);
  /// What follows, up to the end of the stream, whose checksum is verified.  More than `most` bytes are an error.
  std::string rest(size_t most, const std::string& field);

 private:
  /// Bytes written, fewer than asked for only at the end of the stream.
  size_t read_some(std::span<char> out, const std::string& field);

  struct Stream;
  Stream* stream_;
  std::string file_;
};

/// Decompresses one Zstandard frame that holds exactly out.size() bytes.
void decompress_zstd(std::string_view compressed, std::span<char> out, const std::string& file,
                     const std::string& field);
std::string compress_zstd(std::string_view bytes);

/// Compresses bytes as a zlib stream (RFC 1950).
std::string zlib_compressed(const std::string& bytes);

}  // namespace pliant
