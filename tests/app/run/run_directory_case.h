#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "app/run/run_directory.h"
#include "gaussians/io/files/files.h"

namespace pliant {

/// A run directory whose one stage "work" counts its calls.
class RunDirectoryTest : public ::testing::Test {
 protected:
  RunDirectoryTest() : folder_(std::filesystem::temp_directory_path() / ("pliant_run_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    write_text(input_ = folder_ / "input.txt", "one");
  }
  ~RunDirectoryTest() override { std::filesystem::remove_all(folder_); }

  StageKey key(const nlohmann::json& options) const {
    StageKey key;
    key.name = "work";
    key.options = options;
    key.inputs = {{"input", input_}};
    key.outputs = {"out.txt"};
    return key;
  }
  int run_key(const StageKey& key, bool overwrite = false) {
    RunDirectory directory = RunDirectory::create(folder_ / "run");
    Progress progress(true);
    const Context context{progress, [] { return false; }, 1, 1, overwrite};
    const auto summary = directory.stage(context, key, [&](const std::string& provenance) {
      const std::filesystem::path output = directory / key.outputs[0];
      std::filesystem::create_directories(output.parent_path());
      write_text(output, provenance);
      return nlohmann::json{{"calls", ++calls_}};
    });
    return summary["calls"];
  }
  int run(const nlohmann::json& options, bool overwrite = false, const std::string& output = "out.txt") {
    StageKey work = key(options);
    work.outputs = {output};
    return run_key(work, overwrite);
  }

  std::filesystem::path folder_, input_;
  int calls_ = 0;
};

}  // namespace pliant
