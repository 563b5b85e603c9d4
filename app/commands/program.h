#pragma once

namespace pliant {

/// Parses the command line, runs the command and returns the exit code: 0 done, 1 failed, 2 usage, 3 numerical
/// failure, 130 interrupted.  Errors go to standard error.
int run_program(int argc, const char* const* argv);

}  // namespace pliant
