#include "app/store/trajectory.h"

#include <algorithm>

#include "app/store/vectors.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

using Frame = TrajectoryFile::Frame;

/// Step and time belong to every element; they are stored once and linked.
void write_clock(Hdf5Writer& out, const std::string& element, const std::string& first,
                 const std::vector<Frame>& frames) {
  if (element != first) {
    out.link(first + "/step", element + "/step");
    out.link(first + "/time", element + "/time");
    return;
  }
  std::vector<int64_t> step;
  std::vector<double> time;
  for (const Frame& frame : frames) {
    step.push_back(frame.step);
    time.push_back(frame.time);
  }
  out.dataset(element + "/step", step.data(), {step.size()});
  out.dataset(element + "/time", time.data(), {time.size()});
  out.text(element + "/time", "unit", "s");
}

}  // namespace

TrajectoryFile::Frame TrajectoryFile::at(double time) const {
  CHECK(!frames.empty());
  const double tolerance = 1e-6 / fps;
  const auto next =
      std::find_if(frames.begin(), frames.end(), [&](const Frame& f) { return f.time >= time - tolerance; });
  if (next == frames.end()) return frames.back();
  if (next == frames.begin() || next->time <= time + tolerance) return *next;
  const Frame &a = *std::prev(next), &b = *next;
  const float step = static_cast<float>(b.time - a.time), u = static_cast<float>((time - a.time) / (b.time - a.time));
  const float slope = step / static_cast<float>(metres_per_unit), v = 1 - u;
  Frame out = a;
  out.time = time;
  for (size_t p = 0; p < a.position.size(); ++p) {
    out.position[p] = v * v * (1 + 2 * u) * a.position[p] + u * u * (1 + 2 * v) * b.position[p] +
                      u * v * slope * (v * a.velocity[p] - u * b.velocity[p]);
    out.velocity[p] = v * a.velocity[p] + u * b.velocity[p];
    out.F[p] = v * a.F[p] + u * b.F[p];
  }
  return out;
}

std::string group_name(std::string object) {
  std::replace(object.begin(), object.end(), '/', '_');
  return object.empty() || object == "." ? "_" : object;
}

void write_trajectory(const fs::path& file, const TrajectoryFile& t, const std::string& provenance_json) {
  const size_t frames = t.frames.size(), particles = frames ? t.frames[0].position.size() : 0;
  for (const Frame& f : t.frames) {
    CHECK(f.position.size() == particles && f.velocity.size() == particles && f.F.size() == particles);
  }
  CHECK(!t.memory || (t.memory->F.size() == particles && t.memory->F_viscous.size() == particles &&
                      t.memory->history.size() == particles));
  CHECK(!t.object.empty() && t.object == group_name(t.object));
  const std::string root = "/particles/" + t.object, position = root + "/position", velocity = root + "/velocity",
                    F = root + "/F";
  write_hdf5(file, [&](Hdf5Writer& out) {
    for (const std::string& group : {std::string("/h5md"), std::string("/h5md/author"), std::string("/h5md/creator"),
                                     std::string("/particles"), root, root + "/box", position, velocity, F}) {
      out.group(group);
    }
    out.integers("/h5md", "version", {1, 1});
    out.text("/h5md/author", "name", "pliant");
    out.text("/h5md/creator", "name", "pliant");
    out.text("/h5md/creator", "version", PLIANT_VERSION);
    out.integers(root + "/box", "dimension", {3});
    out.texts(root + "/box", "boundary", {"none", "none", "none"});
    for (const std::string& element : {position, velocity, F}) write_clock(out, element, position, t.frames);
    out.slabs<float>(position + "/value", {frames, particles, 3},
                     [&](size_t i) { return t.frames[i].position.data()->data(); });
    out.slabs<float>(velocity + "/value", {frames, particles, 3},
                     [&](size_t i) { return t.frames[i].velocity.data()->data(); });
    std::vector<float> rows(particles * 9);
    out.slabs<float>(F + "/value", {frames, particles, 3, 3}, [&](size_t i) {
      for (size_t p = 0; p < particles; ++p) {
        for (int k = 0; k < 9; ++k) rows[9 * p + k] = t.frames[i].F[p](k / 3, k % 3);
      }
      return rows.data();
    });
    if (t.memory) {
      const std::string memory = root + "/memory";
      out.group(memory);
      write_matrices(out, memory + "/F", t.memory->F);
      write_matrices(out, memory + "/F_viscous", t.memory->F_viscous);
      out.dataset(memory + "/history", t.memory->history.data(), {t.memory->history.size()});
    }
    out.text(position + "/value", "unit", "scene unit");
    out.text(velocity + "/value", "unit", "m s-1");
    out.number("/", "fps", t.fps);
    out.number("/", "metres_per_unit", t.metres_per_unit);
    out.number("/", "cell_size", t.cell_size);
    if (!t.up.isZero()) out.numbers("/", "up", {t.up.x(), t.up.y(), t.up.z()});
    out.text("/", "provenance", provenance_json);
  });
}

std::string read_trajectory_provenance(const fs::path& file) { return Hdf5Reader(file).text("/", "provenance"); }

TrajectoryFile read_trajectory(const fs::path& file, const std::string& object) {
  const Hdf5Reader in(file);
  TrajectoryFile t;
  t.object = object;
  if (object.empty()) {
    const std::vector<std::string> names = in.names_in("/particles");
    if (names.size() != 1)
      throw in.complaint("/particles", "holds " + std::to_string(names.size()) + " objects instead of one");
    t.object = names[0];
  }
  const std::string root = "/particles/" + t.object;
  t.fps = in.number("/", "fps");
  t.metres_per_unit = in.number("/", "metres_per_unit");
  t.cell_size = in.number("/", "cell_size");
  if (!(t.fps > 0)) throw in.complaint("/@fps", "is not positive");
  if (!(t.metres_per_unit > 0)) throw in.complaint("/@metres_per_unit", "is not positive");
  if (in.has_attribute("/", "up")) t.up = Vec3d(in.numbers("/", "up", 3).data());
  const Shape shape = in.shape(root + "/position/value");
  if (shape.size() != 3) throw in.complaint(root + "/position/value", "is not of shape [T, M, 3]");
  const size_t frames = shape[0], particles = shape[1];
  const std::vector<int64_t> step = in.dataset<int64_t>(root + "/position/step", {frames});
  const std::vector<double> time = in.dataset<double>(root + "/position/time", {frames});
  t.frames.resize(frames);
  for (size_t i = 0; i < frames; ++i) {
    t.frames[i].time = time[i];
    t.frames[i].step = step[i];
    if (!std::isfinite(time[i]) || (i > 0 && time[i] <= time[i - 1]))
      throw in.complaint(root + "/position/time", "does not grow");
  }
  const auto vectors = [&](const std::string& name, std::vector<Vec3f> Frame::*member) {
    in.slabs<float>(name, {frames, particles, 3}, [&](size_t i, const float* data) {
      std::vector<Vec3f>& out = t.frames[i].*member;
      out.resize(particles);
      for (size_t p = 0; p < particles; ++p) {
        out[p] = Vec3f(data[3 * p], data[3 * p + 1], data[3 * p + 2]);
        if (!out[p].allFinite())
          throw in.complaint(name, "holds a value that is not finite in frame " + std::to_string(i));
      }
    });
  };
  vectors(root + "/position/value", &Frame::position);
  vectors(root + "/velocity/value", &Frame::velocity);
  in.slabs<float>(root + "/F/value", {frames, particles, 3, 3}, [&](size_t i, const float* data) {
    t.frames[i].F.resize(particles);
    for (size_t p = 0; p < particles; ++p) {
      for (int k = 0; k < 9; ++k) t.frames[i].F[p](k / 3, k % 3) = data[9 * p + k];
      if (!t.frames[i].F[p].allFinite())
        throw in.complaint(root + "/F/value", "holds a value that is not finite in frame " + std::to_string(i));
    }
  });
  if (const std::string memory = root + "/memory"; in.has(memory))
    t.memory = {read_matrices(in, memory + "/F", particles), read_matrices(in, memory + "/F_viscous", particles),
                read_finite(in, memory + "/history", particles)};
  return t;
}

}  // namespace pliant
