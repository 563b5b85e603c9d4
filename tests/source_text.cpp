#include "tests/source_text.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <sstream>

namespace source_text {
namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

/// Ends of a literal that begins at i, or i where none begins.
size_t end_of_literal(std::string_view s, size_t i) {
  size_t quote = i;
  while (quote < s.size() && quote < i + 3 && std::isalnum(static_cast<unsigned char>(s[quote]))) ++quote;
  if (quote >= s.size()) return i;
  const std::string_view prefix = s.substr(i, quote - i);
  static const std::set<std::string_view> prefixes = {"", "R", "L", "u", "U", "u8", "u8R", "LR", "uR", "UR"};
  if (!prefixes.count(prefix)) return i;
  if (s[quote] == '"' && !prefix.empty() && prefix.back() == 'R') {
    const size_t open = s.find('(', quote);
    const std::string close = ")" + std::string(s.substr(quote + 1, open - quote - 1)) + "\"";
    return s.find(close, open) + close.size();
  }
  if (s[quote] != '"' && s[quote] != '\'') return i;
  size_t end = quote + 1;
  while (end < s.size() && s[end] != s[quote]) end += s[end] == '\\' ? 2 : 1;
  return end + 1;
}

}  // namespace

std::vector<std::string> sources_below(const std::filesystem::path& root, const std::vector<std::string>& folders) {
  std::vector<std::string> out;
  for (const std::string& folder : folders)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
        out.push_back(std::filesystem::relative(entry.path(), root).generic_string());
  return out;
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}

std::vector<Token> tokens_of(std::string_view s) {
  static const std::string_view signs[] = {"<<=", ">>=", "->*", "<=>", "...", "->", "::", "<<", "&&", "||", "==", "!=",
                                           "<=",  ">=",  "++",  "--",  "+=",  "-=", "*=", "/=", "%=", "&=", "|=", "^="};
  std::vector<Token> out;
  int line = 1;
  bool line_begins = true;
  size_t i = 0;
  const auto skip_to = [&](size_t end) {
    end = std::min(end, s.size());
    line += static_cast<int>(std::count(s.begin() + i, s.begin() + end, '\n'));
    i = end;
  };
  while (i < s.size()) {
    const char c = s[i];
    if (std::isspace(static_cast<unsigned char>(c))) {
      if (c == '\n') line_begins = true;
      skip_to(i + 1);
      continue;
    }
    if (s.substr(i, 2) == "//") {
      skip_to(std::min(s.find('\n', i), s.size()));
      continue;
    }
    if (s.substr(i, 2) == "/*") {
      skip_to(s.find("*/", i) + 2);
      continue;
    }
    if (c == '#' && line_begins) {
      size_t end = s.find('\n', i);
      while (end != s.npos && s[end - 1] == '\\') end = s.find('\n', end + 1);
      skip_to(end);
      continue;
    }
    line_begins = false;
    const int at = line;
    if (const size_t end = end_of_literal(s, i); end > i) {
      skip_to(end);
      out.push_back({Token::Kind::kLiteral, "", at});
      continue;
    }
    size_t end = i + 1;
    Token::Kind kind = Token::Kind::kSign;
    if (std::isdigit(static_cast<unsigned char>(c)) ||
        (c == '.' && i + 1 < s.size() && std::isdigit(static_cast<unsigned char>(s[i + 1])))) {
      kind = Token::Kind::kNumber;
      while (end < s.size() && (is_word(s[end]) || s[end] == '.' || s[end] == '\'' ||
                                ((s[end] == '+' || s[end] == '-') && std::tolower(s[end - 1]) == 'e')))
        ++end;
    } else if (is_word(c)) {
      kind = Token::Kind::kWord;
      while (end < s.size() && is_word(s[end])) ++end;
    } else {
      for (std::string_view sign : signs)
        if (s.substr(i, sign.size()) == sign) {
          end = i + sign.size();
          break;
        }
    }
    out.push_back({kind, std::string(s.substr(i, end - i)), at});
    skip_to(end);
  }
  return out;
}

namespace {

using Tokens = std::vector<Token>;

/// Partner of every bracket of (), [], {}.
std::vector<size_t> partners(const Tokens& t) {
  std::vector<size_t> partner(t.size(), 0), open;
  for (size_t i = 0; i < t.size(); ++i) {
    if (t[i].kind != Token::Kind::kSign) continue;
    if (t[i].text == "(" || t[i].text == "[" || t[i].text == "{") {
      open.push_back(i);
    } else if (!open.empty() && (t[i].text == ")" || t[i].text == "]" || t[i].text == "}")) {
      partner[i] = open.back();
      partner[open.back()] = i;
      open.pop_back();
    }
  }
  return partner;
}

/// End of the template arguments that begin at `i`, the place of a "<"; i where it is a comparison.
size_t end_of_arguments(const Tokens& t, const std::vector<size_t>& partner, size_t i, size_t end) {
  int depth = 0;
  for (size_t j = i; j < end; ++j) {
    const std::string& x = t[j].text;
    if (x == "(" || x == "[" || x == "{") {
      j = partner[j];
      continue;
    }
    if (x == "&&" || x == "||" || x == "?" || x == ";" || x == "=") return i;
    if (x == "<") ++depth;
    if (x == ">" && --depth == 0) return j + 1;
  }
  return i;
}

/// Whether the statement [begin, end) declares something: a type and then a name.
bool declares(const Tokens& t, const std::vector<size_t>& partner, size_t begin, size_t end) {
  static const std::set<std::string> first = {"alignas", "auto",     "const",  "constexpr", "static",      "using",
                                              "typedef", "template", "struct", "class",     "enum",        "return",
                                              "throw",   "friend",   "extern", "unsigned",  "thread_local"};
  if (first.count(t[begin].text)) return true;
  size_t i = begin;
  if (t[i].text == "::") ++i;
  if (t[i].kind != Token::Kind::kWord) return false;
  ++i;
  while (i < end) {
    if (t[i].text == "::") {
      i += 2;
    } else if (t[i].text == "<" && end_of_arguments(t, partner, i, end) > i) {
      i = end_of_arguments(t, partner, i, end);
    } else {
      break;
    }
  }
  while (i < end && (t[i].text == "&" || t[i].text == "*" || t[i].text == "const")) ++i;
  return i < end && t[i].kind == Token::Kind::kWord;
}

/// First token after labels and the heads of if, else, for and while.
size_t after_heads(const Tokens& t, const std::vector<size_t>& partner, size_t i, size_t end) {
  while (i < end) {
    const std::string& x = t[i].text;
    if (x == "if" || x == "for" || x == "while" || x == "switch") {
      while (i < end && t[i].text != "(") ++i;
      if (i < end) i = partner[i] + 1;
    } else if (x == "else" || x == "do") {
      ++i;
    } else if (x == "case" || x == "default" || x == "public" || x == "private" || x == "protected") {
      while (i < end && t[i].text != ":") ++i;
      ++i;
    } else {
      break;
    }
  }
  return i;
}

}  // namespace

std::vector<std::string> types_defined(const Tokens& t) {
  struct Scope {
    std::string name;  ///< of a named namespace
    bool counts;       ///< types here are visible to other files
  };
  std::vector<Scope> scopes = {{"", true}};
  std::vector<std::string> out;
  for (size_t i = 0; i < t.size(); ++i) {
    if (t[i].text == "}" && scopes.size() > 1) scopes.pop_back();
    if (t[i].text != "{") continue;
    // What stands before the brace, from the last end of a statement on, says what it opens.
    size_t begin = i;
    while (begin > 0 && t[begin - 1].text != ";" && t[begin - 1].text != "{" && t[begin - 1].text != "}") --begin;
    std::string space, type;
    bool named_space = false, is_space = false, has_call = false, specialised = false;
    for (size_t j = begin; j < i; ++j) {
      if (t[j].text == "namespace") is_space = true;
      if (is_space && t[j].kind == Token::Kind::kWord && t[j].text != "namespace" && t[j].text != "inline") {
        space += "::" + t[j].text;
        named_space = true;
      }
      if (t[j].text == "(" || t[j].text == "=") has_call = true;
      const bool keyword = t[j].text == "struct" || t[j].text == "class" || t[j].text == "union" || t[j].text == "enum";
      const bool in_template = j > 0 && (t[j - 1].text == "<" || t[j - 1].text == ",");
      if (keyword && !in_template && type.empty()) {
        size_t name = j + 1;
        if (name < i && (t[name].text == "class" || t[name].text == "struct")) ++name;
        if (name < i && t[name].text == "alignas") name += 4;
        if (name < i && t[name].kind == Token::Kind::kWord) type = t[name].text;
        if (name + 1 < i && (t[name + 1].text == "<" || t[name + 1].text == "::")) specialised = true;  // or nested
      }
    }
    const bool visible = scopes.back().counts;
    if (is_space) {
      scopes.push_back({scopes.back().name + space, visible && named_space});
      continue;
    }
    if (visible && !type.empty() && !has_call && !specialised && !scopes.back().name.empty())
      out.push_back(scopes.back().name.substr(2) + "::" + type);
    scopes.push_back({"", false});
  }
  return out;
}

std::vector<int> comma_joined_statements(const Tokens& t) {
  const std::vector<size_t> partner = partners(t);
  std::vector<int> out;
  for (size_t end = 0; end < t.size(); ++end) {
    if (t[end].text != ";") continue;
    // Back to where the statement begins; brackets that close before it are passed over, an open one encloses it.
    size_t begin = end;
    bool in_head = false;
    while (begin > 0) {
      const std::string& x = t[begin - 1].text;
      if (x == ";" || x == "{") break;
      if (x == "(" || x == "[") {
        in_head = true;
        break;
      }
      if (x == "}") {
        // A block ends a statement; the braces of an initialiser or of a lambda are inside one.
        const std::string& next = begin < t.size() ? t[begin].text : t[end].text;
        if (next != "," && next != ";" && next != ")" && next != "." && next != "(" && next != "[") break;
        begin = partner[begin - 1];
        continue;
      }
      begin = x == ")" || x == "]" ? partner[begin - 1] : begin - 1;
    }
    if (in_head) continue;
    begin = after_heads(t, partner, begin, end);
    if (begin >= end || declares(t, partner, begin, end)) continue;
    bool comma = false, stream = false;
    for (size_t i = begin; i < end; ++i) {
      const std::string& x = t[i].text;
      if (x == "(" || x == "[" || x == "{") {
        i = partner[i];
      } else if (x == "<" && end_of_arguments(t, partner, i, end) > i) {
        i = end_of_arguments(t, partner, i, end) - 1;
      } else if (x == "<<") {
        stream = true;
      } else if (x == "," && !stream) {
        comma = true;
      }
    }
    if (comma) out.push_back(t[begin].line);
  }
  return out;
}

}  // namespace source_text
