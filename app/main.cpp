#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "app/commands/program.h"
#include "gaussians/base/memory.h"

namespace {

/// Threads that wait for others spin for about 30 us and then sleep: GNU OpenMP's own choice, some milliseconds, makes
/// a machine with other work on it up to 20 times slower.  It reads the setting before main, so the program starts
/// anew. What only prints a text need not.
void wait_politely(int argc, char** argv) {
  const std::string_view last = argv[argc - 1];
  const bool only_text = argc < 2 || last == "--version" || last == "--help" || last == "-h";
  if (only_text || getenv("GOMP_SPINCOUNT") || getenv("OMP_WAIT_POLICY")) return;
  setenv("GOMP_SPINCOUNT", "10000", 1);
  execv("/proc/self/exe", argv);  // where that fails, it goes on with the choice of the library
}

}  // namespace

int main(int argc, char** argv) {
  wait_politely(argc, argv);
  pliant::keep_freed_memory();
  return pliant::run_program(argc, argv);
}
