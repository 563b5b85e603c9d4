// .spz and .splat: round trips within the steps of the quantisers, every version read as it is specified, and hostile
// files.

#include <gtest/gtest.h>

#include "gaussians/io/files/compression.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/half_turn.h"
#include "gaussians/io/splats/splat_file.h"
#include "gaussians/io/splats/splats.h"
#include "gaussians/io/splats/spz.h"
#include "gaussians/render/render.h"
#include "tests/gaussians/format_files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// Attributes of two Gaussians of degree 1 as the versions before 4 hold them: at (1, 2, 3) and (-1, -2, -3) / 4096 in
/// the file's axes, x right, y up, z back.
std::string legacy_spz(uint32_t version) {
  std::string bytes = "NGSP";
  put(bytes, version);
  put(bytes, uint32_t(2));
  bytes += std::string("\1\14\1\0", 4);  // degree 1, 12 fractional bits, antialiased
  for (int sign : {1, -1}) {
    for (int k = 1; k <= 3; ++k) {
      const int fixed = sign * k;
      if (version == 1)
        put(bytes, Eigen::half(fixed / 4096.0f).x);
      else
        bytes.append(reinterpret_cast<const char*>(&fixed), 3);
    }
  }
  bytes += std::string("\x40\xc0", 2);                                  // alpha
  for (int k = 0; k < 6; ++k) bytes += static_cast<char>(100 + k);      // colours
  for (int k = 0; k < 6; ++k) bytes += static_cast<char>(80 + 16 * k);  // scales
  if (version < 3) {
    bytes += std::string("\xff\x80\x80\x80\x80\x80", 6);  // nearly a half turn around x, and none
  } else {
    put(bytes, uint32_t(0));               // x largest
    put(bytes, uint32_t(3u << 30 | 511));  // w largest, z = 1 / sqrt(2)
  }
  for (int k = 0; k < 18; ++k) bytes += static_cast<char>(120 + k);
  return bytes;
}

TEST(HalfTurn, OfCloudAndCameraGivesTheSamePicture) {
  const GaussianCloud cloud = some_gaussians(60, 3);
  for (int axis = 0; axis < 3; ++axis) {
    GaussianCloud turned = cloud;
    turn_half(turned, axis);
    Camera camera = look_at({3, -2, 5}, {0.2, 0.3, 0.1}, {0, -1, 0}, 64, 48, 60), moved = camera;
    moved.cam_from_world = camera.cam_from_world * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::Unit(axis));
    const ImageF a = render(cloud, camera, {}).color, b = render(turned, moved, {}).color;
    float largest = 0;
    for (size_t i = 0; i < a.data.size(); ++i) largest = std::max(largest, std::abs(a.data[i] - b.data[i]));
    EXPECT_LT(largest, 1e-4f) << axis;
    turn_half(turned, axis);
    EXPECT_EQ(turned.position, cloud.position);
    EXPECT_EQ(turned.sh, cloud.sh);
  }
}

TEST(Spz, RoundTripStaysWithinTheStepsForEveryDegree) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const GaussianCloud cloud = some_gaussians(2000, degree);
    write_spz(folder / "a.spz", cloud, degree == 2);
    ReadReport report;
    const GaussianCloud back = read_spz(folder / "a.spz", &report);
    ASSERT_EQ(back.size(), cloud.size());
    EXPECT_EQ(back.sh_degree, degree);
    EXPECT_EQ(report.antialiased, degree == 2);
    EXPECT_EQ(report.format, "spz version 4, SH degree " + std::to_string(degree));
    EXPECT_TRUE(report.warnings.empty());
    for (size_t i = 0; i < cloud.size(); ++i) {
      EXPECT_LT((back.position[i] - cloud.position[i]).cwiseAbs().maxCoeff(), 0.51f / (1 << 21));
      EXPECT_LT((back.log_scale[i] - cloud.log_scale[i]).cwiseAbs().maxCoeff(), 0.501f / 16);
      EXPECT_LT(std::abs(sigmoid(back.opacity_logit[i]) - sigmoid(cloud.opacity_logit[i])), 0.501f / 255);
      for (int k = 0; k < 3 * cloud.sh_count(); ++k) {
        EXPECT_LT(std::abs(back.sh_of(i)[k] - cloud.sh_of(i)[k]), k < 3 ? 0.501f / 255 / 0.15f : 0.501f / 128);
      }
    }
    // Half a step in each of three components of magnitude 1 / sqrt(2) / 511, and what they move the fourth by.
    EXPECT_LT(largest_angle(cloud, back), 2 * 2 * std::sqrt(3.0) * 0.5 / 511 * M_SQRT1_2);
    write_spz(folder / "b.spz", back, report.antialiased);
    const GaussianCloud again = read_spz(folder / "b.spz");
    EXPECT_EQ(again.position, back.position);
    EXPECT_EQ(again.log_scale, back.log_scale);
    EXPECT_EQ(again.sh, back.sh);
  }
}

TEST(Spz, EveryOlderVersionIsReadWithAndWithoutGzip) {
  const TemporaryFolder folder;
  for (uint32_t version = 1; version <= 3; ++version) {
    for (const bool zipped : {false, true}) {
      SCOPED_TRACE(std::to_string(version) + (zipped ? " gzip" : ""));
      const std::string raw = legacy_spz(version);
      ReadReport report;
      const GaussianCloud cloud = read_spz(folder.file("a.spz", zipped ? gzip(raw) : raw), &report);
      ASSERT_EQ(cloud.size(), 2u);
      EXPECT_EQ(cloud.sh_degree, 1);
      EXPECT_TRUE(report.antialiased);
      // y and z are turned from up and back to down and forward.
      EXPECT_EQ(cloud.position[0], Vec3f(1, -2, -3) / 4096);
      EXPECT_EQ(cloud.position[1], Vec3f(-1, 2, 3) / 4096);
      EXPECT_NEAR(sigmoid(cloud.opacity_logit[0]), 64 / 255.0, 1e-6);
      EXPECT_EQ(cloud.log_scale[0], Vec3f(80, 96, 112) / 16 - Vec3f::Constant(10));
      EXPECT_NEAR(cloud.sh_of(0)[1], (101 / 255.0 - 0.5) / 0.15, 1e-6);
      // Degree 1 is ordered y, z, x; y and z change their sign.
      EXPECT_EQ(cloud.sh_of(0)[3], 8.0f / 128);
      EXPECT_EQ(cloud.sh_of(0)[6], 5.0f / 128);
      EXPECT_EQ(cloud.sh_of(0)[9], -2.0f / 128);
      const Vec4f expected = version < 3 ? Vec4f(0, 1, 0, 0) : Vec4f(0, 1, 0, 0);
      EXPECT_GT(std::abs(cloud.rotation[0].normalized().dot(expected)), 0.9999f);
      const Vec4f second = version < 3 ? Vec4f(1, 0, 0, 0) : Vec4f(1, 0, 0, -1).normalized();
      EXPECT_GT(std::abs(cloud.rotation[1].normalized().dot(second)), 0.9999f);
    }
  }
}

TEST(Spz, AnExtensionMayNameTheAxes) {
  const TemporaryFolder folder;
  const struct {
    uint32_t axes;
    Vec3f first;
  } cases[] = {{4, {1, -2, -3}}, {0, {1, -2, -3}}, {6, {1, 2, 3}}, {7, {-1, -2, 3}}, {1, {-1, 2, -3}}};
  for (const auto& one : cases) {
    std::string raw = legacy_spz(3);
    raw[14] = 2;
    put(raw, 0xADBE0002u);
    put(raw, uint32_t(12));
    raw += std::string(12, '\0');  // another extension
    put(raw, 0xADBE0003u);
    put(raw, uint32_t(4));
    put(raw, one.axes);
    EXPECT_EQ(read_spz(folder.file("a.spz", gzip(raw))).position[0], one.first / 4096) << one.axes;
  }
  std::string raw = legacy_spz(3);
  raw[14] = 2;
  put(raw, 0xADBE0003u);
  put(raw, uint32_t(4));
  put(raw, uint32_t(3));
  expect_error(Failure::kInput, {"a.spz", "coordinate system", "3"},
               [&] { read_spz(folder.file("a.spz", gzip(raw))); });
  std::memset(&raw[raw.size() - 8], 0x7f, 4);
  expect_error(Failure::kInput, {"a.spz", "extension", "truncated"},
               [&] { read_spz(folder.file("a.spz", gzip(raw))); });
}

TEST(Spz, WhatIsOutsideItsRangesIsClampedAndCounted) {
  const TemporaryFolder folder;
  GaussianCloud cloud = some_gaussians(4, 1);
  cloud.log_scale[1][0] = -14;
  cloud.sh_of(2)[5] = 3;
  cloud.sh_of(3)[0] = -9;
  EXPECT_EQ(write_spz(folder / "a.spz", cloud), 3u);
  const GaussianCloud back = read_spz(folder / "a.spz");
  EXPECT_EQ(back.log_scale[1][0], -10);
  EXPECT_EQ(back.sh_of(2)[5], 1);  // -1 in the axes of the file
  EXPECT_EQ(write_splats(folder / "a.spz", cloud).size(), 1u);
}

TEST(Spz, AFewFarAwayAreClampedBeforeTheStepsOfAllOthersAreCoarserThanTheUsual) {
  const TemporaryFolder folder;
  GaussianCloud cloud = some_gaussians(4000, 0);
  cloud.position[7].y() = 1500;  // the usual 12 bits reach 2048
  EXPECT_EQ(write_spz(folder / "a.spz", cloud), 0u);
  EXPECT_EQ(read_spz(folder / "a.spz").position[7].y(), 1500);
  cloud.position[7].y() = 2e5f;
  cloud.position[8].x() = -1e9f;
  EXPECT_EQ(write_spz(folder / "a.spz", cloud), 2u);
  EXPECT_NE(write_splats(folder / "a.spz", cloud).at(0).find("2 Gaussians are farther away"), std::string::npos);
  const GaussianCloud back = read_spz(folder / "a.spz");
  EXPECT_NEAR(back.position[7].y(), 2048, 1);
  EXPECT_NEAR(back.position[8].x(), -2048, 1);
  for (size_t i = 9; i < cloud.size(); ++i)
    ASSERT_LE((back.position[i] - cloud.position[i]).cwiseAbs().maxCoeff(), std::ldexp(0.5f, -12));
  // A scene that is large as a whole keeps its extent.
  for (size_t i = 0; i < 100; ++i) cloud.position[i] = Vec3f(0, 0, 1e5f + 64 * i);
  EXPECT_EQ(write_spz(folder / "a.spz", cloud), 0u);
  EXPECT_EQ(read_spz(folder / "a.spz").position[99].z(), 1e5f + 64 * 99);
  for (size_t i = 0; i < 100; ++i) cloud.position[i] = Vec3f(0, 0, 1e8f);
  expect_error(Failure::kInput, {"a.spz", "positions", "write a PLY"}, [&] { write_spz(folder / "a.spz", cloud); });
}

TEST(Spz, OfACloudWhoseZIsUpHasYUp) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = some_gaussians(20, 3);
  write_splats(folder / "a.spz", cloud, false, true);
  const GaussianCloud back = read_spz(folder / "a.spz");  // whose y is down
  Mat3f turn;
  turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  for (size_t i = 0; i < cloud.size(); ++i)
    EXPECT_LT((back.position[i] - turn * cloud.position[i]).cwiseAbs().maxCoeff(), 1e-4f);
}

TEST(Spz, HarmonicsOfDegreeFourAreCutWithAWarning) {
  const TemporaryFolder folder;
  std::string raw = "NGSP";
  put(raw, uint32_t(3));
  put(raw, uint32_t(1));
  raw += std::string("\4\14\0\0", 4) + std::string(9 + 1 + 3 + 3 + 4, '\x40') + std::string(72, '\x81');
  ReadReport report;
  const GaussianCloud cloud = read_spz(folder.file("a.spz", gzip(raw)), &report);
  EXPECT_EQ(cloud.sh_degree, 3);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("degree 4"), std::string::npos);
}

TEST(Spz, HostileFilesNameFileAndFieldBeforeAnythingIsAllocated) {
  const TemporaryFolder folder;
  write_spz(folder / "good.spz", some_gaussians(50, 1));
  const std::string good = read_text(folder / "good.spz"), legacy = legacy_spz(3);
  const auto with = [](std::string bytes, size_t at, const std::string& change) {
    return bytes.replace(at, change.size(), change);
  };
  std::string huge_count(4, '\xff');
  struct Case {
    std::string bytes;
    std::vector<std::string> words;
  };
  const std::vector<Case> cases = {
      {"", {"header"}},
      {"NGS", {"header"}},
      {"\x1f\x8b", {"header", "truncated"}},
      {gzip(""), {"header"}},
      {gzip("0123456789abcdef"), {"magic"}},
      {gzip(legacy.substr(0, 15)), {"header", "15"}},
      {gzip(legacy.substr(0, legacy.size() - 1)), {"numPoints", "declares"}},
      {gzip(legacy + "x"), {"numPoints", "more data"}},
      {gzip(legacy + std::string(8 << 20, '\0')), {"numPoints", "more data"}},  // a bomb behind a small header
      {gzip(with(legacy, 8, huge_count)), {"numPoints", "2147483647"}},
      {gzip(with(legacy, 8, std::string("\0\0\0\x40", 4))), {"numPoints", "declares"}},
      {with(legacy, 8, std::string("\0\4\0\0", 4)), {"numPoints", "room for 2"}},
      {gzip(with(legacy, 4, "\x09")), {"version", "9"}},
      {gzip(with(legacy, 12, "\x09")), {"shDegree", "9"}},
      {gzip(with(legacy, 13, "\x40")), {"fractionalBits", "64"}},
      {gzip(legacy).substr(0, 40), {"end early"}},
      {good.substr(0, 31), {"header"}},
      {good.substr(0, 60), {"table of streams"}},
      {good.substr(0, good.size() - 1), {"harmonics", "truncated"}},
      {with(good, 8, huge_count), {"numPoints"}},
      {with(good, 8, std::string("\0\1\0\0", 4)), {"positions", "numPoints needs"}},
      {with(good, 8, std::string("\0\0\0\x10", 4)), {"numPoints", "declares"}},
      {with(good, 15, "\7"), {"numStreams", "7"}},
      {with(good, 16, std::string("\4\0\0\0", 4)), {"tocByteOffset", "4"}},
      {with(good, 16, std::string("\xff\xff\xff\x7f", 4)), {"tocByteOffset"}},
      {with(good, 32, std::string(8, '\xff')), {"positions", "truncated"}},
      {with(good, 40, std::string(8, '\xff')), {"positions", "numPoints needs"}},
      {with(good, 128, "XXXX"), {"positions", "damaged"}},
  };
  for (size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(i);
    std::vector<std::string> words = cases[i].words;
    words.push_back("case.spz");
    expect_error(Failure::kInput, words, [&] { read_spz(folder.file("case.spz", cases[i].bytes)); });
  }
}

TEST(Spz, ABombWhoseStreamsAreLongerThanTheTableSaysStopsAtTheTable) {
  const TemporaryFolder folder;
  std::string bytes = "NGSP";
  put(bytes, uint32_t(4));
  put(bytes, uint32_t(1));
  bytes += std::string("\0\14\0\5", 4);
  put(bytes, uint32_t(32));
  bytes += std::string(12, '\0');
  const uint64_t sizes[] = {9, 1, 3, 3, 4};
  std::string streams;
  for (const uint64_t size : sizes) {
    const std::string stream = compress_zstd(std::string(64 << 20, '\0'));
    put(bytes, uint64_t(stream.size()));
    put(bytes, size);
    streams += stream;
  }
  expect_error(Failure::kInput, {"case.spz", "positions", "damaged"},
               [&] { read_spz(folder.file("case.spz", bytes + streams)); });
}

TEST(Spz, AnyDamageGivesAnErrorOrACloud) {
  const TemporaryFolder folder;
  write_spz(folder / "good.spz", some_gaussians(4, 1));
  const std::string good = read_text(folder / "good.spz");
  EXPECT_GT(errors_of_damaged(folder, "case.spz", good, 3, [](const fs::path& file) { read_spz(file); }), 60);
  EXPECT_GT(errors_of_damaged(folder, "case.spz", gzip(legacy_spz(2)), 2, [](const fs::path& file) { read_spz(file); }),
            60);
}

TEST(Spz, AnEmptySceneAndAVeryLargeOneAreWritten) {
  const TemporaryFolder folder;
  write_spz(folder / "a.spz", GaussianCloud());
  EXPECT_EQ(read_spz(folder / "a.spz").size(), 0u);
  GaussianCloud far = some_gaussians(3, 0);
  far.position[1].x() = 8e6f;
  write_spz(folder / "a.spz", far);
  EXPECT_EQ(read_spz(folder / "a.spz").position[1].x(), 8e6f);
  far.position[1].x() = 9e6f;
  expect_error(Failure::kInput, {"positions", "9000000"}, [&] { write_spz(folder / "b.spz", far); });
  EXPECT_FALSE(fs::exists(folder / "b.spz"));
}

TEST(Splat, RoundTripStaysWithinTheSteps) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = some_gaussians(2000, 2);
  EXPECT_EQ(write_splats(folder / "a.splat", cloud).size(), 1u);  // the harmonics are lost
  EXPECT_NE(write_splats(folder / "a.splat", cloud, false, true).back().find("z is up"), std::string::npos);
  EXPECT_EQ(fs::file_size(folder / "a.splat"), 2000u * 32);
  ReadReport report;
  const GaussianCloud back = read_splat(folder / "a.splat", &report);
  ASSERT_EQ(back.size(), cloud.size());
  EXPECT_EQ(back.position, cloud.position);
  for (size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((back.log_scale[i] - cloud.log_scale[i]).cwiseAbs().maxCoeff(), 1e-5f);
    EXPECT_LT(std::abs(sigmoid(back.opacity_logit[i]) - sigmoid(cloud.opacity_logit[i])), 0.501f / 255);
    for (int c = 0; c < 3; ++c) EXPECT_LT(std::abs(back.sh_of(i)[c] - cloud.sh_of(i)[c]), 0.501f / 255 / kSh0);
  }
  EXPECT_LT(largest_angle(cloud, back), 2 * 2 * 0.5 / 128 * 1.01);  // half a step in each of four components
}

TEST(Splat, NanInfiniteAndAbsurdRowsAreLeftOutAndCounted) {
  const TemporaryFolder folder;
  write_splat(folder / "a.splat", some_gaussians(8, 0));
  std::string bytes = read_text(folder / "a.splat");
  const auto set = [&](int row, int column, float value) { std::memcpy(&bytes[32 * row + 4 * column], &value, 4); };
  set(0, 1, NAN);
  set(1, 0, INFINITY);
  set(2, 3, NAN);
  set(3, 4, -1.0f);
  set(4, 5, INFINITY);
  set(5, 0, 1e30f);
  set(6, 3, 0.0f);  // a flat Gaussian is legal
  ReadReport report;
  const GaussianCloud cloud = read_splat(folder.file("a.splat", bytes), &report);
  EXPECT_EQ(cloud.size(), 2u);
  EXPECT_EQ(report.rows, 8u);
  EXPECT_EQ(report.dropped, 6u);
  EXPECT_EQ(report.warnings.size(), 1u);
  EXPECT_LT(cloud.log_scale[0][0], -20);
}

TEST(Splat, FilesOfAnotherLengthAreRefused) {
  const TemporaryFolder folder;
  expect_error(Failure::kInput, {"a.splat", "is empty"}, [&] { read_splat(folder.file("a.splat", "")); });
  expect_error(Failure::kInput, {"a.splat", "is empty"}, [&] { read_splat(folder.file("a.splat", "")); });
  expect_error(Failure::kInput, {"a.splat", "33 bytes", "multiple of 32"},
               [&] { read_splat(folder.file("a.splat", std::string(33, 'x'))); });
  expect_error(Failure::kInput, {"none.splat"}, [&] { read_splat(folder / "none.splat"); });
}

TEST(Splats, AreToldByContentThenByExtension) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = some_gaussians(5, 0);
  ReadReport report;
  for (const char* name : {"a.ply", "a.spz", "a.splat"}) {
    write_splats(folder / name, cloud);
    read_splats(folder / name, &report);
    EXPECT_EQ(report.rows, 5u) << name;
    EXPECT_EQ(report.files, std::vector<fs::path>{folder / name});
  }
  fs::rename(folder / "a.spz", folder / "b.ply");
  read_splats(folder / "b.ply", &report);
  EXPECT_EQ(report.format, "spz version 4, SH degree 0");
  expect_error(Failure::kInput, {"a.txt", "not a known splat file"},
               [&] { read_splats(folder.file("a.txt", "hello")); });
  expect_error(Failure::kInput, {"a.ksplat", "splat-transform"},
               [&] { read_splats(folder.file("a.ksplat", "hello")); });
  for (const char* name : {"ckpt_29999_rank0.pt", "step-000029999.ckpt", "point_cloud.PTH"})
    expect_error(Failure::kInput, {name, "is a checkpoint", "ns-export gaussian-splat", "--save_ply"},
                 [&] { read_splats(folder.file(name, std::string("PK\3\4", 4) + std::string(60, 'x'))); });
  expect_error(Failure::kUsage, {"--level", "3"}, [&] { read_splats(folder / "a.ply", nullptr, 3); });
  expect_error(Failure::kUsage, {"a.xyz", "cannot be written"}, [&] { write_splats(folder / "a.xyz", cloud); });
}

}  // namespace
}  // namespace pliant
