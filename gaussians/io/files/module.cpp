#include "gaussians/io/files/module.h"

#include <dlfcn.h>
#include <omp.h>

#include <filesystem>

#include "gaussians/base/error.h"

namespace pliant {

void* module_function(const std::string& module, const std::string& function, const std::string& advice) {
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const int threads = omp_get_max_threads();  // torch may change it when it is loaded
  void* loaded = nullptr;
  for (const auto& place : {folder / module, folder / "../lib/pliant" / module})
    if (!loaded && std::filesystem::exists(place)) loaded = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
  const char* problem = loaded ? nullptr : dlerror();
  omp_set_num_threads(threads);
  if (!loaded) throw input_error(module, "", problem ? problem : "not found next to the program", advice);
  void* found = dlsym(loaded, function.c_str());
  CHECK_MSG(found, function);
  return found;
}

}  // namespace pliant
