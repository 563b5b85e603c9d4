// Material fields of other programs: there and back, in the scene's coordinates or their own, hostile files refused.

#include "app/import/material_fields.h"

#include <gtest/gtest.h>

#include <cstring>

#include "app/simulate/given_fields.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/npy.h"
#include "gaussians/io/files/zip_archive.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// A field in a box of 1 x 2 x 0.5 around (3, -1, 5).
MaterialFile some_field() {
  MaterialFile m;
  for (int i = 0; i < 3000; ++i) {
    Random random(5, i);
    const Vec3f u(static_cast<float>(random.uniform(-1, 1)), static_cast<float>(random.uniform(-1, 1)),
                  static_cast<float>(random.uniform(-1, 1)));
    m.position.push_back(Vec3f(3, -1, 5) + u.cwiseProduct(Vec3f(0.5f, 1, 0.25f)));
    m.young.push_back(std::pow(10.0f, 5 + u.y()));
    m.poisson.push_back(0.3f + 0.1f * u.x());
    m.density.push_back(500 + 100 * u.z());
  }
  return m;
}

TEST(MaterialField, OfBothFormatsIsThatOfTheSamplesItWasWrittenFor) {
  const TemporaryFolder folder;
  const MaterialFile m = some_field();
  for (const char* name : {"field.npz", "field.ply"}) {
    write_material_field(folder / name, m);
    const ElasticSamples back = given_material(folder / name, m.position);
    EXPECT_EQ(back.young, m.young) << name;
    EXPECT_EQ(back.poisson, m.poisson) << name;
    EXPECT_EQ(back.density, m.density) << name;
  }
  // In the file of voxels the object lies in the unit cube around 0.
  Vec3f low = Vec3f::Constant(1e9f), high = -low;
  for (const Vec3f& x : read_material_field(folder / "field.npz").position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  EXPECT_NEAR((high - low).maxCoeff(), 1, 0.01);
  EXPECT_LT((high + low).cwiseAbs().maxCoeff(), 0.01);
}

TEST(MaterialField, EqualFieldsGiveEqualBytes) {
  const TemporaryFolder folder;
  write_material_field(folder / "a.npz", some_field());
  write_material_field(folder / "b.npz", some_field());
  EXPECT_EQ(read_text(folder / "a.npz"), read_text(folder / "b.npz"));
}

TEST(MaterialField, OfAnotherShapeThanTheObjectIsRefused) {
  const TemporaryFolder folder;
  MaterialFile turned = some_field();
  for (Vec3f& x : turned.position) x = Vec3f(x.x(), x.z(), -x.y());
  write_material_field(folder / "turned.npz", turned);
  expect_error(Failure::kInput, {"turned.npz", "x, y, z", "axes"},
               [&] { given_material(folder / "turned.npz", some_field().position); });
}

TEST(MaterialField, ColumnsOfOtherTypesAndExtraOnesAreRead) {
  const TemporaryFolder folder;
  // As numpy writes them: a header in Python, with spaces, and numbers of several types.
  std::string header =
      "{'descr': [('segment_id', '<i8'), ('x', '<f8'), ('y', '<f4'), ('z', '|u1')], 'fortran_order': False, "
      "'shape': (2,), }";
  header.resize(118, ' ');
  header.back() = '\n';
  std::string bytes = "\x93NUMPY\x01";
  bytes += '\0';
  bytes += {static_cast<char>(header.size()), '\0'};
  bytes += header;
  for (int row = 0; row < 2; ++row) {
    const int64_t id = -7 + row;
    const double x = 1.25 + row;
    const float y = -2.5f * (row + 1);
    const uint8_t z = static_cast<uint8_t>(200 + row);
    bytes.append(reinterpret_cast<const char*>(&id), 8);
    bytes.append(reinterpret_cast<const char*>(&x), 8);
    bytes.append(reinterpret_cast<const char*>(&y), 4);
    bytes.append(reinterpret_cast<const char*>(&z), 1);
  }
  const auto columns = read_npy_columns(bytes, "made.npy");
  EXPECT_EQ(columns.at("segment_id"), (std::vector<double>{-7, -6}));
  EXPECT_EQ(columns.at("x"), (std::vector<double>{1.25, 2.25}));
  EXPECT_EQ(columns.at("y"), (std::vector<double>{-2.5, -5}));
  EXPECT_EQ(columns.at("z"), (std::vector<double>{200, 201}));
  for (size_t length = 0; length < bytes.size(); length += 3)
    EXPECT_THROW(read_npy_columns(std::string_view(bytes).substr(0, length), "cut.npy"), Error) << length;
  const auto refused = [&](const std::string& piece, const std::string& other, const std::string& word) {
    std::string bad = bytes;
    bad.replace(bad.find(piece), piece.size(), other);
    expect_error(Failure::kInput, {"bad.npy", word}, [&] { read_npy_columns(bad, "bad.npy"); });
  };
  refused("'<f8'", "'>f8'", "descr");
  refused("'<f4'", "'|S4'", "descr");
  refused("(2,)", "(9,)", "data");
  refused("(2,)", "(22)", "data");
  refused("(2,), }", "(1,2)} ", "shape");
  refused("{'descr'", "['descr'", "header");
  refused("NUMPY", "NUMPi", "header");
}

TEST(MaterialField, HostileFilesNameFileAndField) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const std::string& text, const std::vector<std::string>& words) {
    const fs::path file = folder.file(name, text);
    std::vector<std::string> all = words;
    all.push_back(name);
    expect_error(Failure::kInput, all, [&] { read_material_field(file); });
  };
  const auto ply = [](const std::string& properties, const std::string& rows, int count) {
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) + "\n" + properties + "end_header\n" + rows;
  };
  const std::string all =
      "property float x\nproperty float y\nproperty float z\nproperty float density\nproperty float E\nproperty float "
      "nu\n";
  refused("empty.ply", "", {});
  refused("text.npz", "no archive", {});
  refused("few.ply", ply("property float x\nproperty float y\nproperty float z\n", "0 0 0\n", 1), {"E", "missing"});
  refused("none.ply", ply(all, "", 0), {"no points"});
  refused("cut.ply", ply(all, "0 0 0 500 1e5 0.3\n", 2), {});
  refused("long.ply", ply(all, "0 0 0 500 1e5 0.3\n1 0 0 500 1e5 0.3\n", 1),
          {"element vertex", "1 rows", "more follow"});
  write_material_field(folder / "field.ply", some_field());
  std::string longer = read_text(folder / "field.ply");
  longer.replace(longer.find("vertex 3000"), 11, "vertex 2000");
  refused("longer.ply", longer, {"element vertex", "2000 rows", "more follow"});
  refused("zero.ply", ply(all, "0 0 0 500 0 0.3\n", 1), {"E", "row 0"});
  refused("half.ply", ply(all, "0 0 0 500 1e5 0.3\n0 0 0 500 1e5 0.5\n", 2), {"nu", "row 1"});
  refused("light.ply", ply(all, "0 0 0 -1 1e5 0.3\n", 1), {"density", "row 0"});
  write_material_field(folder / "whole.npz", some_field());
  const std::string whole = read_text(folder / "whole.npz");
  for (size_t part = 1; part < 8; ++part) refused("cut.npz", whole.substr(0, whole.size() * part / 8), {});
  expect_error(Failure::kUsage, {"field.txt"}, [&] { write_material_field(folder / "field.txt", some_field()); });
}

TEST(Info, OfAMaterialFieldIsItsPointsAndRanges) {
  const TemporaryFolder folder;
  MaterialFile m = some_field();
  m.young[7] = 4.5e6f;
  write_material_field(folder / "field.npz", m);
  testing::internal::CaptureStdout();
  const int code = run_pliant({"info", (folder / "field.npz").string()});
  const std::string out = testing::internal::GetCapturedStdout();
  EXPECT_EQ(code, 0);
  for (const char* word : {"kind: material field", "points: 3000", "4500000", "young_pa", "density_kg_m3"})
    EXPECT_NE(out.find(word), std::string::npos) << word << " in: " << out;
  EXPECT_EQ(run_quietly({"info", folder.file("broken.npz", "PK").string()}), static_cast<int>(Failure::kInput));
  EXPECT_EQ(run_quietly({"info", (folder / "field.npz").string(), "--level", "1"}), static_cast<int>(Failure::kUsage));
}

}  // namespace
}  // namespace pliant
