#include "fitting/observe/markers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>

#include "gaussians/base/error.h"
#include "gaussians/io/files/text.h"

namespace pliant {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Shares of the largest motion: of a spike in motion and at rest, and how near to its first place a marker rests.
constexpr double kSpikeInMotion = 2, kSpikeAtRest = 0.1, kResting = 0.05;

/// Without space and quotes around it.
std::string bare(const std::string& text) { return trimmed(text, " \t\r\""); }

std::vector<std::string> cells_of(const std::string& line, char separator) {
  std::vector<std::string> cells = split(line, separator);
  for (std::string& cell : cells) cell = bare(cell);
  return cells;
}

bool remove_ending(std::string& text, const std::string& ending) {
  if (text.size() < ending.size() || lower_case(text.substr(text.size() - ending.size())) != ending) return false;
  text.resize(text.size() - ending.size());
  return true;
}

/// What the columns of a table mean.
struct Columns {
  std::vector<std::string> title;
  int time = -1;
  double time_unit = 1;
  struct Marker {
    std::string name;
    std::array<int, 3> column = {-1, -1, -1};
    std::array<double, 3> unit = {1, 1, 1};
  };
  std::vector<Marker> markers;
};

Columns columns_of(const std::vector<std::string>& titles, double unit_of_unnamed, const std::string& file,
                   size_t line) {
  Columns out;
  out.title = titles;
  const auto fail = [&](size_t column, const std::string& problem, const std::string& remedy) {
    throw input_error(file, "line " + std::to_string(line) + ", column " + std::to_string(column + 1), problem, remedy);
  };
  for (size_t column = 0; column < titles.size(); ++column) {
    std::string name = titles[column];
    const std::string plain = lower_case(name);
    if (plain == "t" || plain == "time" || plain == "t_s" || plain == "time_s" || plain == "t_ms" ||
        plain == "time_ms") {
      if (out.time >= 0) fail(column, "a second column of times, '" + name + "'", "keep one");
      out.time = static_cast<int>(column);
      out.time_unit = plain.ends_with("_ms") ? 1e-3 : 1;
      continue;
    }
    const double unit = remove_ending(name, "_mm") ? 1e-3 : remove_ending(name, "_m") ? 1 : unit_of_unnamed;
    const char axis = name.empty() ? ' ' : lower_case(name).back();
    const bool alone = name.size() == 1;
    if (axis < 'x' || axis > 'z' || !(alone || name[name.size() - 2] == '_'))
      fail(column, "'" + titles[column] + "' is neither a time nor a coordinate",
           "name the columns time, m0_x, m0_y, m0_z, m1_x ...");
    name = alone ? "" : name.substr(0, name.size() - 2);
    // Without names, a marker is complete when its coordinate comes a second time.
    auto marker = std::find_if(out.markers.begin(), out.markers.end(), [&](const Columns::Marker& m) {
      return alone ? &m == &out.markers.back() && m.column[axis - 'x'] < 0 : m.name == name;
    });
    if (marker == out.markers.end()) {
      out.markers.push_back(
          {alone ? std::string("m").append(std::to_string(out.markers.size())) : name, {-1, -1, -1}, {1, 1, 1}});
      marker = out.markers.end() - 1;
    }
    if (marker->column[axis - 'x'] >= 0)
      fail(column, "a second column '" + titles[column] + "'", "give every marker a name of its own");
    marker->column[axis - 'x'] = static_cast<int>(column);
    marker->unit[axis - 'x'] = unit;
  }
  if (out.time < 0) fail(0, "no column of times", "name it 'time' (seconds)");
  if (out.markers.empty()) fail(0, "no marker", "name the columns time, m0_x, m0_y, m0_z, m1_x ...");
  for (const Columns::Marker& m : out.markers)
    for (int a = 0; a < 3; ++a)
      if (m.column[a] < 0)
        throw input_error(file, "line " + std::to_string(line),
                          "marker '" + m.name + "' has no " + "xyz"[a] + " column", "give x, y and z of every marker");
  return out;
}

/// NaN for a gap.
double number(const std::string& cell, const std::string& file, size_t line, int column, const Columns& columns) {
  const std::string plain = lower_case(cell);
  if (plain.empty() || plain == "nan" || plain == "na") return kNaN;
  double value = 0;
  const char* begin = cell.data() + (cell[0] == '+');
  const auto [end, error] = std::from_chars(begin, cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
    throw input_error(
        file,
        "line " + std::to_string(line) + ", column " + std::to_string(column + 1) + " (" + columns.title[column] + ")",
        "'" + cell + "' is not a number", "write decimal numbers with a point; leave a gap empty");
  return value;
}

/// Samples from `begin` on in which a marker was measured.
std::vector<size_t> measured_samples(const MarkerTracks& tracks, size_t marker, double begin) {
  std::vector<size_t> out;
  for (size_t t = 0; t < tracks.samples(); ++t)
    if (tracks.time[t] >= begin && tracks.weight[t][marker] > 0) out.push_back(t);
  return out;
}

/// [samples] m from `rest` that a marker is away in a sample and again in one of the next two.
std::vector<double> lasting_distance(const MarkerTracks& tracks, size_t marker, std::span<const size_t> samples,
                                     const Vec3d& rest) {
  std::vector<double> distance, out;
  for (const size_t t : samples) distance.push_back((tracks.position[t][marker] - rest).norm());
  for (size_t i = 0; i < distance.size(); ++i) {
    double later = 0;
    for (size_t j = i + 1; j < std::min(i + 3, distance.size()); ++j) later = std::max(later, distance[j]);
    out.push_back(std::min(distance[i], later));
  }
  return out;
}

}  // namespace

MarkerTracks read_markers(const std::filesystem::path& path, double unit_of_unnamed) {
  const std::string file = path.string();
  std::ifstream in(path);
  if (!in) throw input_error(file, "", "cannot be read", "check the path");
  MarkerTracks tracks;
  Columns columns;
  char separator = ',';
  size_t at = 0;
  for (std::string line; std::getline(in, line);) {
    ++at;
    if (at == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    if (bare(line).empty() || bare(line)[0] == '#') continue;
    if (columns.title.empty()) {
      separator = line.find(';') != std::string::npos ? ';' : ',';
      columns = columns_of(cells_of(line, separator), unit_of_unnamed, file, at);
      for (const Columns::Marker& m : columns.markers) tracks.name.push_back(m.name);
      continue;
    }
    const std::vector<std::string> cells = cells_of(line, separator);
    const std::string where = "line " + std::to_string(at);
    if (cells.size() != columns.title.size())
      throw input_error(
          file, where,
          std::to_string(cells.size()) + " columns where the first line has " + std::to_string(columns.title.size()),
          "complete the line; leave gaps empty");
    const auto cell = [&](int column) { return number(cells[column], file, at, column, columns); };
    const double time = columns.time_unit * cell(columns.time);
    if (!std::isfinite(time))
      throw input_error(file, where + ", column " + std::to_string(columns.time + 1), "no time",
                        "every line needs one");
    if (!tracks.time.empty() && time <= tracks.time.back())
      throw input_error(file, where + ", column " + std::to_string(columns.time + 1),
                        "time " + cells[columns.time] + " does not come after the line before",
                        "sort the lines by time");
    tracks.time.push_back(time);
    tracks.position.emplace_back();
    tracks.weight.emplace_back();
    for (const Columns::Marker& m : columns.markers) {
      Vec3d x;
      for (int a = 0; a < 3; ++a) x[a] = m.unit[a] * cell(m.column[a]);
      const bool measured = x.allFinite();
      tracks.position.back().push_back(measured ? x : Vec3d::Zero());
      tracks.weight.back().push_back(measured ? 1 : 0);
    }
  }
  if (tracks.samples() < 2)
    throw input_error(file, "", "fewer than two lines of measurements", "give a line of names and one per instant");
  return tracks;
}

MarkerTracks resampled(const MarkerTracks& tracks, std::span<const double> times) {
  MarkerTracks out;
  out.name = tracks.name;
  out.time.assign(times.begin(), times.end());
  for (const double t : times) {
    out.position.emplace_back(tracks.markers(), Vec3d::Zero());
    out.weight.emplace_back(tracks.markers(), 0.0);
    const size_t after = std::lower_bound(tracks.time.begin(), tracks.time.end(), t) - tracks.time.begin();
    if (after == tracks.samples()) continue;
    const bool exact = tracks.time[after] == t;
    if (after == 0 && !exact) continue;
    const size_t before = exact ? after : after - 1;
    const double f = exact ? 0 : (t - tracks.time[before]) / (tracks.time[after] - tracks.time[before]);
    for (size_t k = 0; k < tracks.markers(); ++k) {
      out.weight.back()[k] = std::min(tracks.weight[before][k], tracks.weight[after][k]);
      if (out.weight.back()[k] > 0)
        out.position.back()[k] = (1 - f) * tracks.position[before][k] + f * tracks.position[after][k];
    }
  }
  return out;
}

std::vector<Vec3d> mean_position(const MarkerTracks& tracks, double begin, double end) {
  std::vector<Vec3d> mean(tracks.markers(), Vec3d::Zero());
  for (size_t k = 0; k < mean.size(); ++k) {
    double total = 0;
    for (size_t t = 0; t < tracks.samples(); ++t) {
      if (tracks.time[t] < begin || tracks.time[t] > end) continue;
      mean[k] += tracks.weight[t][k] * tracks.position[t][k];
      total += tracks.weight[t][k];
    }
    mean[k] /= total;  // NaN where nothing was measured
  }
  return mean;
}

double onset_of_motion(const MarkerTracks& tracks, std::span<const Vec3d> rest, double share) {
  CHECK(rest.size() == tracks.markers() && tracks.samples() > 0);
  std::vector<double> distance(tracks.samples(), 0.0);
  for (size_t k = 0; k < rest.size(); ++k) {
    if (!rest[k].allFinite()) continue;
    const std::vector<size_t> seen = measured_samples(tracks, k, tracks.time.front());
    const std::vector<double> own = lasting_distance(tracks, k, seen, rest[k]);
    for (size_t i = 0; i < seen.size(); ++i) distance[seen[i]] = std::max(distance[seen[i]], own[i]);
  }
  const double largest = *std::ranges::max_element(distance);
  size_t onset = 0;
  while (largest > 0 && onset < tracks.samples() && distance[onset] <= share * largest) ++onset;
  return tracks.time[onset > 0 ? onset - 1 : 0];
}

MarkerTracks without_spikes(const MarkerTracks& tracks, double begin) {
  std::vector<std::vector<size_t>> seen;  // [K]
  double largest = 0;
  for (size_t k = 0; k < tracks.markers(); ++k) {
    seen.push_back(measured_samples(tracks, k, begin));
    if (seen[k].empty()) continue;
    for (const double d : lasting_distance(tracks, k, seen[k], tracks.position[seen[k][0]][k]))
      largest = std::max(largest, d);
  }
  MarkerTracks out = tracks;
  if (!(largest > 0)) return out;
  for (size_t k = 0; k < tracks.markers(); ++k) {
    const auto apart = [&](size_t i, size_t j) {
      return (tracks.position[seen[k][i]][k] - tracks.position[seen[k][j]][k]).norm();
    };
    for (size_t i = 1; i + 1 < seen[k].size(); ++i) {
      bool resting = true;  // but for this sample
      for (size_t j = i < 2 ? 0 : i - 2; j < std::min(i + 3, seen[k].size()); ++j)
        resting = resting && (j == i || apart(0, j) <= kResting * largest);
      const double jump = std::min(apart(i, i - 1), apart(i, i + 1));
      if (jump > (resting ? kSpikeAtRest : kSpikeInMotion) * largest && apart(i - 1, i + 1) < 0.5 * jump)
        out.weight[seen[k][i]][k] = 0;
    }
  }
  return out;
}

}  // namespace pliant
