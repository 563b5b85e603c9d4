#pragma once

#include <span>
#include <vector>

#include "app/page/clip_file.h"
#include "app/simulate/driver_level.h"

namespace pliant {

/// The motion of drivers in integers: what a frame adds to the straight continuation of the two before it, in steps.
/// x[t] = rest + step q[t], q[t] = r[t] + 2 q[t-1] - q[t-2]; the same for F - 1.
struct CodedMotion {
  size_t frames = 0, drivers = 0;
  double position_step = 0, gradient_step = 0;  ///< scene units; 1
  std::vector<int16_t> position;                ///< [T, 3, M]
  std::vector<int16_t> gradient;                ///< [T, 9, M] rows of F
};

struct MotionCoding {
  double position_step = 1e-3;  ///< scene units; raised where residuals would not fit into 16 bits; 0 = the finest
  double gradient_step = 1e-2;

  bool operator==(const MotionCoding&) const = default;
};

CodedMotion code_motion(const MotionCoding& coding, std::span<const Vec3f> rest, std::span<const DriverFrame> frames);
/// Frame `t` of what is left.
DriverFrame decoded(const CodedMotion& motion, std::span<const Vec3f> rest, size_t t);
/// Appends motion.position_low and so on, bytes apart, which compress better, to the section `motion`.
void add_motion(ClipFile& clip, const CodedMotion& motion);

}  // namespace pliant
