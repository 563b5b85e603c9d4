#pragma once

#include <string>
#include <vector>

#include "app/commands/program.h"

namespace pliant {

/// Runs the program with these arguments; returns its exit code.
inline int run_pliant(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "pliant");
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  return run_program(static_cast<int>(argv.size()), argv.data());
}

/// The same without messages.
inline int run_quietly(std::vector<std::string> arguments) {
  arguments.push_back("--quiet");
  return run_pliant(std::move(arguments));
}

}  // namespace pliant
