#include "app/store/solid.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/store/vectors.h"

namespace fs = std::filesystem;

namespace pliant {

void write_solid(const fs::path& file, const SolidFile& solid, const std::string& provenance_json) {
  const SolidSamples& s = solid.samples;
  CHECK(s.volume.size() == s.size() && s.thickness.size() == s.size() && s.rod.size() == s.size() &&
        solid.simulated.size() == s.size());
  write_hdf5(file, [&](Hdf5Writer& out) {
    out.group("/solid");
    write_vectors(out, "/solid/position", s.position);
    out.dataset("/solid/volume", s.volume.data(), {s.size()});
    out.dataset("/solid/thickness", s.thickness.data(), {s.size()});
    out.dataset("/solid/rod", s.rod.data(), {s.size()});
    out.dataset("/solid/simulated", solid.simulated.data(), {s.size()});
    out.number("/", "spacing", s.spacing);
    out.number("/", "volume", solid.volume);
    out.text("/", "pinned", solid.pinned_json);
    out.text("/", "provenance", provenance_json);
  });
}

SolidFile read_solid(const fs::path& file) {
  const Hdf5Reader in(file);
  SolidFile solid;
  SolidSamples& s = solid.samples;
  s.position = read_vectors(in, "/solid/position");
  s.volume = read_finite(in, "/solid/volume", s.size());
  s.thickness = read_finite(in, "/solid/thickness", s.size());
  s.rod = in.dataset<uint8_t>("/solid/rod", {s.size()});
  solid.simulated = in.dataset<uint8_t>("/solid/simulated", {s.size()});
  s.spacing = static_cast<float>(in.number("/", "spacing"));
  solid.volume = in.number("/", "volume");
  solid.pinned_json = in.text("/", "pinned");
  if (std::any_of(solid.simulated.begin(), solid.simulated.end(), [](uint8_t flag) { return flag > 1; }))
    throw in.complaint("/solid/simulated", "holds values other than 0 and 1");
  if (!(s.spacing > 0)) throw in.complaint("/@spacing", "is not positive");
  if (!nlohmann::json::accept(solid.pinned_json)) throw in.complaint("/@pinned", "is not JSON");
  return solid;
}

}  // namespace pliant
