// Fields of a file count for points that they were not made for: those of the nearest sample, or, where they are
// uniform, those of any.

#include "app/simulate/given_fields.h"

#include <gtest/gtest.h>

#include "app/store/material.h"
#include "gaussians/base/error.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

TEST(GivenFields, AUniformMaterialIsThatOfAnyParticlesAndOthersNeedPositions) {
  const TemporaryFolder folder;
  ParticleFile particles;
  particles.solid_position = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(2, 0, 0)};
  MaterialFile material{{2e5f, 2e5f}, {0.3f, 0.3f}, {400, 400}, "made", {}, {}};
  const auto given = [&] {
    write_material(folder / "material.h5", material, "{}");
    return given_material(folder / "material.h5", particles.solid_position);
  };
  EXPECT_EQ(given().young, std::vector<float>(3, 2e5));
  EXPECT_EQ(given().density, std::vector<float>(3, 400));
  material.young[1] = 3e5f;
  EXPECT_THROW(given(), Error);
  material.position = {Vec3f(0.1f, 0, 0), Vec3f(1.8f, 0, 0)};
  material.volume = {1, 1};
  EXPECT_EQ(given().young, (std::vector<float>{2e5, 3e5, 3e5}));
}

}  // namespace
}  // namespace pliant
