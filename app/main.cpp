#include "app/commands/program.h"
#include "gaussians/base/memory.h"

int main(int argc, char** argv) {
  pliant::keep_freed_memory();
  return pliant::run_program(argc, argv);
}
