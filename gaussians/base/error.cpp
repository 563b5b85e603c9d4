#include "gaussians/base/error.h"

namespace pliant {
namespace {

std::string compose(const std::string& where, const std::string& field, const std::string& problem,
                    const std::string& remedy) {
  std::string text = where;
  if (!field.empty()) text += ": " + field;
  text += ": " + problem;
  if (!remedy.empty()) text += " (" + remedy + ")";
  return text;
}

}  // namespace

Error::Error(Failure failure, std::string where, std::string field, std::string problem, std::string remedy)
    : std::runtime_error(compose(where, field, problem, remedy)),
      failure(failure),
      where(std::move(where)),
      field(std::move(field)),
      problem(std::move(problem)),
      remedy(std::move(remedy)) {}

Error input_error(std::string where, std::string field, std::string problem, std::string remedy) {
  return {Failure::kInput, std::move(where), std::move(field), std::move(problem), std::move(remedy)};
}

Error usage_error(std::string where, std::string field, std::string problem, std::string remedy) {
  return {Failure::kUsage, std::move(where), std::move(field), std::move(problem), std::move(remedy)};
}

Error numerical_error(std::string where, std::string problem, std::string remedy) {
  return {Failure::kNumerical, std::move(where), "", std::move(problem), std::move(remedy)};
}

void check_failed(const char* expression, const char* file, int line, const std::string& message) {
  throw std::logic_error(std::string("internal error, please report: ") + expression + " is false at " + file + ":" +
                         std::to_string(line) + (message.empty() ? "" : ": " + message));
}

}  // namespace pliant
