#include "gaussians/io/files/paths.h"

namespace fs = std::filesystem;

namespace pliant {

fs::path tidy_path(const fs::path& path) {
  const fs::path normal = path.lexically_normal();
  std::error_code ignored;
  return normal == path || fs::equivalent(normal, path, ignored) ? normal : path;
}

fs::path path_as_seen_from(const fs::path& folder, const fs::path& path) {
  // By their names, so that links inside the folder stay; where a link is on the way up, from where both really are.
  const fs::path normal = fs::absolute(path).lexically_normal(),
                 relative = normal.lexically_proximate(fs::absolute(folder).lexically_normal());
  std::error_code ignored;
  if (fs::equivalent(folder / relative, path, ignored)) return relative;
  const fs::path whole = fs::absolute(path),
                 real = fs::relative(whole.parent_path(), fs::absolute(folder), ignored) / whole.filename();
  return real.has_parent_path() ? real.lexically_normal() : whole;
}

}  // namespace pliant
