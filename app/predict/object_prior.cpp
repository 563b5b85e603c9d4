#include "app/predict/object_prior.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "fitting/predict/label_prior.h"

namespace pliant {
namespace {

constexpr double kUnderstood = 0.6;  // of the words of a label, of which fewer are worth a warning

/// A solid of which nothing is known: motion that people take for natural, light like most things that yield.
ObjectPrior soft_solid() {
  ObjectPrior prior;
  prior.name = "soft solid";
  prior.guessed = true;
  prior.young = {1e4, 1e5, 1e6};
  prior.poisson = {0.2, 0.3, 0.45};
  prior.density = {100, 500, 1200};
  prior.frequency = Band{0.7, 2, 6};
  prior.source = "a guess: what the object is made of is unknown";
  return prior;
}

ObjectPrior of(const MaterialPrior& known, const std::string& warning) {
  return {known.name,      false,        false,         known.young, known.poisson, known.density,
          known.frequency, known.height, known.longest, known.law,   known.words,   warning};
}

}  // namespace

ObjectPrior object_prior(const PriorQuestion& question) {
  if (!question.material.empty())
    return of(prior_of(match_material(find_material(material_table(), question.material))), "");
  const std::string& label = question.label.empty() ? question.name : question.label;
  const LabelPrior found = prior_of_label(material_table(), label, question.llm, question.view);
  if (!found.prior && !question.label.empty()) throw unknown_label(question.label, found.warning);
  if (!found.prior) {
    ObjectPrior prior = soft_solid();
    prior.warning = found.warning;
    prior.unanswered = !found.warning.empty();
    return prior;
  }
  std::string warning = found.warning;
  const auto warn = [&](const std::string& what) { warning += (warning.empty() ? "" : "; ") + what; };
  if (found.prior->certainty < kUnderstood)
    warn(fmt::format("only part of '{}' is known; it is treated as '{}' (pliant predict --list shows all)",
                     label.substr(0, 60), found.prior->name));
  if (!found.prior->unused.empty())
    warn(fmt::format("'{}' in '{}' is not taken for the material of '{}' (--material NAME sets one)",
                     found.prior->unused, label.substr(0, 60), found.prior->name));
  ObjectPrior prior = of(*found.prior, warning);
  prior.unanswered = !found.warning.empty();
  return prior;
}

Error unknown_label(const std::string& label, const std::string& failure) {
  return usage_error(
      "--label", label.substr(0, 60),
      "is not a known object or material" + (failure.empty() ? "" : " (" + failure + ")"),
      "'pliant predict --list' shows all; or give --material NAME, or --young E --poisson NU --density RHO");
}

nlohmann::json band_json(const Band& band) {
  return {{"low", band.low}, {"typical", band.typical}, {"high", band.high}};
}

}  // namespace pliant
