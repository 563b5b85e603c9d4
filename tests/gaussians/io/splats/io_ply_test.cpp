// 3DGS PLY: byte-equal round trip, dialects, and hostile files.

#include <gtest/gtest.h>

#include <cstring>

#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

GaussianCloud some_cloud(int n, int degree) {
  GaussianCloud cloud;
  cloud.sh_degree = degree;
  cloud.resize(n);
  Random random(5);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      cloud.position[i][k] = random.normal();
      cloud.log_scale[i][k] = random.normal() - 3;
    }
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = random.normal();
    cloud.opacity_logit[i] = random.normal();
  }
  for (float& value : cloud.sh) value = random.normal();
  return cloud;
}

const std::vector<std::string> kRequired = {"x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                                            "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};

/// An ascii PLY with the required properties; row i has the value i * 100 + column.
std::string ascii_ply(int rows, const std::vector<std::string>& names = kRequired) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(rows) + "\n";
  for (const std::string& name : names) text += "property float " + name + "\n";
  text += "end_header\n";
  for (int i = 0; i < rows; ++i) {
    for (size_t k = 0; k < names.size(); ++k)
      text += std::to_string(0.01 * (i * 100 + k + 1)) + (k + 1 < names.size() ? " " : "\n");
  }
  return text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Ply, RoundTripIsByteEqualForEveryShDegree) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const GaussianCloud cloud = some_cloud(5000, degree);
    write_ply(folder / "a.ply", cloud, degree == 2);
    ReadReport report;
    const GaussianCloud back = read_ply(folder / "a.ply", &report);
    EXPECT_EQ(back.sh_degree, degree);
    EXPECT_EQ(report.antialiased, degree == 2);
    EXPECT_TRUE(report.warnings.empty());
    EXPECT_EQ(back.position, cloud.position);
    EXPECT_EQ(back.rotation, cloud.rotation);
    EXPECT_EQ(back.log_scale, cloud.log_scale);
    EXPECT_EQ(back.opacity_logit, cloud.opacity_logit);
    EXPECT_EQ(back.sh, cloud.sh);
    write_ply(folder / "b.ply", back, report.antialiased);
    EXPECT_EQ(read_text(folder / "a.ply"), read_text(folder / "b.ply"));
  }
}

TEST(Ply, KeepsWhatIsUp) {
  const TemporaryFolder folder;
  for (const bool z_is_up : {false, true})
    for (const bool antialiased : {false, true}) {
      write_ply(folder / "a.ply", some_cloud(3, 0), antialiased, z_is_up);
      ReadReport report;
      read_ply(folder / "a.ply", &report);
      EXPECT_EQ(report.z_is_up, z_is_up);
      EXPECT_EQ(report.antialiased, antialiased);
    }
}

TEST(Ply, RestOfTheHarmonicsIsChannelMajorInTheFile) {
  const TemporaryFolder folder;
  std::vector<std::string> names = kRequired;
  for (int i = 0; i < 9; ++i) names.push_back("f_rest_" + std::to_string(i));
  std::string text = ascii_ply(1, names);
  const size_t at = text.find("end_header\n") + 11;
  text = text.substr(0, at) + "1 2 3 4 5 6 7 -1 -2 -3 1 0 0 0 10 11 12 20 21 22 30 31 32\n";
  const GaussianCloud cloud = read_ply(folder.file("a.ply", text));
  EXPECT_EQ(cloud.sh, (std::vector<float>{4, 5, 6, 10, 20, 30, 11, 21, 31, 12, 22, 32}));
  EXPECT_EQ(cloud.opacity_logit[0], 7);
  EXPECT_EQ(cloud.log_scale[0], Vec3f(-1, -2, -3));
  EXPECT_EQ(cloud.rotation[0], Vec4f(1, 0, 0, 0));
}

TEST(Ply, PropertiesAreFoundByNameInAnyOrderWithExtrasAndWithCrlf) {
  const TemporaryFolder folder;
  std::vector<std::string> names(kRequired.rbegin(), kRequired.rend());
  names.insert(names.begin() + 3, "obj_dc_0");
  std::string text = ascii_ply(3, names), crlf;
  text = replaced(text, "element vertex 3", "element vertex   3     ");
  for (char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  ReadReport report;
  const GaussianCloud cloud = read_ply(folder.file("a.ply", crlf), &report);
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_FLOAT_EQ(cloud.position[1].x(), 1.15f);
  EXPECT_FLOAT_EQ(cloud.rotation[2][3], 2.01f);
  EXPECT_EQ(report.format, "3DGS PLY, SH degree 0");
}

TEST(Ply, OtherElementsAndTypesArePassedOver) {
  const TemporaryFolder folder;
  std::string text =
      "ply\nformat binary_little_endian 1.0\ncomment antialiased 1\nelement camera 2\nproperty double f\n"
      "element face 2\nproperty list uchar int vertex_indices\nproperty uchar flag\nelement vertex 1\n"
      "property double x\nproperty short y\nproperty uchar z\nproperty uint nx\n";
  for (size_t i = 3; i < kRequired.size(); ++i) text += "property float " + kRequired[i] + "\n";
  text += "element tail 5\nproperty list int float v\nend_header\n";
  const auto put = [&](auto value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(1.0);
  put(2.0);
  put(uint8_t(3));
  put(7);
  put(8);
  put(9);
  put(uint8_t(1));
  put(uint8_t(0));
  put(uint8_t(2));
  put(0.25);
  put(int16_t(-7));
  put(uint8_t(200));
  put(4000000000u);
  for (size_t i = 3; i < kRequired.size(); ++i) put(static_cast<float>(i));
  ReadReport report;
  const GaussianCloud cloud = read_ply(folder.file("a.ply", text), &report);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.position[0], Vec3f(0.25f, -7, 200));
  EXPECT_EQ(cloud.opacity_logit[0], 6);
  EXPECT_TRUE(report.antialiased);
}

TEST(Ply, RowsWithNanAreDroppedButOpaqueAndFlatGaussiansAreKept) {
  const TemporaryFolder folder;
  std::string text = ascii_ply(0);
  text = replaced(text, "vertex 0", "vertex 8");
  text +=
      "nan 0 0 0 0 0 0 -1 -1 -1 1 0 0 0\n"
      "1 0 0 0 0 0 inf -inf -1 -1 1 0 0 0\n"
      "2 0 0 0 0 0 0 inf -1 -1 1 0 0 0\n"
      "3 0 0 0 -inf 0 0 -1 -1 -1 1 0 0 0\n"
      "4 0 0 0 0 0 0 -1 -1 -1 0 0 0 0\n"
      "5 1e30 0 0 0 0 0 -1 -1 -1 1 0 0 0\n"
      "1e999 0 0 0 0 0 0 -1 -1 -1 1 0 0 0\n"
      "7 1e-999 0 0 0 0 0 -1 -1 -1 1 0 0 0\n";
  ReadReport report;
  const GaussianCloud cloud = read_ply(folder.file("a.ply", text), &report);
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(report.rows, 8u);
  EXPECT_EQ(report.dropped, 5u) << "infinite as what no number holds, but not what is next to zero";
  EXPECT_EQ(cloud.position[2], Vec3f(7, 0, 0));
  EXPECT_EQ(cloud.position[0].x(), 1);
  EXPECT_EQ(sigmoid(cloud.opacity_logit[0]), 1.0f);
  EXPECT_LT(std::exp(cloud.log_scale[0][0]), 1e-12f);
  EXPECT_EQ(cloud.rotation[1], Vec4f(1, 0, 0, 0));
  EXPECT_EQ(report.warnings.size(), 2u);
}

TEST(Ply, The3DFilterOfMipSplattingIsApplied) {
  const TemporaryFolder folder;
  std::vector<std::string> names = kRequired;
  names.push_back("filter_3D");
  std::string text = ascii_ply(2, names);
  text = text.substr(0, text.find("end_header\n") + 11) + "1 2 3 4 5 6 2 -3 -2 -3 1 0 0 0 0.3\n" +
         "1 2 3 4 5 6 2 -3 -2 -3 1 0 0 0 0\n";
  ReadReport report;
  const GaussianCloud cloud = read_ply(folder.file("a.ply", text), &report);
  EXPECT_TRUE(report.antialiased);
  double share = 1;
  for (int k = 0; k < 3; ++k) {
    const double s = std::exp(k == 1 ? -2.0 : -3.0), filtered = std::sqrt(s * s + 0.09);
    EXPECT_NEAR(cloud.log_scale[0][k], std::log(filtered), 1e-6);
    share *= s / filtered;
  }
  const double opacity = share / (1 + std::exp(-2.0));
  EXPECT_NEAR(cloud.opacity_logit[0], std::log(opacity / (1 - opacity)), 1e-5);
  EXPECT_EQ(cloud.log_scale[1], Vec3f(-3, -2, -3)) << "a filter of no width";
  EXPECT_EQ(cloud.opacity_logit[1], 2);
}

TEST(Ply, SurfelsGetAThinThirdAxis) {
  const TemporaryFolder folder;
  std::vector<std::string> names = kRequired;
  names.erase(std::find(names.begin(), names.end(), "scale_2"));
  ReadReport report;
  const GaussianCloud cloud = read_ply(folder.file("a.ply", ascii_ply(1, names)), &report);
  EXPECT_NEAR(std::exp(cloud.log_scale[0][2] - cloud.log_scale[0].head<2>().minCoeff()), 0.01, 1e-6);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("scale_2"), std::string::npos);
}

TEST(Ply, HostileFilesNameFileAndFieldAndAllocateNothing) {
  const TemporaryFolder folder;
  write_ply(folder / "good.ply", some_cloud(100, 1));
  const std::string good = read_text(folder / "good.ply"), ascii = ascii_ply(2);
  struct Case {
    std::string bytes;
    std::vector<std::string> words;
  };
  const std::vector<Case> cases = {
      {"", {"empty"}},
      {"solid stl", {"header"}},
      {"obj\nformat", {"'ply'"}},
      {good.substr(0, 100), {"end_header", "truncated"}},
      {good.substr(0, good.size() - 1), {"element vertex", "100 rows", "truncated"}},
      {replaced(good, "vertex 100", "vertex 99999999999999999"), {"element vertex", "99999999999999999"}},
      {replaced(good, "vertex 100", "vertex 2000000000"), {"element vertex", "2000000000"}},
      {replaced(good, "vertex 100", "vertex -5"), {"element vertex", "'-5'"}},
      {replaced(good, "vertex 100", "vertex 1e3"), {"'1e3'"}},
      {replaced(good, "vertex 100", "vertex 99999999999999999999999"), {"element vertex"}},
      {replaced(good, "float opacity", "float opaqueness"), {"property opacity", "is missing"}},
      {replaced(good, "float opacity", "quaternion opacity"), {"property opacity", "'quaternion'"}},
      {replaced(good, "float opacity", "list uchar float opacity"), {"property opacity", "list"}},
      {replaced(good, "float rot_3", "float rot_2"), {"rot_2", "twice"}},
      {replaced(good, "property float f_rest_8\n", ""), {"f_rest", "8 times"}},
      {replaced(good, "float f_rest_8", "float f_rest_9"), {"f_rest_8", "is missing"}},
      {replaced(good, "binary_little_endian", "binary_big_endian"), {"binary_big_endian"}},
      {replaced(good, "binary_little_endian", "middle_endian"), {"format", "'middle_endian'"}},
      {replaced(good, "element vertex", "element vortex"), {"element vertex", "is missing"}},
      {"ply\n" + std::string(200000, 'x'), {"128 KB"}},
      {replaced(ascii, "0.010000", "zero"), {"property x", "'zero'"}},
      {ascii.substr(0, ascii.size() - 60), {"property", "end early"}},
      {replaced(ascii, "vertex 2", "vertex 200000"), {"200000"}},
      {"ply\nformat binary_little_endian 1.0\nelement chunk 1\nproperty float min_x\nelement vertex 1\n"
       "property uint packed_position\nend_header\n",
       {"element chunk", "1 rows"}},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
       "3\n",
       {"f_dc_0", "point cloud"}},
      {replaced(good, "element vertex", "element face 1000000\nproperty list uchar int i\nelement vertex"),
       {"face", "early"}},
      {replaced(good, "element vertex", "element face 3\nproperty list int double i\nelement vertex"), {"property i"}},
      {replaced(good, "element vertex", "element face 3\nproperty list float double i\nelement vertex"),
       {"property i", "length"}},
  };
  for (size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(i);
    const fs::path file = folder.file("case.ply", cases[i].bytes);
    std::vector<std::string> words = cases[i].words;
    words.push_back("case.ply");
    expect_error(Failure::kInput, words, [&] { read_ply(file); });
  }
  expect_error(Failure::kInput, {"none.ply"}, [&] { read_ply(folder / "none.ply"); });
  expect_error(Failure::kInput, {"is not a file"}, [&] { read_ply(folder.path()); });
}

TEST(Ply, AnyTruncationAndAnyChangedHeaderByteGivesAnErrorOrACloud) {
  const TemporaryFolder folder;
  write_ply(folder / "good.ply", some_cloud(4, 1));
  const std::string good = read_text(folder / "good.ply");
  const size_t header = good.find("end_header") + 11;
  int errors = 0;
  const auto attempt = [&](const std::string& bytes) {
    try {
      read_ply(folder.file("case.ply", bytes));
    } catch (const Error&) {
      ++errors;
    }
  };
  for (size_t length = 0; length < good.size(); length += 7) attempt(good.substr(0, length));
  EXPECT_EQ(errors, static_cast<int>((good.size() + 6) / 7));
  Random random(9);
  for (size_t at = 0; at < header; ++at) {
    std::string changed = good;
    changed[at] = static_cast<char>(random.below(256));
    attempt(changed);
  }
}

}  // namespace
}  // namespace pliant
