#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fitting/predict/label_match.h"

namespace pliant {

struct PartPrior {
  std::string material;
  double share = 0;  ///< of the volume
  bool moves = false;
  Band young, poisson, density;  ///< Pa, 1, kg/m^3
  Material law;
  RowKind kind = RowKind::kEstimate;
  std::string words;  ///< where its numbers come from
};

/// What is known of an object's material from its label alone.
struct MaterialPrior {
  std::string name;
  /// Of the moving parts together: means by volume of log E, nu and log rho, for each end of the bands and for the
  /// typical value.  The density of a hollow thing is that with what its walls enclose.
  Band young, poisson, density;
  Material law;                     ///< of the largest moving part
  std::vector<std::string> groups;  ///< classes of the moving parts
  std::vector<PartPrior> parts;
  std::optional<Band> height;  ///< m, the usual one; none for a material alone and for figures of animals
  bool longest = false;        ///< `height` is that of the longest extent
  /// Hz, the first at which it visibly sways, by the square root of E / rho where the label names another material
  /// than the usual one; 0 = rigid; none where there is no height, and for a rigid thing made of something far softer.
  std::optional<Band> frequency;
  double certainty = 0;  ///< of the match, 0..1; 1 where a language model alone knows the label
  std::string words;     ///< what was understood and where the numbers come from
  std::string unused;    ///< a material in the label that changes nothing; empty = none
};

MaterialPrior prior_of(const PriorMatch& match);

/// A value in a band of positive numbers: softness 0 = its high end, 0.5 = typical, 1 = its low end, between them
/// linear in the logarithm.  Throws Error{kUsage} unless softness is in [0, 1].
double at_softness(const Band& band, double softness);

}  // namespace pliant
