#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace pliant {

/// SHA-256 of a stream of bytes (FIPS 180-4).
class Sha256 {
 public:
  void add(const void* bytes, size_t count);
  /// Digest in lower-case hex; nothing may be added afterwards.
  std::string hex();

 private:
  void compress(const uint8_t* block);

  std::array<uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                    0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<uint8_t, 64> block_{};
  size_t filled_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace pliant
