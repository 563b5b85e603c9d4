#include "app/store/particles.h"

#include <nlohmann/json.hpp>

#include "app/store/vectors.h"

namespace fs = std::filesystem;

namespace pliant {

namespace {

std::vector<std::array<int, 2>> read_links(const Hdf5Reader& in, size_t drivers) {
  const std::string name = "/driving/links";
  const std::vector<int32_t> ends = in.dataset<int32_t>(name, {in.shape(name).at(0), 2});
  std::vector<std::array<int, 2>> links(ends.size() / 2);
  for (size_t k = 0; k < links.size(); ++k) {
    links[k] = {ends[2 * k], ends[2 * k + 1]};
    if (links[k][0] < 0 || links[k][0] >= links[k][1] || links[k][1] >= static_cast<int>(drivers))
      throw in.complaint(name, "joins " + std::to_string(links[k][0]) + " and " + std::to_string(links[k][1]) + " of " +
                                   std::to_string(drivers) + " drivers");
  }
  return links;
}

/// Samples of disconnected pieces follow simulated ones, and only they do.
std::vector<int> read_follows(const Hdf5Reader& in, const std::vector<int>& driver) {
  const std::string name = "/solid/follows";
  std::vector<int> follows = in.dataset<int32_t>(name, {driver.size()});
  for (size_t s = 0; s < follows.size(); ++s) {
    const int other = follows[s];
    if (other == -1) continue;
    if (other < 0 || other >= static_cast<int>(driver.size()) || driver[other] < 0 || driver[s] >= 0)
      throw in.complaint(name, "has sample " + std::to_string(s) + " follow " + std::to_string(other) + " of " +
                                   std::to_string(driver.size()));
  }
  return follows;
}

}  // namespace

void write_particles(const fs::path& file, const ParticleFile& p, const std::string& provenance_json) {
  const size_t solids = p.solid_position.size(), drivers = p.driving_position.size();
  CHECK(p.solid_volume.size() == solids && p.solid_driver.size() == solids && p.driving_volume.size() == drivers);
  CHECK(p.solid_follows.empty() || p.solid_follows.size() == solids);
  CHECK(p.driving_thickness.size() == p.driving_rod.size() &&
        (p.driving_rod.empty() || p.driving_rod.size() == drivers));
  const std::vector<float> thickness = p.driving_rod.empty() ? std::vector<float>(drivers, 0.0f) : p.driving_thickness;
  const std::vector<uint8_t> rod = p.driving_rod.empty() ? std::vector<uint8_t>(drivers, 0) : p.driving_rod;
  write_hdf5(file, [&](Hdf5Writer& out) {
    out.group("/solid");
    out.group("/driving");
    write_vectors(out, "/solid/position", p.solid_position);
    out.dataset("/solid/volume", p.solid_volume.data(), {solids});
    out.dataset("/solid/driver", p.solid_driver.data(), {solids});
    if (!p.solid_follows.empty()) out.dataset("/solid/follows", p.solid_follows.data(), {solids});
    write_vectors(out, "/driving/position", p.driving_position);
    out.dataset("/driving/volume", p.driving_volume.data(), {drivers});
    out.dataset("/driving/thickness", thickness.data(), {drivers});
    out.dataset("/driving/rod", rod.data(), {drivers});
    out.dataset("/driving/links", p.driving_links.empty() ? nullptr : p.driving_links[0].data(),
                {p.driving_links.size(), 2});
    out.number("/", "cell_size", p.cell_size);
    out.number("/", "metres_per_unit", p.metres_per_unit);
    out.text("/", "pinned", p.pinned_json);
    out.text("/", "provenance", provenance_json);
  });
}

ParticleFile read_particles(const fs::path& file) {
  const Hdf5Reader in(file);
  ParticleFile p;
  p.solid_position = read_vectors(in, "/solid/position");
  p.solid_volume = read_finite(in, "/solid/volume", p.solid_position.size());
  p.solid_driver = in.dataset<int32_t>("/solid/driver", {p.solid_position.size()});
  p.driving_position = read_vectors(in, "/driving/position");
  p.driving_volume = read_finite(in, "/driving/volume", p.driving_position.size());
  p.driving_thickness = read_finite(in, "/driving/thickness", p.driving_position.size());
  p.driving_rod = in.dataset<uint8_t>("/driving/rod", {p.driving_position.size()});
  // Files of earlier versions have none.
  if (in.has("/driving/links")) p.driving_links = read_links(in, p.driving_position.size());
  p.cell_size = in.number("/", "cell_size");
  p.metres_per_unit = in.number("/", "metres_per_unit");
  p.pinned_json = in.text("/", "pinned");
  for (int driver : p.solid_driver) {
    if (driver < -1 || driver >= static_cast<int>(p.driving_position.size())) {
      throw in.complaint("/solid/driver",
                         "names driver " + std::to_string(driver) + " of " + std::to_string(p.driving_position.size()));
    }
  }
  if (in.has("/solid/follows")) p.solid_follows = read_follows(in, p.solid_driver);
  if (!(p.metres_per_unit > 0)) throw in.complaint("/@metres_per_unit", "is not positive");
  if (!nlohmann::json::accept(p.pinned_json)) throw in.complaint("/@pinned", "is not JSON");
  return p;
}

}  // namespace pliant
