#pragma once

#include <string>
#include <vector>

#include "segmentation/discover/automatic_parts.h"

namespace pliant {

/// Objects found from the Gaussians themselves, with no masks, prompts or learnt weights.
struct AutomaticOptions {
  Vec3f up = Vec3f::UnitZ();  ///< unit
  SolidOptions solid;
  SupportOptions support;
  PartOptions part;
  float haze =
      16;  ///< what makes no surface is of the nearest one as far as it reaches, or so many spacings; else rest
  std::vector<int> held_out;  ///< cameras that are not looked at
};

struct FoundThing {
  enum class Kind { kObject, kSupport, kRest };
  uint32_t id = 0;
  std::string name;  ///< object_1, ... by size; support_1 the ground, further ones walls; rest
  Kind kind = Kind::kObject;
  std::string how;   ///< how it was found, a phrase
  double share = 0;  ///< of a picture, mean over the views looked at
};

struct AutomaticSummary {
  size_t solid = 0;  ///< Gaussians that make surfaces
  int views = 0, objects = 0, supports = 0;
  double rest = 0;  ///< share of what the views show that is neither object nor support
  double seconds = 0;
  std::string describe() const;
};

struct AutomaticResult {
  std::vector<uint32_t> label;    ///< [N] id
  std::vector<FoundThing> found;  ///< by id: objects, then supports, then the rest
  AutomaticSummary summary;
};

/// Takes the planes that things stand on out of the scene's graph of Gaussians; what is left falls into free-standing
/// objects.  Parts that stand on nothing go to the rest.  Where there is no support, the rest near an object belongs to
/// it, and a splat of one thing alone is whole.  Equal bit for bit for any number of threads.
AutomaticResult find_objects(const AutomaticOptions& options, const GaussianCloud& cloud,
                             const std::vector<Camera>& cameras);

}  // namespace pliant
