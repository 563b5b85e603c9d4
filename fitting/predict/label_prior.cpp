#include "fitting/predict/label_prior.h"

#include <fmt/format.h>

#include "fitting/predict/label_words.h"

namespace pliant {
namespace {

/// The prior with the model's numbers in place of the table's.
MaterialPrior with_answer(MaterialPrior prior, const LlmMaterial& answer, const LlmOptions& llm) {
  prior.young = answer.young;
  prior.poisson = answer.poisson;
  prior.density = answer.density;
  prior.words +=
      fmt::format("{}E, nu and rho of what moves by the language model {} at {}: '{}'{}{}",
                  prior.words.empty() ? "" : "; ", llm.model, llm.url, answer.what,
                  answer.clamped ? ", within the bounds of the table" : "", answer.cached ? ", answered earlier" : "");
  return prior;
}

}  // namespace

LabelPrior prior_of_label(const MaterialTable& table, const std::string& label, const LlmOptions& llm,
                          const std::string& view) {
  const std::optional<PriorMatch> match = match_label(table, label);
  LabelPrior out;
  if (match) out.prior = prior_of(*match);
  const LlmAnswer answer = ask_llm(llm, material_bounds(table, match ? &*match : nullptr), label, view);
  if (answer.material) {
    MaterialPrior unknown;
    unknown.name = label_key(label);
    if (unknown.name.empty()) unknown.name = sent_label(label);
    unknown.certainty = 1;
    out.prior = with_answer(match ? *out.prior : unknown, *answer.material, llm);
  } else if (!answer.failure.empty()) {
    out.warning = answer.failure + (match ? "; the table is used" : "; the table does not know the label either");
  }
  return out;
}

}  // namespace pliant
