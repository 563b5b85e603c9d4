#pragma once

#include <string>
#include <vector>

#include "fitting/distribution/material_object.h"
#include "fitting/distribution/object_families.h"

namespace pliant {

/// Names of the families of one role.  No family has two, so that what validates and what tests is of kinds that
/// training has not seen.
std::vector<std::string> corpus_families(FamilyRole role);

/// The object of a family for a seed, the same each time.  Throws Error{kUsage} for an unknown family.
MaterialObject make_object(const std::string& family, uint64_t seed);

}  // namespace pliant
