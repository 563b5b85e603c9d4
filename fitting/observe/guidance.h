#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

// A model that judges rendered videos, as by score distillation, is another program that keeps running (--guidance-cmd
// CMD). It is started as `CMD FOLDER` and talks in lines of JSON: it reads them from standard input and writes them to
// standard output, where lines that do not begin with { are taken for chatter.  Standard error goes to FOLDER/log.txt.
//   it, once ready:  {"ready": 1, "name": "..."}                                        1 = this protocol
//   we, each step:   {"step": n, "frames": "frames.f32", "gradient": "gradient.f32", "shape": [T, H, W, 3], "fps": F}
//   it, each step:   {"step": n, "loss": x}   or   {"step": n, "error": "..."}
//   we, at the end:  {"quit": 1}, and standard input ends
// frames.f32 holds T x H x W x 3 floats (32 bit, little-endian, RGB in [0, 1]); before it answers, the program writes
// gradient.f32 of the same shape: the derivative of its loss by every float.  What is compared with each other is asked
// under one number, so that a program whose noise follows from the number takes the same for both.

struct GuidanceOptions {
  std::string command;
  int first_step = 0;                          ///< that it is asked, when steps were taken earlier
  double start_limit = 600, step_limit = 300;  ///< s until it is ready, and for each step
  std::function<bool()> interrupted;           ///< see ChildOptions
};

struct GuidanceResult {
  double loss = 0;
  std::vector<ImageF> gradient;  ///< [T] of [H, W, 3], dloss/dframes
};

/// The running program.  Everything it does wrong is an Error{kInput} that names the command: it ends, is late, answers
/// another step, or leaves a gradient of the wrong size or with numbers that are not finite.
class Guidance {
 public:
  Guidance(const GuidanceOptions& options, const std::filesystem::path& folder);  ///< returns when it is ready
  ~Guidance();  ///< asks it to end, and kills it if it does not

  const std::string& name() const;
  /// The number of the step that begins.
  int next_step();
  /// `frames` [T] of [H, W, 3], all of one size.
  GuidanceResult evaluate(std::span<const ImageF> frames, double fps, int step);
  GuidanceResult evaluate(std::span<const ImageF> frames, double fps) { return evaluate(frames, fps, next_step()); }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pliant
