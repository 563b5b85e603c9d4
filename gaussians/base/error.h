#pragma once

#include <stdexcept>
#include <string>

namespace pliant {

/// Why a command stopped; the value is the exit code of the program.
enum class Failure { kInput = 1, kUsage = 2, kNumerical = 3, kInterrupted = 130 };

/// A failure that the user can cause and repair.  `where` names the file or option, `field` the key, column or
/// property inside it (may be empty), `problem` what is wrong including the value found, `remedy` what to do.
class Error : public std::runtime_error {
 public:
  Error(Failure failure, std::string where, std::string field, std::string problem, std::string remedy);

  Failure failure;
  std::string where, field, problem, remedy;
};

/// A file or data set that cannot be used (exit code 1).
Error input_error(std::string where, std::string field, std::string problem, std::string remedy);
/// An option, key or parameter with an impossible value (exit code 2).
Error usage_error(std::string where, std::string field, std::string problem, std::string remedy);
/// A computation that diverged (exit code 3).
Error numerical_error(std::string where, std::string problem, std::string remedy);

[[noreturn]] void check_failed(const char* expression, const char* file, int line, const std::string& message);

}  // namespace pliant

/// Broken invariants of the program itself, always on.
#define CHECK(condition) ((condition) ? void(0) : ::pliant::check_failed(#condition, __FILE__, __LINE__, ""))
#define CHECK_MSG(condition, message) \
  ((condition) ? void(0) : ::pliant::check_failed(#condition, __FILE__, __LINE__, (message)))
