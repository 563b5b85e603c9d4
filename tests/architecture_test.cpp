// Includes flow one way: gaussians -> {segmentation, physics} -> fitting -> app.  Every #include of the sources is
// compared with the table of permissions below, so that a shortcut across rooms turns the suite red.

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

struct Permission {
  std::set<std::string> rooms;    // folders whose headers may be included, besides the folder itself
  std::set<std::string> outside;  // first path component of third-party headers
};

const std::set<std::string> kEverywhere = {"Eigen", "omp.h"};

const std::map<std::string, Permission> kTable = {
    {"gaussians/base", {{}, {"nanoflann.hpp", "immintrin.h"}}},
    {"gaussians/render", {{"gaussians/base"}, {}}},
    {"gaussians/io", {{"gaussians/base"}, {"nlohmann", "opencv2", "zlib.h", "zstd.h", "webp", "minizip"}}},
    {"gaussians/reconstruct", {{"gaussians/base", "gaussians/render", "gaussians/io"}, {"opencv2"}}},
    {"segmentation/lift",
     {{"gaussians/base", "gaussians/render", "gaussians/io", "gaussians/reconstruct"}, {"nlohmann", "opencv2"}}},
    {"segmentation/model_interfaces", {{"gaussians/base"}, {}}},
    {"segmentation/models",
     {{"gaussians/base", "gaussians/io", "segmentation/model_interfaces"}, {"nlohmann", "opencv2"}}},
    {"segmentation/models/worker", {{"segmentation/models"}, {"torch", "caffe2", "opencv2"}}},
    {"segmentation/labelling",
     {{"gaussians/base", "gaussians/render", "gaussians/io", "segmentation/lift", "segmentation/model_interfaces"},
      {"opencv2"}}},
    {"segmentation/repair",
     {{"gaussians/base", "gaussians/render", "gaussians/io", "segmentation/lift", "segmentation/model_interfaces"},
      {"opencv2"}}},
    {"physics/laws", {{"gaussians/base"}, {}}},
    {"physics/mpm", {{"gaussians/base", "physics/laws"}, {}}},
    {"physics/body", {{"gaussians/base", "gaussians/render", "physics/laws", "physics/mpm"}, {}}},
    {"physics/simulate", {{"gaussians/base", "physics/laws", "physics/mpm", "physics/body"}, {}}},
    {"fitting/fields",
     {{"gaussians/base", "gaussians/render", "physics/laws", "physics/mpm", "physics/body", "physics/simulate"}, {}}},
    {"fitting/fields/torch", {{"gaussians/base", "fitting/fields"}, {"torch", "ATen"}}},
    {"fitting/fit",
     {{"gaussians/base", "gaussians/render", "gaussians/io", "physics/laws", "physics/mpm", "physics/body",
       "physics/simulate", "fitting/fields"},
      {"opencv2", "fmt", "nlohmann"}}},
    {"app/store",
     {{"gaussians/base", "gaussians/io", "gaussians/reconstruct", "segmentation/lift", "physics/laws", "physics/mpm",
       "physics/body", "physics/simulate", "fitting/fields", "fitting/fit"},
      {"hdf5.h", "nlohmann"}}},
    {"app/import",
     {{"gaussians/base", "gaussians/io", "physics/laws", "physics/mpm", "physics/body", "physics/simulate",
       "app/store"},
      {"fmt", "nlohmann"}}},
};

// The rooms of app that see every room below them.
const std::set<std::string> kAppRooms = {"app", "app/commands", "app/pipeline", "app/demo", "app/evaluate"};

std::string room_of(const fs::path& relative_folder) { return relative_folder.generic_string(); }

bool is_standard_header(const std::string& header) {
  return header.find('.') == std::string::npos && header.find('/') == std::string::npos;
}

bool is_system_header(const std::string& header) {
  static const std::set<std::string> allowed = {"unistd.h",       "fcntl.h",      "sys/stat.h", "sys/wait.h",
                                                "sys/resource.h", "sys/socket.h", "signal.h",   "malloc.h",
                                                "dlfcn.h",        "poll.h",       "spawn.h"};
  return allowed.count(header) > 0;
}

}  // namespace

TEST(Architecture, EveryIncludeIsPermitted) {
  const fs::path root = PLIANT_SOURCE_DIR;
  const std::regex include(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  int files = 0;
  for (const char* top : {"gaussians", "segmentation", "physics", "fitting", "app"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      const std::string room = room_of(fs::relative(entry.path().parent_path(), root));
      const bool app_room = kAppRooms.count(room) > 0;
      ASSERT_TRUE(app_room || kTable.count(room)) << room << " has no line in the table of permissions";
      std::ifstream in(entry.path());
      for (std::string line; std::getline(in, line);) {
        std::smatch match;
        if (!std::regex_search(line, match, include)) continue;
        const std::string header = match[2];
        const std::string where = fs::relative(entry.path(), root).string() + ": " + line;
        if (match[1] == "\"") {
          const std::string target = room_of(fs::path(header).parent_path());
          const bool allowed = target == room || app_room || kTable.at(room).rooms.count(target);
          EXPECT_TRUE(allowed) << where << "\n  " << room << " may not include " << target;
          if (app_room) EXPECT_TRUE(kTable.count(target) || kAppRooms.count(target)) << where;
        } else if (!is_standard_header(header) && !is_system_header(header)) {
          const std::string library = header.substr(0, header.find('/'));
          const bool allowed = kEverywhere.count(library) || app_room || kTable.at(room).outside.count(library);
          EXPECT_TRUE(allowed) << where << "\n  " << room << " may not use " << library;
        }
      }
    }
  }
  EXPECT_GT(files, 10);
}

// A function that is compiled both for every processor and for a newer one under the same name is one weak symbol, and
// the linker may keep the version that older processors cannot run.  So all functions of the files that are compiled
// for an instruction set carry its namespace.
TEST(Architecture, CodeForAnInstructionSetHasNoNamesThatOtherFilesShare) {
  for (const char* library : {PLIANT_RENDER_LIBRARY, PLIANT_MPM_LIBRARY}) {
    const std::string command = std::string("nm -A -C --defined-only ") + library + " 2>/dev/null";
    FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string listing;
    char buffer[4096];
    while (const size_t n = fread(buffer, 1, sizeof buffer, pipe)) listing.append(buffer, n);
    if (pclose(pipe) != 0) GTEST_SKIP() << "nm is not installed";
    std::istringstream lines(listing);
    int functions = 0;
    const std::regex symbol(R"(_(baseline|avx2)\.cpp\.o:\S+ ([A-Za-z]) (.*))");
    for (std::string line; std::getline(lines, line);) {
      std::smatch match;
      if (!std::regex_search(line, match, symbol)) continue;
      const std::string kind = match[2], name = match[3];
      if (kind != "W" && kind != "V" && kind != "u" && kind != "T") continue;
      ++functions;
      EXPECT_NE(name.find("pliant::" + match[1].str() + "::"), std::string::npos) << line;
    }
    EXPECT_GT(functions, 10) << library;
  }
}

TEST(Architecture, TopLevelIsTheAgreedOne) {
  const std::set<std::string> agreed = {"CMakeLists.txt", "segmentation", "gaussians", "physics", "fitting", "app",
                                        "tests",          "README.md",    "LICENSE"};
  for (const auto& entry : fs::directory_iterator(PLIANT_SOURCE_DIR)) {
    const std::string name = entry.path().filename();
    if (name[0] == '.' || name.rfind("build", 0) == 0) continue;
    EXPECT_TRUE(agreed.count(name)) << name << " does not belong at the top level";
  }
}
