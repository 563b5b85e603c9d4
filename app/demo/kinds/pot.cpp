#include "app/demo/kinds/pot.h"

namespace pliant {
namespace {
constexpr double kPotWall = 0.006;  // m
}

std::vector<Eigen::Vector2d> pot_profile(double radius, double height, double soil) {
  const double foot = 0.74 * radius, lip = 0.018;
  return {{foot, 0},
          {radius - 0.005, height - lip},
          {radius, height - lip + 0.002},
          {radius, height - 0.003},
          {radius - 0.003, height},
          {radius - kPotWall + 0.002, height},
          {radius - kPotWall, height - 0.002},
          {radius - kPotWall, soil}};
}

std::vector<Eigen::Vector2d> soil_profile(double radius, double soil, double stem_radius) {
  const double outer = radius - kPotWall;
  return {{outer, soil}, {0.5 * (outer + stem_radius), soil + 0.004}, {stem_radius - 0.002, soil + 0.006}};
}

}  // namespace pliant
