#include "fitting/predict/material_prior.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kBulkFactor = 2;  // between the typical density of a hollow thing and either end of its band

std::string origin_of(const KnownMaterial& m) {
  if (m.kind == RowKind::kEstimate) return "estimate: " + m.reason;
  std::vector<std::string> given, others;
  for (const auto& [name, of_source] :
       {std::pair{"E", m.young_of_source}, std::pair{"nu", m.poisson_of_source}, std::pair{"rho", m.density_of_source}})
    (of_source ? given : others).push_back(name);
  std::string out = fmt::format("{} ({}): {}; {}", fmt::join(given, ", "), row_kind_name(m.kind), m.source, m.licence);
  if (!others.empty()) out += fmt::format("; {} and the band are estimates: {}", fmt::join(others, ", "), m.reason);
  return out;
}

/// Sums a band over the moving parts, each end by itself.
void add(Band& sum, const Band& band, double weight, double (*scale)(double)) {
  sum.low += weight * scale(band.low);
  sum.typical += weight * scale(band.typical);
  sum.high += weight * scale(band.high);
}
/// Density of a hollow thing with what its walls enclose; none of what is solid, as what the label says to be of
/// another class of material than usual is taken to be: a stone ball.
std::optional<double> bulk_density(const PriorMatch& match) {
  if (!match.object || match.figure || match.object->bulk_density == 0) return std::nullopt;
  double moving = 0, log_ratio = 0;
  for (const MatchedPart& part : match.parts) {
    if (!part.moves) continue;
    moving += part.share;
    if (!part.instead_of) continue;
    if (part.instead_of->group != part.material->group) return std::nullopt;
    log_ratio += part.share * std::log(part.material->density.typical / part.instead_of->density.typical);
  }
  return match.object->bulk_density * std::exp(log_ratio / moving);
}
/// Frequency of a shape, which it has of its usual materials, of the materials that the label names.
std::optional<Band> frequency_of(const PriorMatch& match) {
  double moving = 0, log_ratio = 0;
  for (const MatchedPart& part : match.parts) {
    if (!part.moves) continue;
    moving += part.share;
    const KnownMaterial &now = *part.material, &usual = part.instead_of ? *part.instead_of : now;
    log_ratio += part.share * (std::log(now.young.typical / usual.young.typical) -
                               std::log(now.density.typical / usual.density.typical));
  }
  const double factor = std::exp(log_ratio / moving / 2);
  const Band& usual = match.object->frequency;
  if (usual.typical == 0 && factor < 0.1) return std::nullopt;
  return Band{usual.low * factor, usual.typical * factor, usual.high * factor};
}

double logarithm(double value) { return std::log(value); }
double itself(double value) { return value; }

}  // namespace

MaterialPrior prior_of(const PriorMatch& match) {
  CHECK(!match.parts.empty());
  MaterialPrior out;
  out.name = match.object ? match.object->name : match.parts[0].material->name;
  out.certainty = match.certainty;
  out.words = "'" + match.phrase + "' is understood as " + out.name;
  if (match.object && !match.figure) {
    out.height = match.object->height;
    out.longest = match.object->longest;
    out.frequency = frequency_of(match);
  }
  double moving = 0, largest = 0;
  for (const MatchedPart& part : match.parts) moving += part.moves ? part.share : 0;
  CHECK(moving > 0);
  for (const MatchedPart& part : match.parts) {
    const KnownMaterial& m = *part.material;
    const std::string origin = origin_of(m);
    out.parts.push_back({m.name, part.share, part.moves, m.young, m.poisson, m.density, m.law, m.kind, origin});
    out.words += fmt::format("; {:.0f} % {}{} ({})", 100 * part.share, m.name,
                             part.instead_of ? ", named by the label" : "", origin);
    if (!part.moves) continue;
    add(out.young, m.young, part.share / moving, logarithm);
    add(out.poisson, m.poisson, part.share / moving, itself);
    add(out.density, m.density, part.share / moving, logarithm);
    if (part.share > largest) out.law = m.law;
    largest = std::max(largest, part.share);
    if (std::count(out.groups.begin(), out.groups.end(), m.group) == 0) out.groups.push_back(m.group);
  }
  for (double Band::*end : {&Band::low, &Band::typical, &Band::high}) {
    out.young.*end = std::exp(out.young.*end);
    out.density.*end = std::exp(out.density.*end);
  }
  if (const std::optional<double> bulk = bulk_density(match)) {
    out.density = {*bulk / kBulkFactor, *bulk, *bulk * kBulkFactor};
    out.words += fmt::format("; it is hollow: rho {:.3g} kg/m^3 with what it encloses (estimate)", *bulk);
  }
  out.unused = match.unused;
  if (!match.unused.empty()) out.words += "; '" + match.unused + "' in the label changes none of its parts";
  return out;
}

double at_softness(const Band& band, double softness) {
  CHECK(band.low > 0 && band.low <= band.typical && band.typical <= band.high);
  if (!(softness >= 0 && softness <= 1))
    throw usage_error("--softness", "", "is " + std::to_string(softness), "give a number from 0 (stiff) to 1 (soft)");
  if (softness == 0.5) return band.typical;
  const bool stiff = softness < 0.5;
  const double t = stiff ? 1 - 2 * softness : 2 * softness - 1;
  const double end = stiff ? band.high : band.low;
  return t == 1 ? end : band.typical * std::pow(end / band.typical, t);
}

}  // namespace pliant
