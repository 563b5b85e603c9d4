#include "app/store/velocity.h"

#include "app/store/vectors.h"

namespace pliant {
void write_velocity(const std::filesystem::path& file, const VelocityFile& v, const std::string& provenance_json) {
  const size_t n = v.velocity.size();
  CHECK(v.displacement.size() == n && v.F.size() == n && v.C.size() == n &&
        (v.position.empty() || v.position.size() == n));
  write_hdf5(file, [&](Hdf5Writer& out) {
    out.group("/driving");
    write_vectors(out, "/driving/velocity", v.velocity);
    write_vectors(out, "/driving/displacement", v.displacement);
    write_matrices(out, "/driving/F", v.F);
    write_matrices(out, "/driving/C", v.C);
    if (!v.position.empty()) write_vectors(out, "/driving/position", v.position);
    const double scalars[2] = {v.time, v.damping_time};
    out.dataset("/driving/time_and_damping_time", scalars, {2});
    if (v.whole_damping_time > 0) out.dataset("/driving/whole_damping_time", &v.whole_damping_time, {1});
    out.text("/driving", "source", v.source);
    out.text("/", "provenance", provenance_json);
  });
}

VelocityFile read_velocity(const std::filesystem::path& file) {
  const Hdf5Reader in(file);
  VelocityFile v;
  v.velocity = read_vectors(in, "/driving/velocity");
  const size_t n = v.velocity.size();
  v.displacement = read_vectors(in, "/driving/displacement", n);
  v.F = read_matrices(in, "/driving/F", n);
  v.C = read_matrices(in, "/driving/C", n);
  if (in.has("/driving/position")) v.position = read_vectors(in, "/driving/position", n);
  const std::vector<double> scalars = in.dataset<double>("/driving/time_and_damping_time", {2});
  v.time = scalars[0];
  v.damping_time = scalars[1];
  if (!(std::isfinite(v.time) && v.damping_time >= 0 && std::isfinite(v.damping_time)))
    throw in.complaint("/driving/time_and_damping_time",
                       "is " + std::to_string(v.time) + ", " + std::to_string(v.damping_time));
  if (in.has("/driving/whole_damping_time")) {
    v.whole_damping_time = in.dataset<double>("/driving/whole_damping_time", {1})[0];
    if (!(v.whole_damping_time > 0 && std::isfinite(v.whole_damping_time)))
      throw in.complaint("/driving/whole_damping_time", "is " + std::to_string(v.whole_damping_time) + ", not a time");
  }
  v.source = in.text("/driving", "source");
  return v;
}

}  // namespace pliant
