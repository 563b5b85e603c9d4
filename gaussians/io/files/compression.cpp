#include "gaussians/io/files/compression.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr uint64_t kMostExpansion = 256;   // splat data shrink 2 to 20 times
constexpr uint64_t kSmallScene = 1 << 20;  // bytes that need no justification
constexpr int kZstdLevel = 12;

}  // namespace

void check_expansion(uint64_t promised_bytes, uint64_t file_bytes, const std::string& file, const std::string& field) {
  if (promised_bytes <= kSmallScene || promised_bytes / kMostExpansion <= file_bytes) return;
  throw input_error(
      file, field,
      "declares " + std::to_string(promised_bytes) + " bytes of data in a file of " + std::to_string(file_bytes),
      "the header is wrong, or the file is meant to exhaust the memory");
}

struct GzipReader::Stream {
  z_stream z = {};
  bool ended = false;
};

GzipReader::GzipReader(std::string_view compressed, std::string file) : stream_(new Stream), file_(std::move(file)) {
  stream_->z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(compressed.data()));
  stream_->z.avail_in = static_cast<uInt>(std::min<size_t>(compressed.size(), UINT32_MAX));
  CHECK(inflateInit2(&stream_->z, 16 + MAX_WBITS) == Z_OK);
}

GzipReader::~GzipReader() {
  inflateEnd(&stream_->z);
  delete stream_;
}

size_t GzipReader::read_some(std::span<char> out, const std::string& field) {
  size_t done = 0;
  while (done < out.size() && !stream_->ended) {
    const auto piece = static_cast<uInt>(std::min<size_t>(out.size() - done, 1u << 30));
    stream_->z.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    stream_->z.avail_out = piece;
    const int status = inflate(&stream_->z, Z_NO_FLUSH);
    done += piece - stream_->z.avail_out;
    stream_->ended = status == Z_STREAM_END;
    if (status == Z_OK || status == Z_STREAM_END) continue;
    throw input_error(file_, field,
                      status == Z_BUF_ERROR ? "the compressed data end early" : "the compressed data are damaged",
                      "the file is truncated or damaged; fetch it again");
  }
  return done;
}

void GzipReader::read(std::span<char> out, const std::string& field) {
  const size_t done = read_some(out, field);
  if (done == out.size()) return;
  throw input_error(
      file_, field,
      "the header declares " + std::to_string(out.size()) + " bytes but only " + std::to_string(done) + " follow",
      "the file is truncated or its header is wrong");
}

std::string GzipReader::rest(size_t most, const std::string& field) {
  std::string bytes(most + 1, '\0');
  bytes.resize(read_some(bytes, field));
  if (bytes.size() > most) {
    throw input_error(file_, field, "more data follow than the header justifies", "the header is wrong");
  }
  return bytes;
}

void decompress_zstd(std::string_view compressed, std::span<char> out, const std::string& file,
                     const std::string& field) {
  const size_t done = ZSTD_decompress(out.data(), out.size(), compressed.data(), compressed.size());
  if (ZSTD_isError(done)) {
    throw input_error(file, field, std::string("the compressed data are damaged: ") + ZSTD_getErrorName(done),
                      "the file is truncated or damaged; fetch it again");
  }
  if (done == out.size()) return;
  throw input_error(
      file, field,
      "the header declares " + std::to_string(out.size()) + " bytes but only " + std::to_string(done) + " follow",
      "the file is truncated or its header is wrong");
}

std::string compress_zstd(std::string_view bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kZstdLevel);
  CHECK_MSG(!ZSTD_isError(size), ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

std::string zlib_compressed(const std::string& bytes) {
  constexpr int kLevel = 6;
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  CHECK(compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                  bytes.size(), kLevel) == Z_OK);
  packed.resize(size);
  return packed;
}

}  // namespace pliant
