#pragma once

#include <string>

namespace pliant {

/// A function of a module (.so) that lies beside the program or in ../lib/pliant: what only some runs need of a library
/// that is slow to load.  The module is loaded by the first call and stays; OpenMP keeps its number of threads.  Throws
/// Error{kInput} naming the module, with `advice`, when it cannot be loaded.
void* module_function(const std::string& module, const std::string& function, const std::string& advice);

}  // namespace pliant
