#pragma once

#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "physics/simulate/session.h"

namespace pliant {

/// What a person or a program does to a body that moves; it takes effect before the next frame.
struct LiveCommand {
  enum class Kind { kBegin, kMove, kDrag, kEnd, kSet };
  Kind kind = Kind::kSet;
  int number = 0;               ///< of an interaction, chosen by the sender; what holds the body has 0, 1, ...
  Interaction interaction;      ///< of kBegin
  Vec3d place = Vec3d::Zero();  ///< m: target of kMove; of kDrag by how much the hand has moved since it took hold
  SessionSettings settings;     ///< of kSet
  nlohmann::json text;          ///< as it was sent
};

/// From JSON, as recordings and `pliant view` have it:
///   ["begin", number, [22 numbers]], see interaction_numbers.h, or ["begin", number, {a row of interactions.json}]
///     whose lengths are in scene units, where a grab needs no path: it takes hold of what its region holds now
///   ["move", number, x, y, z], ["drag", number, x, y, z] in metres
///   ["end", number]
///   ["set", factor of Young's modulus, damping time (s, 0 = none), gravity x, y, z (m/s^2)]
/// Throws Error{kUsage} naming `where` and what is wrong: every number is checked.
LiveCommand parse_command(const nlohmann::json& value, const InteractionFrame& frame, const std::string& where);

}  // namespace pliant
