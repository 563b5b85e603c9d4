#include "app/simulate/interactions_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kLoadsFile = "interactions.json";
constexpr const char* kOwnLoads = "interactions";  // note: SHA-256 of the file as this program last wrote it

}  // namespace

void record_loads(const Context& context, RunDirectory& run, const json& loads) {
  const fs::path file = run / kLoadsFile;
  if (fs::exists(file)) {
    if (json::parse(read_text(file), nullptr, false) == loads) return;
    if (run.note(kOwnLoads) != hash_of_input(file)) {
      const std::string aside = run.move_aside({kLoadsFile}).at(kLoadsFile);
      context.progress.say(
          fmt::format("simulate: {} holds the loads of this simulation; the one that was there is kept as {} "
                      "(--interactions {} simulates it)",
                      kLoadsFile, aside, (run / aside).string()));
    }
  }
  write_text(file, loads.dump(2) + "\n");
  run.set_note(kOwnLoads, hash_of_input(file));
}

}  // namespace pliant
