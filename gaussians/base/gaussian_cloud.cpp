#include "gaussians/base/gaussian_cloud.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "gaussians/base/error.h"

namespace pliant {

GaussianCloud GaussianCloud::select(std::span<const int> indices) const {
  GaussianCloud out;
  out.sh_degree = sh_degree;
  out.resize(indices.size());
  const int width = sh_count() * 3;
  for (size_t k = 0; k < indices.size(); ++k) {
    const size_t i = static_cast<size_t>(indices[k]);
    CHECK(i < size());
    out.position[k] = position[i];
    out.rotation[k] = rotation[i];
    out.log_scale[k] = log_scale[i];
    out.opacity_logit[k] = opacity_logit[i];
    std::copy_n(sh.data() + i * width, width, out.sh.data() + k * width);
  }
  return out;
}

void GaussianCloud::append(const GaussianCloud& other) {
  const int degree = std::max(sh_degree, other.sh_degree);
  if (degree != sh_degree) *this = with_sh_degree(*this, degree);
  const std::vector<float> theirs = with_sh_degree(other, degree).sh;
  position.insert(position.end(), other.position.begin(), other.position.end());
  rotation.insert(rotation.end(), other.rotation.begin(), other.rotation.end());
  log_scale.insert(log_scale.end(), other.log_scale.begin(), other.log_scale.end());
  opacity_logit.insert(opacity_logit.end(), other.opacity_logit.begin(), other.opacity_logit.end());
  sh.insert(sh.end(), theirs.begin(), theirs.end());
}

Box GaussianCloud::bounds() const {
  Box box;
  for (const Vec3f& x : position) box.add(x);
  return box;
}

GaussianCloud with_sh_degree(const GaussianCloud& cloud, int degree) {
  GaussianCloud out = cloud;
  out.sh_degree = degree;
  const int from = cloud.sh_count() * 3, to = out.sh_count() * 3;
  out.sh.assign(cloud.size() * to, 0.0f);
  for (size_t i = 0; i < cloud.size(); ++i)
    std::copy_n(cloud.sh.data() + i * from, std::min(from, to), out.sh.data() + i * to);
  return out;
}

Vec4f quaternion_wxyz(const Mat3f& rotation) {
  const Eigen::Quaternionf q(rotation);
  return Vec4f(q.w(), q.x(), q.y(), q.z()).normalized();
}

Eigen::Vector4d quaternion_wxyz(const Mat3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()).normalized();
}

}  // namespace pliant
