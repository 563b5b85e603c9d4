#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fitting/distribution/material_object.h"

namespace pliant::study {

/// Families of objects that judge the distribution network: "sunflower" and "parasol".  Their rules share nothing with
/// those of the training objects and stay as they are once a network has been trained.
const std::vector<std::string>& held_out_families();

/// The object of a family for a seed: 800 to 2500 samples over pieces (stalk, leaf, rib, panel ...) whose samples are
/// spread evenly, part ids by kind, z up, metres.  Young's moduli are argued from measurements where there are some;
/// each comment says which.  Samples below the surface carry its colour and the thickness of the rod that they lie in,
/// so that neither tells rind from pith.  Deterministic.
MaterialObject make_held_out(const std::string& family, uint64_t seed);

}  // namespace pliant::study
