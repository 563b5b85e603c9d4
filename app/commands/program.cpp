#include "app/commands/program.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "gaussians/base/error.h"

namespace pliant {

int run_program(int argc, const char* const* argv) {
  CLI::App program("Gaussian splats in, an object you can grab out.", "pliant");
  program.set_version_flag("--version", PLIANT_VERSION);
  try {
    program.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    const int code = program.exit(error);
    return code == 0 ? 0 : static_cast<int>(Failure::kUsage);
  } catch (const Error& error) {
    std::fprintf(stderr, "pliant: %s\n", error.what());
    return static_cast<int>(error.failure);
  }
}

}  // namespace pliant
