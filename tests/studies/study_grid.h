#pragma once

#include <cstring>

#include "physics/simulate/simulate.h"

namespace pliant::fixture {

/// Takes the word grid=eulerian or grid=lagrangian out of a study's arguments.
inline GridKind take_grid(int& argc, char** argv) {
  GridKind grid = GridKind::kAutomatic;
  int kept = 1;
  for (int a = 1; a < argc; ++a) {
    if (std::strcmp(argv[a], "grid=eulerian") == 0)
      grid = GridKind::kEulerian;
    else if (std::strcmp(argv[a], "grid=lagrangian") == 0)
      grid = GridKind::kLagrangian;
    else
      argv[kept++] = argv[a];
  }
  argc = kept;
  return grid;
}

}  // namespace pliant::fixture
