#include "fitting/predict/material_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fitting/predict/csv_rows.h"
#include "fitting/predict/label_words.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/edit_distance.h"

namespace pliant {
namespace {

const std::vector<std::string> kMaterialTitles = {"name",         "synonyms", "class",      "E_low",     "E_typical",
                                                  "E_high",       "nu_low",   "nu_typical", "nu_high",   "rho_low",
                                                  "rho_typical",  "rho_high", "law",        "constants", "kind",
                                                  "source_gives", "source",   "licence",    "reason"};
const std::vector<std::string> kObjectTitles = {"name",           "synonyms",    "parts",         "height_low",
                                                "height_typical", "height_high", "frequency_low", "frequency_typical",
                                                "frequency_high", "size",        "bulk_density"};

Band band_of(const CsvRow& row, const std::string& quantity) {
  const Band band = {row.number(quantity + "_low"), row.number(quantity + "_typical"), row.number(quantity + "_high")};
  if (band.low > band.typical)
    throw row.complaint(quantity + "_typical", "'" + row.text(quantity + "_typical") + "' is below the lowest",
                        "order lowest, typical, highest");
  if (band.typical > band.high)
    throw row.complaint(quantity + "_high", "'" + row.text(quantity + "_high") + "' is below the typical",
                        "order lowest, typical, highest");
  return band;
}

Material law_of(const CsvRow& row) {
  Material law;
  const std::string& name = row.text("law");
  const std::vector<std::string> names = law_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (!name.empty() && found == names.end())
    throw row.complaint("law", "'" + name + "' is unknown", fmt::format("choose one of {}", fmt::join(names, ", ")));
  if (!name.empty()) law.law = static_cast<Law>(found - names.begin());
  static const std::map<std::string, double Material::*> constants = {
      {"yield_stress", &Material::yield_stress},
      {"plastic_viscosity", &Material::plastic_viscosity},
      {"friction_angle", &Material::friction_angle},
      {"dynamic_viscosity", &Material::dynamic_viscosity}};
  for (const std::string& constant : row.list("constants", ' ')) {
    const size_t equals = constant.find('=');
    const auto member = constants.find(constant.substr(0, equals));
    if (equals == std::string::npos || member == constants.end())
      throw row.complaint("constants", "'" + constant + "' is unknown", "write yield_stress=1e4 or the like");
    try {
      law.*member->second = exact_number(constant.substr(equals + 1));
    } catch (const std::invalid_argument& error) {
      throw row.complaint("constants", error.what(), "write yield_stress=1e4 or the like");
    }
  }
  return law;
}

RowKind kind_of(const CsvRow& row) {
  for (const RowKind kind : {RowKind::kMeasured, RowKind::kHandbook, RowKind::kEstimate})
    if (row.text("kind") == row_kind_name(kind)) return kind;
  throw row.complaint("kind", "'" + row.text("kind") + "' is unknown", "write measured, handbook or estimate");
}

/// Licences under which facts of others may be passed on.
bool may_ship(const std::string& licence) {
  for (const char* allowed : {"CC BY", "CC BY 4.0", "MIT", "BSD-3-Clause", "Apache-2.0"})
    if (licence == allowed) return true;
  return false;
}

void read_source(const CsvRow& row, KnownMaterial& out) {
  out.kind = kind_of(row);
  out.source = row.text("source");
  out.licence = row.text("licence");
  out.reason = row.text("reason");
  for (const std::string& quantity : row.list("source_gives", ' ')) {
    if (quantity != "E" && quantity != "nu" && quantity != "rho")
      throw row.complaint("source_gives", "'" + quantity + "' is unknown", "write E, nu or rho");
    out.young_of_source |= quantity == "E";
    out.poisson_of_source |= quantity == "nu";
    out.density_of_source |= quantity == "rho";
  }
  const bool some = out.young_of_source || out.poisson_of_source || out.density_of_source;
  const bool all = out.young_of_source && out.poisson_of_source && out.density_of_source;
  if (out.kind == RowKind::kEstimate && (some || !out.source.empty() || !out.licence.empty()))
    throw row.complaint("kind", "an estimate with a source", "write measured or handbook, or take the source away");
  if (out.kind != RowKind::kEstimate && !some)
    throw row.complaint("source_gives", "is empty", "say which of E, nu and rho the source gives");
  if (out.kind != RowKind::kEstimate && out.source.empty())
    throw row.complaint("source", "is empty", "name where the numbers were read");
  if (out.kind != RowKind::kEstimate && !may_ship(out.licence))
    throw row.complaint("licence", "'" + out.licence + "' does not allow to pass the numbers on",
                        "take rows under CC BY, MIT, BSD-3-Clause or Apache-2.0");
  if (!all && out.reason.empty()) throw row.complaint("reason", "is empty", "give the reason for what is estimated");
}

KnownMaterial material_of(const CsvRow& row) {
  KnownMaterial out;
  out.name = row.text("name");
  out.synonyms = row.list("synonyms");
  out.group = row.text("class");
  out.young = band_of(row, "E");
  out.poisson = band_of(row, "nu");
  out.density = band_of(row, "rho");
  out.law = law_of(row);
  read_source(row, out);
  if (out.group.empty()) throw row.complaint("class", "is empty", "name the class");
  try {
    validate_material("", out.young.low, out.poisson.low, out.density.low);
    validate_material("", out.young.high, out.poisson.high, out.density.high);
    validate_material("", out.law);
    validate_poisson("", out.law.law, out.poisson.low);
  } catch (const Error& error) {
    throw row.complaint(error.field, error.problem, error.remedy);
  }
  return out;
}

/// "material:share" with the marks *, = and ==.
KnownPart part_of(const CsvRow& row, std::string cell, const std::map<std::string, size_t>& materials) {
  KnownPart part;
  const std::string whole = cell;
  for (; cell.ends_with('*') || cell.ends_with('='); cell.pop_back()) {
    if (cell.ends_with("==")) part.shows = true;
    (cell.ends_with('*') ? part.moves : part.replaceable) = true;
  }
  const size_t colon = cell.find(':');
  const auto material = materials.find(label_key(cell.substr(0, colon)));
  if (material == materials.end())
    throw row.complaint("parts", "'" + whole + "' names no material of the table", "write material:share");
  part.material = material->second;
  try {
    part.share = exact_number(colon == std::string::npos ? "" : cell.substr(colon + 1));
  } catch (const std::invalid_argument&) {
  }
  if (!(part.share > 0 && part.share <= 1))
    throw row.complaint("parts", "'" + whole + "' has no share between 0 and 1", "write material:share");
  return part;
}

KnownObject object_of(const CsvRow& row, const std::map<std::string, size_t>& materials) {
  KnownObject out;
  out.name = row.text("name");
  out.synonyms = row.list("synonyms");
  out.height = band_of(row, "height");
  out.frequency = band_of(row, "frequency");
  if (!(out.height.low > 0)) throw row.complaint("height_low", "is not positive", "give metres");
  if (out.frequency.low < 0) throw row.complaint("frequency_low", "is negative", "give hertz; 0 = rigid");
  out.longest = row.text("size") == "longest";
  if (!out.longest && !row.text("size").empty())
    throw row.complaint("size", "'" + row.text("size") + "' is unknown", "write longest, or nothing for the height");
  if (!row.text("bulk_density").empty()) {
    out.bulk_density = row.number("bulk_density");
    if (!(out.bulk_density > 0)) throw row.complaint("bulk_density", "is not positive", "give kg/m^3, or nothing");
  }
  double sum = 0;
  bool moves = false;
  for (const std::string& cell : row.list("parts")) {
    out.parts.push_back(part_of(row, cell, materials));
    sum += out.parts.back().share;
    moves |= out.parts.back().moves;
  }
  if (std::abs(sum - 1) > 1e-6)
    throw row.complaint("parts", fmt::format("the shares add up to {:g}", sum), "make it 1");
  if (!moves) throw row.complaint("parts", "none is marked with *", "mark what a person sees move");
  return out;
}

/// Enters a row's names; nothing else may have them.
void enter(const CsvRow& row, size_t index, std::map<std::string, size_t>& names, size_t& longest) {
  std::vector<std::string> all = row.list("synonyms");
  all.insert(all.begin(), row.text("name"));
  for (const std::string& name : all) {
    const std::string key = label_key(name);
    if (key.empty()) throw row.complaint("name", "'" + name + "' has no word", "name it");
    if (!names.insert({key, index}).second)
      throw row.complaint("name", "'" + name + "' is already in the table", "keep it in one place");
    longest = std::max(longest, static_cast<size_t>(std::count(key.begin(), key.end(), ' ') + 1));
  }
}

std::string numbers(const Band& band) {
  return fmt::format("{:.3g} ({:.3g} to {:.3g})", band.typical, band.low, band.high);
}

}  // namespace

const char* row_kind_name(RowKind kind) {
  static const char* const names[] = {"measured", "handbook", "estimate"};
  return names[static_cast<int>(kind)];
}

MaterialTable parse_material_table(std::string_view materials, const std::string& materials_file,
                                   std::string_view objects, const std::string& objects_file) {
  MaterialTable table;
  const CsvTable material_rows(materials, materials_file, kMaterialTitles);
  for (const CsvRow& row : material_rows.rows) {
    enter(row, table.materials.size(), table.material_of, table.longest_name);
    table.materials.push_back(material_of(row));
  }
  const CsvTable object_rows(objects, objects_file, kObjectTitles);
  for (const CsvRow& row : object_rows.rows) {
    enter(row, table.objects.size(), table.object_of, table.longest_name);
    table.objects.push_back(object_of(row, table.material_of));
  }
  return table;
}

const MaterialTable& material_table() {
  static const MaterialTable table =
      parse_material_table(materials_csv(), "materials.csv", objects_csv(), "objects.csv");
  return table;
}

const KnownMaterial& find_material(const MaterialTable& table, const std::string& name) {
  const std::string key = label_key(name);
  const auto found = table.material_of.find(key);
  if (found != table.material_of.end()) return table.materials[found->second];
  std::vector<std::pair<size_t, std::string>> near;
  for (const auto& [other, row] : table.material_of) {
    const bool holds = !key.empty() && other.find(key) != std::string::npos;
    near.push_back({holds ? 0 : edit_distance(key, other), other});
  }
  std::sort(near.begin(), near.end());
  near.resize(std::min<size_t>(near.size(), 5));
  std::vector<std::string> names;
  for (const auto& [distance, other] : near) names.push_back(other);
  throw usage_error("--material", "", "'" + name.substr(0, 60) + "' is unknown",
                    fmt::format("near it: {}; 'predict --list' shows all", fmt::join(names, ", ")));
}

std::string material_list(const MaterialTable& table) {
  std::string body;
  std::vector<std::string> counts;
  for (const RowKind kind : {RowKind::kMeasured, RowKind::kHandbook, RowKind::kEstimate}) {
    std::string rows;
    int count = 0;
    for (const KnownMaterial& m : table.materials) {
      if (m.kind != kind) continue;
      ++count;
      rows += fmt::format("  {} [{}]: E {} Pa, nu {}, rho {} kg/m^3, {}\n", m.name, m.group, numbers(m.young),
                          numbers(m.poisson), numbers(m.density), law_name(m.law.law));
      if (kind != RowKind::kEstimate) {
        std::vector<std::string> given;
        if (m.young_of_source) given.push_back("E");
        if (m.poisson_of_source) given.push_back("nu");
        if (m.density_of_source) given.push_back("rho");
        rows += fmt::format("    typical {} of {} ({}); the rest is estimated\n", fmt::join(given, ", "), m.source,
                            m.licence);
      }
    }
    counts.push_back(fmt::format("{} {}", count, row_kind_name(kind)));
    body += fmt::format("\n{} ({})\n{}", row_kind_name(kind), count, rows);
  }
  std::vector<std::string> names;
  for (const KnownObject& object : table.objects) names.push_back(object.name);
  return fmt::format(
      "{} materials ({}), typical values with lowest and highest, and {} objects\n{}\nobjects ({})\n  {}\n",
      table.materials.size(), fmt::join(counts, ", "), table.objects.size(), body, names.size(),
      fmt::join(names, ", "));
}

}  // namespace pliant
