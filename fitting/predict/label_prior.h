#pragma once

#include <optional>
#include <string>

#include "fitting/predict/llm_client.h"
#include "fitting/predict/material_prior.h"

namespace pliant {

struct LabelPrior {
  std::optional<MaterialPrior> prior;  ///< none when neither the table nor the model knows the label
  std::string warning;                 ///< why the model gave nothing although it was asked, and what is used instead
};

/// The prior of what a label names: looked up in the table, and where a language model is asked and answers, with its
/// E, nu and rho for the moving parts together (the parts themselves, law, height and frequency stay the table's).
/// `view` is a PNG for the model and may be empty.
LabelPrior prior_of_label(const MaterialTable& table, const std::string& label, const LlmOptions& llm = {},
                          const std::string& view = "");

}  // namespace pliant
