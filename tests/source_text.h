#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// What the tests of the sources read: tokens of C++ without comments and preprocessor lines.
namespace source_text {

/// The repository.
inline const std::filesystem::path kRoot = PLIANT_SOURCE_DIR;

/// Paths from `root` of every .h and .cpp below these folders of it.
std::vector<std::string> sources_below(const std::filesystem::path& root, const std::vector<std::string>& folders);
std::string text_of(const std::filesystem::path& file);

struct Token {
  enum class Kind { kWord, kNumber, kLiteral, kSign } kind;
  std::string text;  ///< literals are empty
  int line;          ///< from 1
};
std::vector<Token> tokens_of(std::string_view text);

/// Qualified names of the types that a file defines in named namespaces, for example "pliant::Camera".  Types inside
/// types, functions and unnamed namespaces are left out: each belongs to one file.
std::vector<std::string> types_defined(const std::vector<Token>& tokens);

/// Lines of statements that a comma joins: `a = 1, b = 2;`.  Declarations, headers of loops, arguments and Eigen's
/// `m << 1, 2;` are none.
std::vector<int> comma_joined_statements(const std::vector<Token>& tokens);

}  // namespace source_text
