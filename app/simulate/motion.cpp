#include "app/simulate/motion.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace pliant {
namespace {

constexpr double kNearPins = 1.0 / 3;  // of the farthest particle's distance

/// Distance to the nearest pin, 0 inside.
double distance_to(const std::vector<Region>& pins, const Vec3f& x) {
  double nearest = INFINITY;
  for (const Region& pin : pins) nearest = std::min(nearest, pin.signed_distance(x.cast<double>()));
  return std::max(nearest, 0.0);
}

/// The particles without those of pieces that move by themselves; none where no pin holds anything.
std::vector<int> held_particles(const ParticleFile& file, const std::vector<Region>& pins) {
  std::vector<Vec3f> position;
  std::vector<float> volume;
  std::vector<int> driver;
  double whole = 0;
  for (size_t s = 0; s < file.solid_position.size(); ++s) {
    if (file.solid_driver[s] < 0) continue;
    position.push_back(file.solid_position[s]);
    volume.push_back(file.solid_volume[s]);
    driver.push_back(file.solid_driver[s]);
    whole += file.solid_volume[s];
  }
  const Pieces pieces = find_pieces(position, volume, kPieceReach * static_cast<float>(file.cell_size));
  const std::vector<uint8_t> held = held_pieces(pieces, position, pins);
  if (std::count(held.begin(), held.end(), 1) == 0) return {};
  std::vector<uint8_t> free(file.driving_position.size(), 0);
  for (size_t s = 0; s < position.size(); ++s) {
    const int p = pieces.piece[s];
    if (!held[p] && pieces.weight[p] >= kOwnBody * whole) free[driver[s]] = 1;
  }
  std::vector<int> rest;
  for (size_t d = 0; d < free.size(); ++d)
    if (!free[d]) rest.push_back(static_cast<int>(d));
  return rest;
}

/// Those of `among` in the highest tenth of their extent along up.
std::vector<int> highest(const std::vector<Vec3f>& position, const std::vector<int>& among, const Vec3d& up) {
  double low = INFINITY, high = -INFINITY;
  for (const int p : among) {
    const double h = up.dot(position[p].cast<double>());
    low = std::min(low, h);
    high = std::max(high, h);
  }
  std::vector<int> tip;
  for (const int p : among)
    if (up.dot(position[p].cast<double>()) >= high - 0.1 * (high - low)) tip.push_back(p);
  return tip;
}

}  // namespace

std::vector<uint8_t> held_pieces(const Pieces& pieces, const std::vector<Vec3f>& position,
                                 const std::vector<Region>& pins) {
  std::vector<uint8_t> held(pieces.size(), 0);
  for (size_t i = 0; i < position.size(); ++i)
    for (const Region& pin : pins)
      if (pin.signed_distance(position[i].cast<double>()) < 0) held[pieces.piece[i]] = 1;
  return held;
}

int largest_held(const Pieces& pieces, const std::vector<Vec3f>& position, const std::vector<Region>& pins) {
  const std::vector<uint8_t> held = held_pieces(pieces, position, pins);
  const auto first = std::find(held.begin(), held.end(), 1);
  return first == held.end() ? 0 : static_cast<int>(first - held.begin());
}

ObjectTip tip_of(const ParticleFile& file, const std::vector<Region>& pins, const Vec3d& up) {
  const std::vector<Vec3f>& position = file.driving_position;
  std::vector<int> among = pins.empty() ? std::vector<int>{} : held_particles(file, pins);
  const bool held = !among.empty();
  if (!held)
    for (size_t p = 0; p < position.size(); ++p) among.push_back(static_cast<int>(p));
  ObjectTip tip{highest(position, among, up), true};
  if (!held) return tip;

  std::vector<double> distance(position.size(), 0);
  for (const int p : among) distance[p] = distance_to(pins, position[p]);
  const auto nearer = [&](int a, int b) { return distance[a] < distance[b]; };
  const int end = *std::max_element(among.begin(), among.end(), nearer);
  double mean = 0;
  for (const int p : tip.particles) mean += distance[p] / static_cast<double>(tip.particles.size());
  if (mean >= kNearPins * distance[end]) return tip;

  std::stable_sort(among.begin(), among.end(), [&](int a, int b) { return nearer(b, a); });
  among.resize(std::max<size_t>(1, among.size() / 10));
  // What is held in its middle has two ends.
  std::erase_if(among, [&](int p) { return (position[p] - position[end]).norm() > distance[end]; });
  std::sort(among.begin(), among.end());
  return {among, false};
}

nlohmann::json describe_motion(const TrajectoryFile& trajectory, const ParticleFile& particles, const ObjectTip& tip,
                               double height, double quiet) {
  double peak = 0, end = 0, before = 0, any = 0;
  for (const TrajectoryFile::Frame& frame : trajectory.frames) {
    Vec3d mean = Vec3d::Zero();
    for (const int p : tip.particles) mean += (frame.position[p] - particles.driving_position[p]).cast<double>();
    const double moved = mean.norm() / static_cast<double>(tip.particles.size()) / height;
    peak = std::max(peak, moved);
    end = moved;
    if (frame.time <= quiet) before = std::max(before, moved);
    for (size_t p = 0; p < frame.position.size(); ++p)
      any = std::max(any, static_cast<double>((frame.position[p] - particles.driving_position[p]).norm()) / height);
  }
  return {{"tip_peak", peak}, {"tip_end", end}, {"tip_drift_before", before}, {"particle_peak", any}};
}

}  // namespace pliant
