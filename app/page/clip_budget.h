#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/page/coded_motion.h"
#include "app/page/coded_splats.h"
#include "app/simulate/moving_scene.h"

namespace pliant {

/// What goes into a page, in the order in which it is given up when bytes are short.
struct ClipChoice {
  SplatCoding object, background;
  double background_share = 1;  ///< of the background's Gaussians, those that are seen most
  int drivers = 0;              ///< driving particles of the motion; 0 = all
  MotionCoding motion;
  size_t solver_levels = SIZE_MAX;  ///< bodies that the solver has beside that of the motion, at most; the coarsest
  bool solver = true;               ///< false: the page only plays
};

/// The moving scene, coded as chosen.
struct CodedClip {
  ClipChoice choice;
  CodedSplats object, background;
  ParticleFile level;  ///< whose driving particles move
  Binding binding;     ///< of the object's Gaussians to them
  CodedMotion motion;

  /// The object and the background behind it as the page shows frame `t`.
  GaussianCloud decoded_frame(size_t t) const;
};

/// Turns choices into bytes.
class ClipCoder {
 public:
  /// `views`: the cameras from which the background is seen, which say what of it can be left out.
  ClipCoder(MovingScene moving, const Scene& scene, std::vector<Camera> views);
  /// Parts that `before` has of the same choice are taken from it.
  CodedClip code(const ClipChoice& choice, CodedClip before = {});
  /// Sections of a page with that clip, and its size in bytes.
  ClipFile file_of(const CodedClip& clip) const;
  const MovingScene& moving() const { return moving_; }

 private:
  GaussianCloud background_of(double share);

  MovingScene moving_;  ///< Gaussians along a curve
  const Scene& scene_;
  std::vector<Camera> views_;
  std::vector<int> by_importance_;  ///< of the background, what is seen most first; once something is left out
};

/// Appends a binding: `prefix` + driver [N, 8], 65535 = none, and `prefix` + weight [N, 8], 0 = none; the page divides
/// by the sum of the weights.
void add_binding(ClipFile& file, const std::string& section, const std::string& prefix, const Binding& binding);

/// Appends the binding of an object to the driving particles of a level: level{l}.rest, .driver and .weight.
void add_level(ClipFile& file, const std::string& section, size_t l, const std::vector<Vec3f>& rest,
               const Binding& binding);

/// What a page has beside its clip.
struct SolverShare {
  bool needed = false;                             ///< the solver is not given up
  std::function<size_t(const CodedClip&)> levels;  ///< that it can have beside that of this clip
  std::function<size_t(const CodedClip&)> bytes;   ///< that it takes with this clip and its choice
};

/// The best choice whose sections fit into `bytes`, or the smallest one, and what was given up, as words.  `size`:
/// bytes of that, the solver's included.
CodedClip fit_to_size(ClipCoder& coder, size_t bytes, const SolverShare& solver, ClipFile& file, SectionPacker& packer,
                      std::vector<std::string>& given_up, size_t& size);

}  // namespace pliant
