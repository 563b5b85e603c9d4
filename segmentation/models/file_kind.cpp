#include "segmentation/models/file_kind.h"

#include <algorithm>
#include <cstdint>

#include "gaussians/io/files/text.h"

namespace pliant {
namespace {

struct Signature {
  size_t at;
  std::string_view bytes;
  const char* kind;
};

constexpr Signature kSignatures[] = {
    {0, "\x89PNG\r\n\x1a\n", "a PNG image"},
    {0, "\xff\xd8\xff", "a JPEG image"},
    {0, "GIF8", "a GIF image"},
    {8, "WEBP", "a WebP image"},
    {4, "ftyp", "a video (MP4)"},
    {0, "\x1a\x45\xdf\xa3", "a video (Matroska, WebM)"},
    {0, "\x89HDF\r\n\x1a\n", "an HDF5 file"},
    {4, "TFL3", "a TensorFlow Lite network"},
    {0, "GGUF", "a GGUF file"},
    {0, "\x80\x02", "a Python pickle, as written by old versions of torch.save: weights without the network"},
    {0, "version https://git-lfs", "a Git LFS pointer, whose file has not been downloaded"},
    {0, "ply\n", "a PLY file"},
    {0, "ply\r", "a PLY file"},
    {0, "%PDF", "a PDF document"},
    {0,
     "\x7f"
     "ELF",
     "a program or library"},
    {0, "\x1f\x8b", "compressed with gzip"},
    {0,
     "\xfd"
     "7zXZ",
     "compressed with xz"},
    {0, "\x28\xb5\x2f\xfd", "compressed with zstd"},
    {257, "ustar", "a tar archive"},
};

/// safetensors: the length of a JSON object in eight bytes, then that.
bool is_safetensors(std::string_view bytes) {
  if (bytes.size() < 10) return false;
  uint64_t length = 0;
  for (int k = 7; k >= 0; --k) length = length << 8 | static_cast<uint8_t>(bytes[k]);
  return bytes.substr(8, 2) == "{\"" && length <= bytes.size() - 8;
}

}  // namespace

std::string kind_of_file(std::string_view bytes) {
  if (bytes.empty()) return "an empty file";
  for (const Signature& signature : kSignatures)
    if (bytes.size() > signature.at && bytes.substr(signature.at, signature.bytes.size()) == signature.bytes)
      return signature.kind;
  if (is_safetensors(bytes)) return "a safetensors file: weights without the network";
  const std::string_view head = bytes.substr(0, 4096);
  const bool text = std::none_of(head.begin(), head.end(), [](char c) {
    const auto byte = static_cast<uint8_t>(c);
    return byte == 127 || (byte < 32 && (byte < 9 || byte > 13)) || byte >= 0xf8 || byte == 0xc0 || byte == 0xc1;
  });
  if (!text) return "";
  const size_t first = std::min(head.find_first_not_of(" \t\r\n"), head.size());
  const std::string begin = lower_case(head.substr(first, 14));
  if (begin.starts_with("<!doctype html") || begin.starts_with("<html")) return "a web page";
  if (begin.starts_with("{") || begin.starts_with("[{")) return "a text file (JSON)";
  return "a text";
}

}  // namespace pliant
