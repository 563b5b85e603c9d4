#include "app/commands/program.h"

int main(int argc, char** argv) { return pliant::run_program(argc, argv); }
