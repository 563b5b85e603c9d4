#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "gaussians/io/files/files.h"

namespace pliant {

/// Copies a folder with a run directory `run` in it, which names the scene that it was made from.
inline void copy_prepared(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::filesystem::remove_all(to);
  std::filesystem::copy(from, to, std::filesystem::copy_options::recursive);
  const std::string made_at = read_text(from / "made_at");
  std::string run = read_text(to / "run/run.json");
  for (size_t at = run.find(made_at); at != std::string::npos; at = run.find(made_at, at))
    run.replace(at, made_at.size(), to.string());
  write_text(to / "run/run.json", run);
  write_text(to / "made_at", to.string());
}

/// A folder that `prepare(folder)` has filled, once for all tests of this build of the program: a test that comes while
/// another prepares it waits.
template <class Prepare>
std::filesystem::path prepared_once(const std::string& name, const Prepare& prepare) {
  namespace fs = std::filesystem;
  const fs::path program = fs::read_symlink("/proc/self/exe"), all = program.parent_path() / name;
  const fs::path prepared = all / std::to_string(fs::last_write_time(program).time_since_epoch().count());
  const int lock = open((all.string() + ".lock").c_str(), O_CREAT | O_RDWR, 0644);
  flock(lock, LOCK_EX);
  if (!fs::exists(prepared)) {
    fs::remove_all(all);
    const fs::path partial = all.string() + "_partial";
    fs::remove_all(partial);
    prepare(partial);
    if (!testing::Test::HasFatalFailure()) {
      write_text(partial / "made_at", partial.string());
      fs::create_directories(all);
      fs::rename(partial, prepared);
    }
  }
  close(lock);
  return prepared;
}

}  // namespace pliant
