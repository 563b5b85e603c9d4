// How far is the material prior from measurements that it was not made from?
//   material_prior_study MATERIALS.csv OUT.json
// MATERIALS.csv holds rows of name, synonyms, class, E and so on, with a kind.  Two predictions of E are judged:
//   table  the shipped table without every row whose E was measured; a row is asked for by its first synonym, the
//          everyday word, or by its name where it has none;
//   class  the measured rows of the same class but this one: mean of log E, and the 80 % prediction interval of
//          Student's distribution.  It needs classes of at least three rows.
// Handbook rows are compared with the table as well.  Last comes a real silicone beam by the label "silicone rubber".

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "fitting/predict/label_prior.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

using namespace pliant;
using nlohmann::json;

namespace {

struct Sample {
  std::string name, label, group, kind;
  double young = 0;
};

/// Cells of a line of CSV, with quotes (RFC 4180).
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

std::vector<Sample> read_samples(const char* file) {
  std::vector<Sample> samples;
  std::map<std::string, size_t> column;
  const std::string text = read_text(file);
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    const std::vector<std::string> cells = cells_of(text.substr(begin, end - begin));
    begin = end + 1;
    if (column.empty()) {
      for (size_t i = 0; i < cells.size(); ++i) column[cells[i]] = i;
      continue;
    }
    const auto cell = [&](const char* title) { return cells.at(column.at(title)); };
    const auto number = [&](const char* title) { return std::strtod(cell(title).c_str(), nullptr); };
    const double typical = number("E_typ_pa"), low = number("E_lo_pa"), high = number("E_hi_pa");
    const double young = typical > 0 ? typical : std::sqrt(low * high);
    const std::string synonyms = cell("synonyms");
    if (young > 0)
      samples.push_back({cell("name"), synonyms.empty() ? cell("name") : synonyms.substr(0, synonyms.find(';')),
                         cell("class"), cell("kind"), young});
  }
  return samples;
}

bool measured_young(const KnownMaterial& m) { return m.kind == RowKind::kMeasured && m.young_of_source; }

/// The table without the names of rows whose E was measured.
MaterialTable table_without_measurements() {
  MaterialTable table = material_table();
  std::erase_if(table.material_of, [&](const auto& name) { return measured_young(table.materials[name.second]); });
  return table;
}

std::optional<Band> by_table(const MaterialTable& table, const Sample& sample) {
  const auto match = match_label(table, sample.label);
  if (!match) return std::nullopt;
  for (const MatchedPart& part : match->parts)
    if (part.moves && measured_young(*part.material)) return std::nullopt;
  return prior_of(*match).young;
}

/// The 90th percentile of Student's distribution.
double student_90(size_t degrees) {
  static const double t[] = {3.078, 1.886, 1.638, 1.533, 1.476, 1.440, 1.415, 1.397, 1.383, 1.372,
                             1.363, 1.356, 1.350, 1.345, 1.341, 1.337, 1.333, 1.330, 1.328, 1.325};
  return degrees > std::size(t) ? 1.3 : t[degrees - 1];
}

std::optional<Band> by_class(const std::vector<Sample>& samples, size_t left_out) {
  std::vector<double> logs;
  for (size_t i = 0; i < samples.size(); ++i)
    if (i != left_out && samples[i].group == samples[left_out].group) logs.push_back(std::log10(samples[i].young));
  if (logs.size() < 2) return std::nullopt;
  const double n = static_cast<double>(logs.size());
  double mean = 0, square = 0;
  for (const double x : logs) mean += x / n;
  for (const double x : logs) square += (x - mean) * (x - mean) / (n - 1);
  const double half = student_90(logs.size() - 1) * std::sqrt(square * (1 + 1 / n));
  return Band{std::pow(10, mean - half), std::pow(10, mean), std::pow(10, mean + half)};
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

/// Figures of predictions, with a row for each.
struct Tally {
  std::vector<double> errors, widths;
  int inside = 0;
  json rows = json::array();

  void add(const Sample& sample, const Band& band) {
    const double error = std::log10(sample.young / band.typical), width = std::log10(band.high / band.low);
    const bool in = sample.young >= band.low && sample.young <= band.high;
    errors.push_back(std::abs(error));
    widths.push_back(width);
    inside += in;
    rows.push_back({{"name", sample.name},
                    {"label", sample.label},
                    {"class", sample.group},
                    {"E", sample.young},
                    {"band", {band.low, band.typical, band.high}},
                    {"log10_error", error},
                    {"inside", in}});
  }
  json figures(const char* what) const {
    const double share = errors.empty() ? 0 : static_cast<double>(inside) / static_cast<double>(errors.size());
    std::printf("%-44s %3zu rows, %5.1f %% inside, median |log10 error| %.2f, median width %.2f decades\n", what,
                errors.size(), 100 * share, median(errors), median(widths));
    return {{"count", errors.size()},
            {"inside", share},
            {"median_log10_error", median(errors)},
            {"median_width_decades", median(widths)},
            {"rows", rows}};
  }
};

/// The beam of beam_study: E by its authors from another load case.
json silicone_beam() {
  const MaterialPrior prior = prior_of_label(material_table(), "silicone rubber").prior.value();
  const auto judged = [](double truth, const Band& band) -> json {
    return {{"truth", truth},
            {"band", {band.low, band.typical, band.high}},
            {"inside", truth >= band.low && truth <= band.high}};
  };
  const double young = 263824;
  std::printf("silicone beam: E %.3g against %.3g (%.3g to %.3g), log10 error %.2f\n", young, prior.young.typical,
              prior.young.low, prior.young.high, std::log10(young / prior.young.typical));
  return {
      {"E", judged(young, prior.young)}, {"nu", judged(0.499, prior.poisson)}, {"rho", judged(1070, prior.density)}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s MATERIALS.csv OUT.json\n", argv[0]);
    return 2;
  }
  std::vector<Sample> measured, handbook;
  for (const Sample& sample : read_samples(argv[1])) {
    if (sample.kind == "measured") measured.push_back(sample);
    if (sample.kind == "handbook") handbook.push_back(sample);
  }
  std::map<std::string, int> class_size;
  for (const Sample& sample : measured) ++class_size[sample.group];
  const MaterialTable table = table_without_measurements();
  Tally table_large, table_small, class_large, table_handbook;
  json small_classes = json::array(), not_in_table = json::array();
  for (size_t i = 0; i < measured.size(); ++i) {
    const bool large = class_size[measured[i].group] >= 3;
    const auto band = by_table(table, measured[i]);
    if (band) (large ? table_large : table_small).add(measured[i], *band);
    if (!band) not_in_table.push_back(measured[i].label);
    if (large) class_large.add(measured[i], by_class(measured, i).value());
    if (!large) small_classes.push_back(measured[i].name);
  }
  for (const Sample& sample : handbook)
    if (const auto band = by_table(table, sample)) table_handbook.add(sample, *band);
  const json out = {{"table", table_large.figures("table, measured rows of classes of three or more")},
                    {"table_small_classes", table_small.figures("table, measured rows of smaller classes")},
                    {"class", class_large.figures("class without the row")},
                    {"handbook", table_handbook.figures("table, handbook rows")},
                    {"without_class", small_classes},
                    {"without_table_entry", not_in_table},
                    {"silicone_beam", silicone_beam()}};
  write_json(argv[2], out);
  return 0;
}
