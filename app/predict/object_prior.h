#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "fitting/predict/llm_client.h"
#include "fitting/predict/material_prior.h"
#include "gaussians/base/error.h"

namespace pliant {

/// What is believed of an object's material before its shape is looked at.
struct ObjectPrior {
  std::string name;               ///< what was understood: "potted palm"; "soft solid" where nothing was
  bool guessed = false;           ///< nothing is known of it: E follows from `frequency` alone
  bool unanswered = false;        ///< a language model was asked and gave nothing
  Band young, poisson, density;   ///< Pa, 1, kg/m^3; of the parts that move
  std::optional<Band> frequency;  ///< Hz, of its first sway; a typical 0 = rigid
  std::optional<Band> height;     ///< m
  bool longest = false;           ///< `height` is that of the longest extent
  Material law;
  std::string source;   ///< where the numbers come from, for people
  std::string warning;  ///< that a language model that was asked gave nothing, that little of the label is known, or
                        ///< that a material in it counts for nothing; empty = nothing to say
};

/// What is asked for: `material` a row of the table, else `label`, else the object's own `name`, which need not mean
/// anything.  Throws Error{kUsage} for an unknown material, or for a label that names nothing known.
struct PriorQuestion {
  std::string material, label, name;
  LlmOptions llm;
  std::string view;  ///< PNG of the object for the language model
};
ObjectPrior object_prior(const PriorQuestion& question);

/// That a label names nothing known; `failure`: what became of a language model that was asked, empty = none was.
Error unknown_label(const std::string& label, const std::string& failure = "");

/// {low, typical, high}.
nlohmann::json band_json(const Band& band);

}  // namespace pliant
