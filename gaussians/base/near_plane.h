#pragma once

namespace pliant {

constexpr double kNearPlane = 0.2;  ///< scene units; nothing nearer to a camera is rendered, as in the reference 3DGS

}  // namespace pliant
