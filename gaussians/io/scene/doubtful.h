#pragma once

#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// Sentences on what makes every result of a scene doubtful: the cameras see much that is nearer than the near plane,
/// or the coordinates are so large that single precision does not resolve the Gaussians.  Throws Error{kInput}, naming
/// `where`, when most of what the cameras see is nearer than that, unless they are an `orbit` for want of others.
std::vector<std::string> doubtful_units(const std::string& where, const GaussianCloud& cloud,
                                        const std::vector<Camera>& cameras, bool orbit);

}  // namespace pliant
