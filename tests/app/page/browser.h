#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "gaussians/io/files/files.h"

namespace pliant {

/// The Chromium of this machine; empty = it has none.
inline std::string browser_program() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (std::system((std::string("command -v ") + name + " > /dev/null 2>&1").c_str()) == 0) return name;
  return "";
}

/// Why no page can be opened in a test; empty = it can.
inline std::string browser_missing() {
  if (browser_program().empty()) return "Chromium is not installed";
  if (std::system("node --version > /dev/null 2>&1") != 0) return "node is not installed";
  return "";
}

/// What the expression gives in a page, a file or an address: {value} or {error}.  Files for it go to `folder`.
inline nlohmann::json evaluate_in_page(const std::string& expression, const std::string& page,
                                       const std::filesystem::path& folder) {
  write_text(folder / "expression.js", expression);
  const std::string command = "node " + std::string(PLIANT_BROWSE_CLIP) + " $(command -v " + browser_program() + ") " +
                              page + " " + (folder / "expression.js").string() + " " +
                              (folder / "answer.json").string();
  std::filesystem::remove(folder / "answer.json");
  EXPECT_EQ(std::system(command.c_str()), 0);
  return nlohmann::json::parse(read_text(folder / "answer.json"));
}

}  // namespace pliant
