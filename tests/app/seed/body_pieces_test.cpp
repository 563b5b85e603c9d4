// What hangs on nothing is not simulated, unless it is held or is large enough for a body of its own.

#include "app/seed/body_pieces.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>

namespace pliant {
namespace {

/// `n` samples in a cube of them around `centre`, .01 apart.
void add_cube(int n, const Vec3f& centre, SolidSamples& samples) {
  const int side = static_cast<int>(std::ceil(std::cbrt(n)));
  for (int i = 0; i < n; ++i) {
    samples.position.push_back(centre + 0.01f * Vec3f(i % side, i / side % side, i / (side * side)));
    samples.volume.push_back(1e-6f);
  }
}

TEST(BodyPieces, SmallOnesThatHangOnNothingAreLeftOut) {
  SolidSamples samples;
  add_cube(1000, Vec3f(0, 0, 0), samples);
  add_cube(100, Vec3f(1, 0, 0), samples);  // a second body
  add_cube(20, Vec3f(0, 1, 0), samples);   // held
  add_cube(15, Vec3f(0, 0, 1), samples);   // neither
  SimulatedPart part;
  part.kept.resize(samples.size());
  std::iota(part.kept.begin(), part.kept.end(), 0);
  part.cell_size = 0.02f;
  part.volume = samples.total_volume();
  const std::vector<Region> pins = {Region::sphere(Vec3d(0, 1, 0), 0.015)};
  const BodyPieces body = find_body_pieces(samples, pins, part);
  EXPECT_EQ(body.count, (std::vector<size_t>{1000, 100, 20, 15}));
  EXPECT_EQ(body.loose, (std::vector<uint8_t>{0, 0, 0, 1}));
  ASSERT_EQ(part.kept.size(), 1120u);
  EXPECT_EQ(part.kept.back(), 1119);
  EXPECT_NEAR(part.volume, 1120e-6, 1e-9);
  EXPECT_NEAR((body.centre[3] - Vec3f(0.01f, 0.01f, 1.005f)).norm(), 0, 0.01);
  EXPECT_EQ(body.held, (std::vector<uint8_t>{0, 0, 1, 0}));
  const std::vector<int> follows = followed_samples(samples, part, body);
  ASSERT_EQ(follows.size(), samples.size());
  for (size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(follows[i], i < 1120 ? -1 : follows[1120]) << i;
  ASSERT_TRUE(follows[1120] >= 0 && follows[1120] < 1000) << "the nearest is in the largest cube";
  EXPECT_EQ(samples.position[follows[1120]].z(), samples.position[999].z()) << "and on its top";
  EXPECT_EQ(largest_held(body.pieces, samples.position, pins), 2);
  EXPECT_EQ(largest_held(body.pieces, samples.position, {}), 0);
  const nlohmann::json rows = pieces_json(body);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[3]["simulated"], false);
  EXPECT_EQ(rows[2]["samples"], 20);
}

TEST(BodyPieces, ThatNothingHoldsAreSaidToDriftWhereAnotherIsHeld) {
  SolidSamples samples;
  add_cube(1000, Vec3f(0, 0, 0), samples);
  add_cube(500, Vec3f(1, 0, 0), samples);
  std::string said;
  Progress progress(true);
  progress.listen([&](const ProgressEvent& event) { said += event.text + "\n"; });
  const auto tell = [&](const std::vector<Region>& pins) {
    SimulatedPart part;
    part.kept.resize(samples.size());
    std::iota(part.kept.begin(), part.kept.end(), 0);
    part.cell_size = 0.02f;
    said.clear();
    tell_loose({progress, {}}, find_body_pieces(samples, pins, part));
    return said;
  };
  EXPECT_EQ(tell({}), "");
  EXPECT_EQ(tell({Region::sphere(Vec3d(0, 0, 0), 0.015), Region::sphere(Vec3d(1, 0, 0), 0.015)}), "");
  const std::string head = tell({Region::sphere(Vec3d(0, 0, 0), 0.015)}),
                    stalk = tell({Region::sphere(Vec3d(1, 0, 0), 0.015)});
  EXPECT_NE(head.find("a piece of 33 % of the volume around (1.0"), std::string::npos) << head;
  EXPECT_NE(stalk.find("a piece of 67 % of the volume around (0.0"), std::string::npos) << stalk;
}

}  // namespace
}  // namespace pliant
