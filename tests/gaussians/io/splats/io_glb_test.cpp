// .glb with KHR_gaussian_splatting, read back by the rules of glTF 2.0 alone.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/splats.h"
#include "gaussians/render/spherical_harmonics.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

GaussianCloud some_cloud(int degree) {
  Random random(7);
  GaussianCloud cloud;
  cloud.sh_degree = degree;
  cloud.resize(37);
  for (size_t g = 0; g < cloud.size(); ++g) {
    for (int k = 0; k < 3; ++k) {
      cloud.position[g][k] = static_cast<float>(random.normal());
      cloud.log_scale[g][k] = static_cast<float>(random.uniform(-6, 0));
    }
    for (int k = 0; k < 4; ++k) cloud.rotation[g][k] = static_cast<float>(3 * random.normal());
    cloud.opacity_logit[g] = static_cast<float>(2 * random.normal());
  }
  for (float& x : cloud.sh) x = static_cast<float>(0.2 * random.normal());
  return cloud;
}

struct Glb {
  json document;
  std::string binary;

  explicit Glb(const std::string& bytes) {
    const auto word = [&](size_t at) {
      uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, 4);
      return value;
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2u);
    EXPECT_EQ(word(8), bytes.size());
    const size_t text = word(12);
    EXPECT_EQ(text % 4, 0u);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    document = json::parse(bytes.substr(20, text));
    EXPECT_EQ(bytes.substr(24 + text, 3), "BIN");
    EXPECT_EQ(28 + text + word(20 + text), bytes.size());
    binary = bytes.substr(28 + text);
  }
  const json& primitive() const { return document["meshes"][0]["primitives"][0]; }
  /// Number k of an attribute of point g.
  float operator()(const std::string& name, size_t g, int k) const {
    const json& accessor = document["accessors"][primitive()["attributes"][name].get<size_t>()];
    EXPECT_EQ(accessor["componentType"], 5126);
    const json& view = document["bufferViews"][accessor["bufferView"].get<size_t>()];
    const std::map<std::string, int> widths = {{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}};
    const int width = widths.at(accessor["type"]);
    const size_t at = view["byteOffset"].get<size_t>() + (g * width + k) * sizeof(float);
    EXPECT_LE(at + sizeof(float), view["byteOffset"].get<size_t>() + view["byteLength"].get<size_t>());
    float value = 0;
    std::memcpy(&value, binary.data() + at, sizeof value);
    return value;
  }
};

const std::string kSplats = "KHR_gaussian_splatting";

TEST(Glb, EachDegreeHoldsTheSameGaussiansWithYUp) {
  TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const GaussianCloud cloud = some_cloud(degree);
    EXPECT_TRUE(write_splats(folder / "a.glb", cloud).empty());
    const Glb glb(read_text(folder / "a.glb"));
    EXPECT_EQ(glb.document["asset"]["version"], "2.0");
    EXPECT_EQ(glb.document["extensionsUsed"], json{kSplats});
    EXPECT_EQ(glb.primitive()["mode"], 0);
    EXPECT_EQ(glb.primitive()["extensions"][kSplats]["kernel"], "ellipse");
    EXPECT_EQ(glb.primitive()["attributes"].size(), 5u + (degree + 1) * (degree + 1));
    const json& position = glb.document["accessors"][glb.primitive()["attributes"]["POSITION"].get<size_t>()];
    EXPECT_EQ(position["count"], cloud.size());
    const Vec3d turn(1, -1, -1);  // half a turn around x
    for (size_t g = 0; g < cloud.size(); ++g) {
      Eigen::Quaterniond q(glb(kSplats + ":ROTATION", g, 3), glb(kSplats + ":ROTATION", g, 0),
                           glb(kSplats + ":ROTATION", g, 1), glb(kSplats + ":ROTATION", g, 2));
      EXPECT_NEAR(q.norm(), 1, 1e-6);
      const Eigen::Vector4d r = cloud.rotation[g].cast<double>().normalized();
      const Mat3d before = Eigen::Quaterniond(r[0], r[1], r[2], r[3]).toRotationMatrix();
      // The ellipsoid, not the quaternion, is what must be the same.
      Vec3d scale;
      for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(glb("POSITION", g, k), float(turn[k]) * cloud.position[g][k]);
        EXPECT_GE(glb("POSITION", g, k), position["min"][k].get<float>());
        EXPECT_LE(glb("POSITION", g, k), position["max"][k].get<float>());
        scale[k] = glb(kSplats + ":SCALE", g, k);
        EXPECT_NEAR(scale[k], std::exp(cloud.log_scale[g][k]), 1e-6);
      }
      const Mat3d square = scale.cwiseAbs2().asDiagonal();
      const Mat3d there = q.toRotationMatrix() * square * q.toRotationMatrix().transpose(),
                  here = before * square * before.transpose();
      EXPECT_LE((there - turn.asDiagonal() * here * turn.asDiagonal()).norm(), 1e-5);
      EXPECT_NEAR(glb(kSplats + ":OPACITY", g, 0), 1 / (1 + std::exp(-cloud.opacity_logit[g])), 1e-6);
      EXPECT_EQ(glb("COLOR_0", g, 3), glb(kSplats + ":OPACITY", g, 0));
    }
  }
}

TEST(Glb, ColoursSeenFromTurnedDirectionsAreTheSame) {
  TemporaryFolder folder;
  const GaussianCloud cloud = some_cloud(3);
  write_splats(folder / "a.glb", cloud);
  const Glb glb(read_text(folder / "a.glb"));
  Random random(11);
  for (size_t g = 0; g < cloud.size(); ++g) {
    std::vector<double> sh;
    for (int degree = 0; degree <= 3; ++degree)
      for (int n = 0; n < 2 * degree + 1; ++n)
        for (int c = 0; c < 3; ++c)
          sh.push_back(glb(kSplats + ":SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n), g, c));
    const Vec3d d = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
    const Vec3d there = sh_color<double>(3, sh.data(), Vec3d(d.x(), -d.y(), -d.z())),
                here = sh_color<double>(3, cloud.sh_of(g), d);
    EXPECT_LE((there - here).norm(), 1e-6);
  }
}

TEST(Glb, OfACloudWhoseZIsUpHasYUp) {
  TemporaryFolder folder;
  const GaussianCloud cloud = some_cloud(3);
  EXPECT_TRUE(write_splats(folder / "a.glb", cloud, false, true).empty());
  const Glb glb(read_text(folder / "a.glb"));
  Mat3d turn;  // z, which is up, becomes y
  turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  Random random(12);
  for (size_t g = 0; g < cloud.size(); ++g) {
    const auto quaternion = [](double w, double x, double y, double z) {
      return Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
    };
    const Vec4f& r = cloud.rotation[g];
    const Mat3d before = quaternion(r[0], r[1], r[2], r[3]),
                after = quaternion(glb(kSplats + ":ROTATION", g, 3), glb(kSplats + ":ROTATION", g, 0),
                                   glb(kSplats + ":ROTATION", g, 1), glb(kSplats + ":ROTATION", g, 2));
    EXPECT_LT((after - turn * before).norm(), 1e-5);
    const Vec3d position = turn * cloud.position[g].cast<double>();
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(glb("POSITION", g, k), position[k], 1e-6);
    std::vector<double> sh;
    for (int degree = 0; degree <= 3; ++degree)
      for (int n = 0; n < 2 * degree + 1; ++n)
        for (int c = 0; c < 3; ++c)
          sh.push_back(glb(kSplats + ":SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n), g, c));
    const Vec3d d = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
    EXPECT_LE((sh_color<double>(3, sh.data(), Vec3d(turn * d)) - sh_color<double>(3, cloud.sh_of(g), d)).norm(), 1e-5);
  }
}

TEST(Glb, WhatItCannotHoldIsSaid) {
  TemporaryFolder folder;
  EXPECT_EQ(write_splats(folder / "a.glb", some_cloud(0), true).size(), 1u);
  expect_error(Failure::kUsage, {".glb"}, [&] { write_splats(folder / "a.gltf", some_cloud(0)); });
}

}  // namespace
}  // namespace pliant
