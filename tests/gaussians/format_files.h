#pragma once

#include <gtest/gtest.h>
#include <minizip/zip.h>
#include <webp/encode.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/random.h"
#include "tests/temporary_folder.h"

namespace pliant {

/// Random Gaussians whose values lie inside the range of every format.
inline GaussianCloud some_gaussians(int n, int degree, uint64_t seed = 5) {
  GaussianCloud cloud;
  cloud.sh_degree = degree;
  cloud.resize(n);
  Random random(seed);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      cloud.position[i][k] = random.uniform(-1.5, 2);
      cloud.log_scale[i][k] = random.uniform(-8, 1);
    }
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = random.normal();
    cloud.opacity_logit[i] = random.uniform(-4, 4);
    for (int k = 0; k < cloud.sh_count() * 3; ++k) cloud.sh_of(i)[k] = random.uniform(-0.9, 0.9);
  }
  return cloud;
}

/// Largest angle between the rotations of two clouds, radians.
inline double largest_angle(const GaussianCloud& a, const GaussianCloud& b) {
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double cosine =
        std::abs(a.rotation[i].cast<double>().normalized().dot(b.rotation[i].cast<double>().normalized()));
    largest = std::max(largest, 2 * std::acos(std::min(cosine, 1.0)));
  }
  return largest;
}

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::string gzip(const std::string& bytes) {
  z_stream z = {};
  EXPECT_EQ(deflateInit2(&z, 6, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(deflateBound(&z, bytes.size()), '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&z, Z_FINISH), Z_STREAM_END);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

/// Lossless WebP of width x height pixels of R, G, B, A.
inline std::string webp(const std::vector<uint8_t>& rgba, int width, int height) {
  EXPECT_EQ(rgba.size(), 4u * width * height);
  WebPConfig config;
  WebPConfigInit(&config);
  config.lossless = 1;
  config.exact = 1;
  config.method = 0;
  config.quality = 0;
  WebPPicture picture;
  WebPPictureInit(&picture);
  picture.use_argb = 1;
  picture.width = width;
  picture.height = height;
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  EXPECT_TRUE(WebPPictureImportRGBA(&picture, rgba.data(), 4 * width));
  EXPECT_TRUE(WebPEncode(&config, &picture));
  const std::string out(reinterpret_cast<const char*>(writer.mem), writer.size);
  WebPPictureFree(&picture);
  WebPMemoryWriterClear(&writer);
  return out;
}

using Entries = std::vector<std::pair<std::string, std::string>>;

inline std::filesystem::path write_zip(const std::filesystem::path& file, const Entries& entries, int level = 0) {
  const zipFile zip = zipOpen(file.c_str(), APPEND_STATUS_CREATE);
  for (const auto& [name, bytes] : entries) {
    zip_fileinfo info = {};
    EXPECT_EQ(
        zipOpenNewFileInZip(zip, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, level ? Z_DEFLATED : 0, level),
        ZIP_OK);
    zipWriteInFileInZip(zip, bytes.data(), static_cast<unsigned>(bytes.size()));
    zipCloseFileInZip(zip);
  }
  zipClose(zip, nullptr);
  return file;
}

/// Calls read(file) for the file cut at every `step`-th place and with every `step`-th byte changed; each call must end
/// in success or an Error.  Returns how many raised an Error.
template <class Read>
int errors_of_damaged(const TemporaryFolder& folder, const std::string& name, const std::string& good, size_t step,
                      Read&& read) {
  int errors = 0;
  const auto attempt = [&](const std::string& bytes) {
    try {
      read(folder.file(name, bytes));
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(folder.path().string()), std::string::npos) << error.what();
      ++errors;
    }
  };
  for (size_t at = 0; at < good.size(); at += step) {
    attempt(good.substr(0, at));
    for (const int change : {1, 128, 255}) {
      std::string bytes = good;
      bytes[at] = static_cast<char>(bytes[at] ^ change);
      attempt(bytes);
    }
  }
  return errors;
}

/// The folder of real scenes, $PLIANT_DATA or ../shared/data of the checkout or of the folder around it; empty when
/// there is none.
std::filesystem::path real_data();

/// Skips the test, and says so, where a real file is absent.
#define REQUIRE_REAL(path)                                                                          \
  do {                                                                                              \
    if (real_data().empty() || !std::filesystem::exists(path))                                      \
      GTEST_SKIP() << "real scenes are absent: " << (path) << " (set PLIANT_DATA to their folder)"; \
  } while (false)

}  // namespace pliant
