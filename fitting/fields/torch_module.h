#pragma once

#include <string>

namespace pliant {

/// A function of a module that links libtorch and lies beside the program.  The module is loaded by the first call
/// (half a second) and stays; OpenMP keeps its number of threads.  Throws Error{kInput} naming the module, with
/// `advice` on what to do without it, when it cannot be loaded.
void* torch_function(const std::string& module, const std::string& function, const std::string& advice);

}  // namespace pliant
