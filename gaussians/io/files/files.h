#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pliant {

/// Where a file is written before it is whole: .NAME.tmp<process>.EXTENSION beside it.
std::filesystem::path temporary_name(const std::filesystem::path& file);

/// Calls write(temporary) and renames the result to `file`; on failure nothing is left behind.  The temporary keeps
/// the extension of `file`.  The data are flushed to disk before the rename.
void write_atomically(const std::filesystem::path& file,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// Whole contents of a file.  Throws Error{kInput} when it cannot be read.
std::string read_text(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);  ///< atomic

/// SHA-256 of a file, in hex (FIPS 180-4).
std::string sha256_of_file(const std::filesystem::path& file);
std::string sha256_of_text(const std::string& text);

/// The candidate nearest in edit distance, for messages about unknown keys.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace pliant
