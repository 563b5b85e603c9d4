#include "gaussians/io/files/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/edit_distance.h"
#include "gaussians/io/files/sha256.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

Error cannot_write(const fs::path& file, const std::string& why) {
  return input_error(file.string(), "", "cannot be written: " + why, "check the folder, permissions and free space");
}

/// Flushes a file or folder to disk; file systems that cannot flush folders are left alone.
void flush_to_disk(const fs::path& path, bool folder) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  if (descriptor < 0) {
    if (folder) return;
    throw cannot_write(path, std::strerror(errno));
  }
  const int failed = ::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS ? errno : 0;
  ::close(descriptor);
  if (failed && !folder) throw cannot_write(path, std::strerror(failed));
}

std::ifstream open_for_reading(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw input_error(file.string(), "", "does not exist", "check the name");
  if (fs::is_directory(file, ignored)) throw input_error(file.string(), "", "is a folder, not a file", "give a file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw input_error(file.string(), "", "cannot be opened", "check its permissions");
  return in;
}

}  // namespace

fs::path temporary_name(const fs::path& file) {
  std::string hidden = ".";
  hidden.append(file.stem().string())
      .append(".tmp")
      .append(std::to_string(::getpid()))
      .append(file.extension().string());
  return file.parent_path() / hidden;
}

void write_atomically(const fs::path& file, const std::function<void(const fs::path& temporary)>& write) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw cannot_write(file, failed.message());
  if (fs::is_directory(file, failed)) throw cannot_write(file, "there is a folder of that name");
  const fs::path temporary = temporary_name(file);
  try {
    write(temporary);
    if (!fs::exists(temporary)) throw cannot_write(file, "nothing was written");
    flush_to_disk(temporary, false);
    fs::rename(temporary, file, failed);
    if (failed) throw cannot_write(file, failed.message());
  } catch (...) {
    fs::remove(temporary, failed);
    throw;
  }
  flush_to_disk(folder, true);
}

std::string read_text(const fs::path& file) {
  std::ifstream in = open_for_reading(file);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw input_error(file.string(), "", "cannot be read to its end", "check the disk");
  return text;
}

void write_text(const fs::path& file, const std::string& text) {
  write_atomically(file, [&](const fs::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.close();
    if (!out) throw cannot_write(file, std::strerror(errno));
  });
}

std::string sha256_of_text(const std::string& text) {
  Sha256 hash;
  hash.add(text.data(), text.size());
  return hash.hex();
}

std::string sha256_of_file(const fs::path& file) {
  std::ifstream in = open_for_reading(file);
  Sha256 hash;
  std::vector<char> buffer(1 << 16);
  while (in) {
    in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    hash.add(buffer.data(), static_cast<size_t>(in.gcount()));
  }
  if (in.bad()) throw input_error(file.string(), "", "cannot be read to its end", "check the disk");
  return hash.hex();
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
  std::string best;
  size_t best_distance = SIZE_MAX;
  for (const std::string& candidate : candidates)
    if (const size_t distance = edit_distance(name, candidate); distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  return best;
}

}  // namespace pliant
