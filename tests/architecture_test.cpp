// Includes flow one way: gaussians -> segmentation and physics; physics -> fitting; all -> app.  A link line of CMake
// is a permission: every #include of the sources is compared with the link lines and with the tables below, so that a
// shortcut across rooms turns the suite red.  And what makes a file easy to find: small folders, one name once, a
// header for every source.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/source_text.h"

namespace fs = std::filesystem;

namespace {

using source_text::kRoot;
constexpr int kMaxFiles = 40;  // in a folder

// The rooms that a room may include, besides itself.
const std::map<std::string, std::set<std::string>> kRooms = {
    {"gaussians", {}},
    {"segmentation", {"gaussians"}},
    {"physics", {"gaussians"}},
    {"fitting", {"gaussians", "physics"}},
    {"app", {"gaussians", "segmentation", "physics", "fitting"}},
};

// Libraries, by the first part of their headers' paths, that a folder may use besides Eigen and OpenMP.
const std::map<std::string, std::set<std::string>> kLibraries = {
    {"app/live", {"boost"}},
    {"app/statistics", {"boost"}},
    {"gaussians/base", {"nanoflann.hpp"}},
    {"gaussians/simd", {"immintrin.h"}},
    {"gaussians/io/files", {"nlohmann", "zlib.h", "zstd.h", "minizip"}},
    {"gaussians/io/images", {"opencv2", "zlib.h", "webp"}},
    {"gaussians/io/images/codecs", {"opencv2"}},
    {"gaussians/io/splats", {"nlohmann"}},
    {"gaussians/io/cameras", {"nlohmann"}},
    {"gaussians/io/scene", {"nlohmann"}},
    {"gaussians/vision", {"opencv2"}},
    {"gaussians/reconstruct", {"opencv2"}},
    {"segmentation/labels", {"nlohmann"}},
    {"segmentation/graph", {"opencv2"}},
    {"segmentation/sheets", {"opencv2"}},
    {"segmentation/models", {"nlohmann", "opencv2"}},
    {"segmentation/models/worker", {"torch", "caffe2", "opencv2"}},
    {"segmentation/labelling", {"opencv2"}},
    {"segmentation/repair", {"opencv2"}},
    {"fitting/fields/torch", {"torch", "ATen"}},
    {"fitting/observe", {"opencv2", "fmt", "nlohmann"}},
    {"fitting/fit", {"fmt"}},
    {"fitting/distribution", {"nlohmann"}},
    {"fitting/distribution/torch", {"torch", "ATen"}},
    {"fitting/predict", {"fmt", "nlohmann", "curl"}},
    {"app/store", {"hdf5.h", "nlohmann"}},
};
const std::set<std::string> kAppLibraries = {"fmt", "nlohmann", "opencv2"};

bool is_standard_header(const std::string& header) {
  return header.find('.') == std::string::npos && header.find('/') == std::string::npos;
}

bool is_system_header(const std::string& header) {
  static const std::set<std::string> allowed = {"unistd.h",       "fcntl.h",      "sys/stat.h", "sys/wait.h",
                                                "sys/resource.h", "sys/socket.h", "signal.h",   "malloc.h",
                                                "dlfcn.h",        "poll.h",       "spawn.h"};
  return allowed.count(header) > 0;
}

std::string top_of(const std::string& path) { return path.substr(0, path.find('/')); }
std::string folder_of(const std::string& path) { return fs::path(path).parent_path().generic_string(); }

struct Source {
  std::string path, folder;                  ///< from the root
  std::vector<std::string> quoted, angular;  ///< headers that it includes
};

/// Every .h and .cpp of the rooms and of the tests.
const std::vector<Source>& sources() {
  static const std::vector<Source> all = [] {
    const std::regex include(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
    std::vector<Source> out;
    for (const std::string& path :
         source_text::sources_below(kRoot, {"gaussians", "segmentation", "physics", "fitting", "app", "tests"})) {
      Source source{path, folder_of(path), {}, {}};
      std::istringstream in(source_text::text_of(kRoot / path));
      for (std::string line; std::getline(in, line);) {
        std::smatch match;
        if (std::regex_search(line, match, include))
          (match[1] == "\"" ? source.quoted : source.angular).push_back(match[2]);
      }
      out.push_back(std::move(source));
    }
    return out;
  }();
  return all;
}

/// Folders that a folder links with, directly or through others.  The folder of a library is where its pliant_room()
/// stands; a folder without one belongs to the library above it and sees what that sees.
std::map<std::string, std::set<std::string>> permissions() {
  std::map<std::string, std::string> folder;           // of a library
  std::map<std::string, std::set<std::string>> links;  // of a folder: libraries
  const std::regex room(R"(pliant_room\((\w+)([^)]*)\))"), library(R"(pliant_\w+)");
  for (const auto& [top, below] : kRooms) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / top)) {
      if (entry.path().filename() != "CMakeLists.txt") continue;
      const std::string content = source_text::text_of(entry.path());
      std::smatch match;
      if (!std::regex_search(content, match, room)) continue;
      const std::string here = fs::relative(entry.path().parent_path(), kRoot).generic_string();
      folder[match[1]] = here;
      const std::string rest = match[2];
      for (std::sregex_iterator it(rest.begin(), rest.end(), library), end; it != end; ++it)
        links[here].insert(it->str());
    }
  }
  std::map<std::string, std::set<std::string>> out;
  const std::function<void(const std::string&, std::set<std::string>&)> add = [&](const std::string& from,
                                                                                  std::set<std::string>& seen) {
    for (const std::string& name : links[from])
      if (folder.count(name) && seen.insert(folder[name]).second) add(folder[name], seen);
  };
  for (const auto& [name, here] : folder) add(here, out[here]);
  return out;
}

/// The folder whose library a folder belongs to.
std::string library_folder(const std::map<std::string, std::set<std::string>>& permitted, std::string folder) {
  while (!permitted.count(folder) && folder.find('/') != std::string::npos) folder = folder_of(folder);
  return folder;
}

}  // namespace

TEST(Architecture, EveryIncludeIsPermitted) {
  const auto permitted = permissions();
  ASSERT_GT(permitted.size(), 40u);
  for (const Source& source : sources()) {
    if (top_of(source.path) == "tests") continue;
    const std::string here = library_folder(permitted, source.folder);
    for (const std::string& header : source.quoted) {
      const std::string target = folder_of(header);
      const std::string there = library_folder(permitted, target);
      if (target == source.folder || there == here) continue;
      const bool linked = source.folder == "app" || (permitted.count(here) && permitted.at(here).count(there));
      EXPECT_TRUE(linked) << source.path << " includes " << header << ", but " << here << " does not link " << there;
      const bool room = top_of(here) == top_of(there) || kRooms.at(top_of(here)).count(top_of(there));
      EXPECT_TRUE(room) << source.path << ": " << top_of(here) << " may not include " << top_of(there);
    }
    for (const std::string& header : source.angular) {
      if (is_standard_header(header) || is_system_header(header)) continue;
      const std::string library = top_of(header);
      const auto own = kLibraries.find(source.folder);
      const bool allowed = library == "Eigen" || library == "omp.h" ||
                           (own != kLibraries.end() && own->second.count(library)) ||
                           (top_of(source.path) == "app" && kAppLibraries.count(library)) ||
                           (source.folder == "app/commands" && library == "CLI");
      EXPECT_TRUE(allowed) << source.path << ": " << source.folder << " may not use " << library;
    }
  }
}

TEST(Architecture, FoldersIncludeEachOtherInNoCircle) {
  std::map<std::string, std::set<std::string>> includes;
  for (const Source& source : sources()) {
    if (top_of(source.path) == "tests") continue;
    for (const std::string& header : source.quoted)
      if (folder_of(header) != source.folder) includes[source.folder].insert(folder_of(header));
  }
  std::map<std::string, int> state;  // 1 = on the way from the start, 2 = done
  std::vector<std::string> way;
  const std::function<void(const std::string&)> visit = [&](const std::string& folder) {
    state[folder] = 1;
    way.push_back(folder);
    for (const std::string& next : includes[folder]) {
      if (state[next] == 0) visit(next);
      if (state[next] != 1) continue;
      std::string circle = next;
      for (auto it = std::find(way.begin(), way.end(), next) + 1; it != way.end(); ++it) circle += " -> " + *it;
      ADD_FAILURE() << circle << " -> " << next;
    }
    way.pop_back();
    state[folder] = 2;
  };
  std::vector<std::string> folders;
  for (const auto& [folder, targets] : includes) folders.push_back(folder);
  for (const std::string& folder : folders)
    if (state[folder] == 0) visit(folder);
  EXPECT_GT(folders.size(), 40u);
}

TEST(Architecture, NoFolderHasMoreThanFortyFiles) {
  for (const auto& [top, below] : kRooms) {
    std::map<std::string, int> files;
    for (const std::string& place : {top, "tests/" + top}) {
      for (const auto& entry : fs::recursive_directory_iterator(kRoot / place))
        if (entry.is_regular_file()) ++files[entry.path().parent_path()];
    }
    for (const auto& [folder, count] : files) EXPECT_LE(count, kMaxFiles) << folder;
  }
}

TEST(Architecture, NoTwoFilesOfARoomHaveOneName) {
  std::map<std::pair<std::string, std::string>, std::string> first;  // room and name -> path
  for (const Source& source : sources()) {
    const bool test = top_of(source.path) == "tests";
    const std::string room = test ? folder_of(source.path).substr(0, source.path.find('/', 6)) : top_of(source.path);
    const auto [it, fresh] = first.insert({{room, fs::path(source.path).filename()}, source.path});
    EXPECT_TRUE(fresh) << source.path << " and " << it->second;
  }
}

// foo_part.cpp holds a part of what foo.h declares, in its folder or in the one above.  Commands, programs, the
// functions of a WebAssembly module and what is compiled for an instruction set are declared elsewhere.
TEST(Architecture, EverySourceHasAHeader) {
  std::set<std::string> headers;
  for (const Source& source : sources())
    if (source.path.ends_with(".h")) headers.insert(source.path.substr(0, source.path.size() - 2));
  for (const Source& source : sources()) {
    const std::string stem = fs::path(source.path).stem();
    if (!source.path.ends_with(".cpp") || top_of(source.path) == "tests" || source.folder == "app/commands") continue;
    if (source.folder == "app/page/solver") continue;
    if (stem == "main" || stem.ends_with("_avx2") || stem.ends_with("_baseline")) continue;
    bool found = false;
    for (size_t end = stem.size(); end != std::string::npos && end > 0; end = stem.rfind('_', end - 1)) {
      const std::string name = stem.substr(0, end);
      found |= headers.count(source.folder + "/" + name) || headers.count(folder_of(source.folder) + "/" + name);
    }
    EXPECT_TRUE(found) << source.path << ": no header has its name, nor what stands before a _ of it";
  }
}

// A function that is compiled both for every processor and for a newer one under the same name is one weak symbol, and
// the linker may keep the version that older processors cannot run.  So all functions of the files that are compiled
// for an instruction set carry its namespace.
TEST(Architecture, CodeForAnInstructionSetHasNoNamesThatOtherFilesShare) {
  for (const char* library : {PLIANT_RENDER_LIBRARY, PLIANT_KERNELS_LIBRARY}) {
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
  for (const auto& entry : fs::directory_iterator(kRoot)) {
    const std::string name = entry.path().filename();
    if (name[0] == '.' || name.rfind("build", 0) == 0) continue;
    EXPECT_TRUE(agreed.count(name)) << name << " does not belong at the top level";
  }
}
