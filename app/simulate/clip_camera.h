#pragma once

#include <string>

#include "gaussians/io/scene/scene.h"

namespace pliant {

/// Name of the camera that is asked for: `name` if given, else the reference video's; empty = any that sees it well.
std::string wanted_camera(const Scene& scene, const std::string& name);

/// The camera of that name; a usage error of --camera lists what there is where it is unknown.
const Camera& given_camera(const std::vector<Camera>& cameras, const std::string& name);

/// The camera of the fixed clip: `name` if given (a usage error lists the names when it is unknown), else the reference
/// video's, else the one that sees the whole of `object` largest and nearest the middle; of an orbit, turned to the
/// object and with a lens that shows it large.
Camera clip_camera(const Scene& scene, const std::string& name, const Box& object);

/// 2nd to 98th percentile of the positions, along each axis; of few large Gaussians also what is seen beyond these.
Box robust_bounds(const GaussianCloud& cloud);

}  // namespace pliant
