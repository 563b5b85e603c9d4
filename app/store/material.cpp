#include "app/store/material.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "app/store/particles.h"
#include "app/store/vectors.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

bool all_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

}  // namespace

void write_material(const fs::path& file, const MaterialFile& m, const std::string& provenance_json) {
  const size_t n = m.young.size();
  CHECK(m.poisson.size() == n && m.density.size() == n);
  for (const auto* values : {&m.young, &m.poisson, &m.density, &m.log10_young_sigma})
    CHECK_MSG(all_finite(*values), "read_material refuses what is not finite");
  CHECK(m.log10_young_sigma.empty() || m.log10_young_sigma.size() == n);
  CHECK(m.branch.empty() || m.branch.size() == n);
  CHECK((m.position.empty() && m.volume.empty()) || (m.position.size() == n && m.volume.size() == n));
  write_hdf5(file, [&](Hdf5Writer& out) {
    out.group("/solid");
    out.dataset("/solid/young", m.young.data(), {n});
    out.dataset("/solid/poisson", m.poisson.data(), {n});
    out.dataset("/solid/density", m.density.data(), {n});
    if (!m.position.empty()) {
      write_vectors(out, "/solid/position", m.position);
      out.dataset("/solid/volume", m.volume.data(), {n});
    }
    if (!m.log10_young_sigma.empty()) out.dataset("/solid/log10_young_sigma", m.log10_young_sigma.data(), {n});
    if (!m.branch.empty()) out.dataset("/solid/branch", &m.branch.data()->shear, {n, 3});
    out.text("/solid", "source", m.source);
    out.text("/", "provenance", provenance_json);
  });
}

MaterialFile read_material(const fs::path& file) {
  const Hdf5Reader in(file);
  MaterialFile m;
  m.young = read_finite(in, "/solid/young", kAny);
  const size_t n = m.young.size();
  m.poisson = read_finite(in, "/solid/poisson", n);
  m.density = read_finite(in, "/solid/density", n);
  if (in.has("/solid/log10_young_sigma")) m.log10_young_sigma = read_finite(in, "/solid/log10_young_sigma", n);
  if (in.has("/solid/branch"))
    for (const Vec3f& row : read_vectors(in, "/solid/branch", n)) {
      if (!(row.minCoeff() > 0))
        throw in.complaint("/solid/branch",
                           "has a value that is not positive in row " + std::to_string(m.branch.size()));
      m.branch.push_back({row.x(), row.y(), row.z()});
    }
  m.source = in.text("/solid", "source");
  for (size_t i = 0; i < n; ++i) {
    if (!(m.young[i] > 0))
      throw in.complaint("/solid/young", "is " + std::to_string(m.young[i]) + " in row " + std::to_string(i));
    if (!(m.poisson[i] > -1 && m.poisson[i] < 0.5f)) {
      throw in.complaint("/solid/poisson", "is " + std::to_string(m.poisson[i]) + " in row " + std::to_string(i));
    }
    if (!(m.density[i] > 0))
      throw in.complaint("/solid/density", "is " + std::to_string(m.density[i]) + " in row " + std::to_string(i));
  }
  if (in.has("/solid/position")) {
    m.position = read_vectors(in, "/solid/position", n);
    m.volume = read_finite(in, "/solid/volume", n);
  } else if (const fs::path beside = file.parent_path() / "particles.h5"; fs::exists(beside)) {
    ParticleFile particles = read_particles(beside);
    // Others were seeded since.
    if (particles.solid_position.size() != n) return m;
    m.position = std::move(particles.solid_position);
    m.volume = std::move(particles.solid_volume);
  }
  return m;
}

}  // namespace pliant
