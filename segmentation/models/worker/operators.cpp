#include "segmentation/models/worker/operators.h"

#include <regex>

namespace pliant {

std::set<std::string> operators_in(const std::string& code) {
  std::set<std::string> names;
  const std::regex call(R"((^|[^\w.])(torch|ops\.(\w+))\.(\w+)(?=\())");
  for (std::sregex_iterator match(code.begin(), code.end(), call), end; match != end; ++match)
    names.insert(((*match)[3].matched ? (*match)[3].str() : "aten") + "::" + (*match)[4].str());
  return names;
}

std::string operator_of_message(const std::string& text) {
  std::smatch match;
  for (const char* words : {R"(Unknown builtin op: (\w+::\w+))", R"(Couldn't find operator:? '?(\w+::\w+))",
                            R"(variants are available:\s+(\w+::\w+)\()"})
    if (std::regex_search(text, match, std::regex(words))) return match[1];
  return "";
}

std::string operators_text(const std::set<std::string>& names) {
  std::string text = names.size() > 1 ? "the operators " : "the operator ";
  for (const std::string& name : names) text += (name == *names.begin() ? "" : ", ") + name;
  return text;
}

}  // namespace pliant
