#include "app/store/frames.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <type_traits>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/sha256.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr char kMagic[8] = {'P', 'L', 'F', 'R', 'A', 'M', 'E', '4'};
constexpr size_t kFloats = 3 + 3 + 9 + 9;  // x, v, C, F of a particle
static_assert(sizeof(LawMemory<float>) == (9 + 9 + 1) * sizeof(float));
constexpr size_t kDigest = 64;

/// What precedes the arrays x, v, C, F and, where there are any, memory of the laws, displacement and velocity of the
/// nodes, and the time for which each particle has been at rest; the SHA-256 of everything before it ends the file.
struct Header {
  char magic[8];
  uint64_t particles, memories, nodes, quiet;
  int64_t frame, substeps;
  double time;
};
static_assert(sizeof(Header) == 64 && std::is_trivially_copyable_v<Header>);

fs::path file_of(const fs::path& folder, int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "%04d.bin", frame);
  return folder / name;
}

template <class T>
void put(std::string& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

template <class T>
void take(const char*& at, size_t count, std::vector<T>& values) {
  values.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), at, count * sizeof(T));
  at += count * sizeof(T);
}

}  // namespace

void write_frame(const fs::path& folder, const SimulationState& state) {
  const size_t n = state.size();
  CHECK(state.v.size() == n && state.C.size() == n && state.F.size() == n);
  CHECK(state.memory.empty() || state.memory.size() == n);
  CHECK(state.node_displacement.size() == state.node_velocity.size());
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.particles = n;
  header.memories = state.memory.size();
  header.nodes = state.node_velocity.size();
  header.quiet = state.quiet_time.size();
  header.frame = state.frame;
  header.substeps = state.substeps;
  header.time = state.time;
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  put(bytes, state.x);
  put(bytes, state.v);
  put(bytes, state.C);
  put(bytes, state.F);
  put(bytes, state.memory);
  put(bytes, state.node_displacement);
  put(bytes, state.node_velocity);
  put(bytes, state.quiet_time);
  bytes += sha256_of_text(bytes);
  write_text(file_of(folder, state.frame), bytes);
}

SimulationState read_frame(const fs::path& folder, int frame) {
  const fs::path file = file_of(folder, frame);
  const std::string bytes = read_text(file);
  const auto damaged = [&](const std::string& field, const std::string& problem) {
    return input_error(file.string(), field, problem, "remove the file; the simulation recreates it");
  };
  Header header;
  if (bytes.size() < sizeof header + kDigest) throw damaged("", "is truncated");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) throw damaged("magic", "is not that of a frame");
  const size_t payload = bytes.size() - sizeof header - kDigest, row = kFloats * sizeof(float);
  constexpr size_t kNode = 2 * sizeof(Vec3f);
  const bool remembers = header.memories != 0;
  if (remembers && header.memories != header.particles)
    throw damaged("particles", "is " + std::to_string(header.particles) + " with internal variables of " +
                                   std::to_string(header.memories));
  const size_t whole_row = row + (remembers ? sizeof(LawMemory<float>) : 0);
  if (header.nodes > payload / kNode)
    throw damaged("nodes", "declares " + std::to_string(header.nodes) + " but there are bytes for " +
                               std::to_string(payload / kNode));
  const size_t of_others = payload - header.nodes * kNode;
  if (header.quiet > of_others / sizeof(float))
    throw damaged("quiet", "declares " + std::to_string(header.quiet) + " but there are bytes for " +
                               std::to_string(of_others / sizeof(float)));
  const size_t of_particles = of_others - header.quiet * sizeof(float);
  if (of_particles % whole_row != 0 || of_particles / whole_row != header.particles) {
    throw damaged("particles", "declares " + std::to_string(header.particles) + " but there are bytes for " +
                                   std::to_string(of_particles / whole_row));
  }
  if (header.frame != frame) throw damaged("frame", "is " + std::to_string(header.frame));
  const size_t end = bytes.size() - kDigest;
  if (sha256_of_text(bytes.substr(0, end)) != bytes.substr(end))
    throw damaged("checksum", "does not match the contents");
  SimulationState state;
  state.frame = frame;
  state.substeps = header.substeps;
  state.time = header.time;
  const char* at = bytes.data() + sizeof header;
  take(at, header.particles, state.x);
  take(at, header.particles, state.v);
  take(at, header.particles, state.C);
  take(at, header.particles, state.F);
  take(at, header.memories, state.memory);
  take(at, header.nodes, state.node_displacement);
  take(at, header.nodes, state.node_velocity);
  take(at, header.quiet, state.quiet_time);
  return state;
}

int last_frame(const fs::path& folder) {
  int last = -1;
  for (std::error_code ignored; fs::is_regular_file(file_of(folder, last + 1), ignored); ++last) {
    try {
      read_frame(folder, last + 1);
    } catch (const Error&) {
      break;
    }
  }
  return last;
}

}  // namespace pliant
