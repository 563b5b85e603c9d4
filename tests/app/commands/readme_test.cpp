// What the READMEs say is true: their command lines are taken by the parser, the options that they name exist, and
// their tables of options are those of the stages.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "app/commands/command.h"
#include "app/demo/kinds/kinds.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "tests/app/commands/all_tables.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

const std::vector<std::string> kReadmes = {
    "README.md",           "app/README.md",     "fitting/README.md",      "fitting/distribution/README.md",
    "gaussians/README.md", "physics/README.md", "segmentation/README.md", ".github/CONTRIBUTING.md"};

std::string readme(const std::string& name) { return read_text(fs::path(PLIANT_SOURCE_DIR) / name); }

/// The words of a line of a shell, without comments.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::string word;
  char quote = 0;
  bool begun = false;
  for (const char c : line + " ") {
    if (quote ? c == quote : c == '"' || c == '\'') {
      quote = quote ? 0 : c;
      begun = true;
    } else if (!quote && c == ' ') {
      if (begun) words.push_back(word);
      begun = false;
      word.clear();
    } else if (!quote && c == '#' && !begun) {
      break;
    } else {
      word += c;
      begun = true;
    }
  }
  return words;
}

/// Lines of shell blocks that call pliant.
std::vector<std::string> command_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  bool shell = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) shell = line == "```sh";
    while (shell && line.ends_with("\\")) {
      std::string more;
      std::getline(in, more);
      line = line.substr(0, line.size() - 1) + more;
    }
    if (shell && line.starts_with("pliant ")) lines.push_back(line);
  }
  return lines;
}

/// What is wrong with a command line, as the parser says it; empty where it is taken.  Files that it names are made.
std::string complaint(const std::vector<std::string>& words) {
  const std::regex missing("(?:File|Path|Directory) does not exist: ([^ \n]+)");
  for (int attempt = 0; attempt < 20; ++attempt) {
    CLI::App app;
    Program program;
    add_commands(app, program);
    try {
      app.parse(std::vector<std::string>(words.rbegin(), words.rend() - 1));
      return "";
    } catch (const CLI::CallForHelp&) {
      return "";
    } catch (const CLI::Error& error) {
      const std::string said = error.what();
      std::smatch match;
      if (!std::regex_search(said, match, missing)) return said;
      write_text(match[1].str(), "");
    } catch (const Error& error) {
      return error.what();
    }
  }
  return "asks for one file after the other";
}

/// Long names of all options of all commands.
void add_names(const CLI::App& app, std::set<std::string>& names) {
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.insert("--" + name);
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) add_names(*command, names);
}

/// The table of a stage's options as the READMEs show it.
std::string markdown_of(const OptionTable& table) {
  const auto escaped = [](std::string text) {
    for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
    return text;
  };
  std::string out = "| option | does | default |\n|---|---|---|\n";
  for (const Option& option : table.options) {
    const bool flag = std::holds_alternative<bool*>(option.field);
    std::string value;
    if (!flag) value = " " + value_text(option);
    out += fmt::format("| `--{}{}` | {} | {} |\n", option.name, escaped(value), escaped(option.help),
                       flag ? "" : escaped(field_text(option.field)));
  }
  return out;
}

/// The kinds of `demo` as the README shows them.
std::string markdown_of(const std::vector<DemoKind>& kinds) {
  std::string out = "| kind | shows |\n|---|---|\n";
  for (const DemoKind& kind : kinds) out += fmt::format("| `{}` | {} |\n", kind.name, kind.shows);
  return out;
}

/// `text` with a table between its marker and the end of that.
std::string with_table(const std::string& text, const std::string& marker, const std::string& table) {
  const std::string begin = "<!-- " + marker + " -->\n";
  const size_t at = text.find(begin);
  if (at == std::string::npos) return text;
  const size_t stop = text.find("<!-- end of ", at);
  if (stop == std::string::npos) throw input_error("README", marker, "has no end", "add <!-- end of options -->");
  std::string out = text;
  return out.replace(at + begin.size(), stop - at - begin.size(), table);
}

}  // namespace

TEST(Readme, CommandLinesAreTakenByTheParser) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  size_t count = 0;
  for (const std::string& name : kReadmes)
    for (const std::string& line : command_lines(readme(name))) {
      EXPECT_EQ(complaint(words_of(line)), "") << name << ": " << line;
      ++count;
    }
  fs::current_path(before);
  EXPECT_GT(count, 30u);
}

// Without -G Ninja, CMake writes Makefiles.
TEST(Readme, BuildsThatNinjaIsToFinishAreConfiguredForIt) {
  int count = 0;
  for (const std::string& name : kReadmes) {
    std::istringstream lines(readme(name));
    for (std::string line; std::getline(lines, line);) {
      if (line.find("cmake -S") == std::string::npos || line.find("ninja ") == std::string::npos) continue;
      ++count;
      EXPECT_NE(line.find(" -G Ninja "), std::string::npos) << name << ": " << line;
    }
  }
  EXPECT_GT(count, 0);
}

// Those of a folder that is left out would be ignored.
TEST(Readme, WhatIsTurnedOnInABuildIsDeclaredForAllFolders) {
  const std::string root = readme("CMakeLists.txt");
  const std::regex on("(PLIANT_[A-Z]+)=ON");
  std::set<std::string> options;
  for (const std::string& name : kReadmes) {
    const std::string text = readme(name);
    for (std::sregex_iterator at(text.begin(), text.end(), on), end; at != end; ++at) options.insert((*at)[1]);
  }
  EXPECT_GE(options.size(), 2u);
  for (const std::string& option : options)
    EXPECT_NE(root.find("\noption(" + option + " "), std::string::npos) << option;
}

// CPack finds the libraries that a package needs with dpkg-shlibdeps of dpkg-dev, and what it looks at with file.
TEST(Readme, WhatAPackageIsMadeWithIsInstalledBefore) {
  const std::string text = readme("README.md");
  const size_t cpack = text.find("cpack --config"), line = text.rfind('\n', cpack);
  ASSERT_NE(cpack, std::string::npos);
  EXPECT_NE(text.substr(line, cpack - line).find("app/setup --install file dpkg-dev"), std::string::npos);
}

TEST(Readme, TheFirstTableOfARoomNamesItsFolders) {
  for (const std::string room : {"app", "fitting", "gaussians", "physics", "segmentation"}) {
    const std::string text = readme(room + "/README.md");
    const size_t begin = text.find("| folder |");
    ASSERT_NE(begin, std::string::npos) << room;
    const std::string table = text.substr(begin, text.find("\n\n", begin) - begin);
    for (const auto& entry : fs::directory_iterator(fs::path(PLIANT_SOURCE_DIR) / room)) {
      const std::string folder = entry.path().filename();
      if (!fs::exists(entry.path() / "CMakeLists.txt")) continue;
      EXPECT_NE(table.find("`" + folder + "`"), std::string::npos) << room << "/" << folder;
    }
  }
}

TEST(Readme, OptionsThatAreNamedExist) {
  CLI::App app;
  Program program;
  add_commands(app, program);
  std::set<std::string> known = {"--check", "--help-all", "--version", "--recursive"};
  add_names(app, known);
  const std::regex option("(^|[ `(])(--[a-z][a-z0-9]*([-.][a-z0-9]+)*)");
  const std::set<std::string> of_others = {"--workspace_path",
                                           "--image_path",
                                           "--dense",
                                           "--use_gpu",
                                           "--build",
                                           "--install",
                                           "--prefix",
                                           "--orientation-method",
                                           "--center-method",
                                           "--auto-scale-poses",
                                           "--no-normalize-world-space",
                                           "--antialiasing",
                                           "--gtest_filter"};
  for (const std::string& name : kReadmes) {
    const std::string text = readme(name);
    for (std::sregex_iterator at(text.begin(), text.end(), option), end; at != end; ++at) {
      const std::string found = (*at)[2];
      bool other = false;
      for (const std::string& word : of_others) other = other || word.starts_with(found);
      EXPECT_TRUE(known.count(found) || other) << name << ": " << found;
    }
  }
}

// With PLIANT_WRITE_READMES=1 in the environment the tables are written instead of compared.
TEST(Readme, TablesOfOptionsAreThoseOfTheStages) {
  const bool write = std::getenv("PLIANT_WRITE_READMES") != nullptr;
  std::set<std::string> shown;
  for (const std::string& name : kReadmes) {
    std::string text = readme(name), wanted = text;
    for (const OptionTable& table : all_tables()) {
      const std::string marker = "options: " + table.stage;
      if (wanted.find("<!-- " + marker + " -->\n") == std::string::npos) continue;
      shown.insert(table.stage);
      wanted = with_table(wanted, marker, markdown_of(table));
    }
    wanted = with_table(wanted, "kinds of demo", markdown_of(demo_kinds()));
    if (write && wanted != text) write_text(fs::path(PLIANT_SOURCE_DIR) / name, text = wanted);
    EXPECT_TRUE(text == wanted) << name << " shows other options; PLIANT_WRITE_READMES=1 writes them";
  }
  EXPECT_NE(readme("app/README.md").find("| `potted-flower` |"), std::string::npos);
  for (const OptionTable& table : all_tables())
    EXPECT_TRUE(shown.count(table.stage)) << "no README shows the options of " << table.stage;
}

}  // namespace pliant
