#include "physics/body/look.h"

#include <algorithm>

namespace pliant {

Look look_of(const GaussianCloud& cloud, int i) {
  constexpr float kNeedle = 0.35f;  // ratio of a Gaussian's two largest axes below which it has no normal
  const Vec3f scale = cloud.log_scale[i].array().exp();
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int a, int b) { return scale[a] < scale[b]; });
  Look look;
  look.color = dc_color(cloud.sh_of(i));
  const bool needle = scale[order[1]] < kNeedle * scale[order[2]];
  look.normal = needle ? Vec3f(Vec3f::Zero()) : Vec3f(rotation_matrix<float>(cloud.rotation[i]).col(order[0]));
  return look;
}

}  // namespace pliant
