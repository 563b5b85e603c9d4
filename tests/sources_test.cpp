// What the sources themselves have to keep: one format, one statement a line, one definition of every type.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/source_text.h"

namespace fs = std::filesystem;
using source_text::comma_joined_statements;
using source_text::kRoot;
using source_text::sources_below;
using source_text::text_of;
using source_text::tokens_of;
using source_text::types_defined;

TEST(Sources, AreFormattedByTheirClangFormat) {
  if (std::system("clang-format-14 --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "clang-format-14 is not installed";
  const std::string command = "cd '" + kRoot.string() +
                              "' && find gaussians segmentation physics fitting app tests -name '*.h' -print0 -o "
                              "-name '*.cpp' -print0 | xargs -0 clang-format-14 --dry-run --Werror > /dev/null 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << "tests/format formats them";
}

TEST(Sources, HoldOneStatementALine) {
  const std::vector<std::string> files =
      sources_below(kRoot, {"gaussians", "segmentation", "physics", "fitting", "app", "tests"});
  EXPECT_GT(files.size(), 300u);
  for (const std::string& file : files)
    for (int line : comma_joined_statements(tokens_of(text_of(kRoot / file))))
      ADD_FAILURE() << file << ":" << line << " joins statements by a comma";
}

// Two types of one name in one program are one type to the linker (the one definition rule): their constructors and
// destructors are weak symbols, of which it keeps either.
TEST(Sources, DefineEveryTypeOfANamedNamespaceOnce) {
  std::map<std::string, std::set<std::string>> files;
  for (const std::string& file : sources_below(kRoot, {"gaussians", "segmentation", "physics", "fitting", "app"}))
    for (const std::string& type : types_defined(tokens_of(text_of(kRoot / file)))) {
      const bool first = files[type].insert(file).second;
      EXPECT_TRUE(first) << type << " is defined twice in " << file;
    }
  EXPECT_GT(files.size(), 300u);
  for (const auto& [type, where] : files) {
    EXPECT_EQ(where.size(), 1u) << type << " is defined in " << *where.begin() << " and in " << *where.rbegin();
  }
}

// tests/studies/sign_flip replaces each text of its table, 'name|file|text|flipped text', in its file.
TEST(Sources, HoldEveryTextOfTheSignFlipsOnce) {
  const std::string script = text_of(kRoot / "tests/studies/sign_flip");
  const size_t begin = script.find("flips=(\n"), end = script.find("\n)\n", begin);
  ASSERT_NE(end, std::string::npos);
  const std::string table = script.substr(begin, end - begin);
  const std::regex row(R"(\n  '([^'|]*)\|([^'|]*)\|([^'|]*)\|([^'|]*)')");
  int flips = 0;
  for (std::sregex_iterator it(table.begin(), table.end(), row), last; it != last; ++it, ++flips) {
    const std::string name = (*it)[1], file = (*it)[2], text = (*it)[3], flipped = (*it)[4];
    ASSERT_TRUE(fs::is_regular_file(kRoot / file)) << name << ": " << file;
    const std::string source = text_of(kRoot / file);
    const size_t first = source.find(text);
    EXPECT_NE(first, std::string::npos) << name << ": " << text << " is not in " << file;
    EXPECT_EQ(source.rfind(text), first) << name << ": " << text << " is more than once in " << file;
    EXPECT_NE(text, flipped) << name << " flips nothing";
  }
  EXPECT_EQ(flips, std::count(table.begin(), table.end(), '\n')) << "a row of the table has another form";
  EXPECT_GT(flips, 10);
}

TEST(SourceText, FindsStatementsJoinedByCommas) {
  const auto lines = [](const char* text) { return comma_joined_statements(tokens_of(text)); };
  EXPECT_EQ(lines("void f() {\n  a = 1, b = 2;\n}"), std::vector<int>{2});
  EXPECT_EQ(lines("void f() {\n  if (x) g(1), h[i].k += 2;\n}"), std::vector<int>{2});
  EXPECT_EQ(lines("auto f = [&] { ++i, ++j; };"), std::vector<int>{1});
  EXPECT_EQ(lines("void f() { for (int i = 0, j = 1; i < j; ++i, --j) g(i, j); }"), std::vector<int>{});
  EXPECT_EQ(lines("void f() { std::map<int, int> a = {{1, 2}}, b; m << 1, 2; run<T, 3>(x); }"), std::vector<int>{});
  EXPECT_EQ(lines("const char* t = \"a = 1, b = 2;\";  // a = 1, b = 2;\n"), std::vector<int>{});
}

TEST(SourceText, FindsTypesOfNamedNamespaces) {
  const std::string text =
      "namespace a { namespace { struct Own {}; } template <class T> struct B { struct C {}; }; enum class D { kE }; "
      "template <> struct B<int> {}; struct Forward; struct Outer::Inner { int x; }; void f() { struct Local {}; } }";
  EXPECT_EQ(types_defined(tokens_of(text)), (std::vector<std::string>{"a::B", "a::D"}));
}
