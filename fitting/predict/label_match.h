#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fitting/predict/material_table.h"

namespace pliant {

struct MatchedPart {
  const KnownMaterial* material = nullptr;
  double share = 0;
  bool moves = false;
  const KnownMaterial* instead_of = nullptr;  ///< what it usually is, where the label names its material
};

/// What a label means.  The pointers are into the table.
struct PriorMatch {
  const KnownObject* object = nullptr;  ///< null when the label names a material alone
  bool figure = false;                  ///< of an animal, in another material: a plush elephant
  std::vector<MatchedPart> parts;
  std::string phrase;    ///< the words that were found
  double certainty = 0;  ///< 0..1: share of the label's telling words that were understood
  std::string unused;    ///< the label's word for a material that changes nothing; empty = none
};

/// The object or material that a label names: the last known noun before "with", "in", "of" and the like, with the
/// material that stands before it or follows "of" ("a small wooden chair", "cup of steel", "toy horse").  What things
/// are not built of gives its material to figures alone ("butter knife", but "chocolate statue"), a color that is also
/// a metal only to small hard things ("gold dress", but "gold chain").  Plants in a vase or pot, what a head or arm is
/// "of", and toys ("plush dinosaur", "balloon dog") are understood as such.  Case, hyphens, plural and unknown words do
/// not matter.  Nothing when no word is known (object_1).  Whatever a label says, it is only looked up.
std::optional<PriorMatch> match_label(const MaterialTable& table, std::string_view label);
/// One part that moves, of that material.
PriorMatch match_material(const KnownMaterial& material);

}  // namespace pliant
