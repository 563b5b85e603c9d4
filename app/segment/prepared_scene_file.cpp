#include "app/segment/prepared_scene_file.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "app/run/scene_parts.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kFile = "prepared_scene.bin";
constexpr const char* kMagic = "pliant prepared scene 1\n";
constexpr size_t kDigest = 64;  // characters of SHA-256

/// Calls visit(vector or number) for all that a view keeps but its window, which follows from its camera.
template <class View, class Visit>
void visit_view(View& view, const Visit& visit) {
  visit(view.region);
  visit(view.lab);
  visit(view.area);
  visit(view.middle);
  visit(view.edges);
  visit(view.row_start);
  visit(view.gaussian);
  visit(view.weight);
}

template <class SceneType, class Visit>
void visit_scene(SceneType& scene, const Visit& visit) {
  visit(scene.graph.nodes);
  visit(scene.graph.edges);
  visit(scene.graph.edge_nearness);
  visit(scene.graph.lab);
  visit(scene.graph.opacity);
  visit(scene.graph.spacing);
  visit(scene.parts.part);
  visit(scene.parts.lab);
  visit(scene.parts.opacity);
  visit(scene.parts.edges);
  visit(scene.parts.edge_nearness);
  visit(scene.parts.edge_of);
  visit(scene.shown);
  visit(scene.diagonal);
}

/// Numbers one after another: of a vector its length, then its elements, as they lie in memory.
class Writer {
 public:
  template <class T>
  void operator()(const T& number) {
    put(&number, sizeof(T));
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(static_cast<uint64_t>(values.size()));
    put(values.data(), values.size() * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void put(const void* from, size_t count) { bytes_.append(static_cast<const char*>(from), count); }

  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  void operator()(T& number) {
    take(&number, sizeof(T));
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    uint64_t count = 0;
    (*this)(count);
    good_ = good_ && count <= bytes_.size() / sizeof(T);
    values.resize(good_ ? count : 0);
    take(values.data(), values.size() * sizeof(T));
  }
  bool finished() const { return good_ && bytes_.empty(); }
  bool good() const { return good_; }

 private:
  void take(void* to, size_t count) {
    good_ = good_ && count <= bytes_.size();
    if (!good_) return;
    std::copy_n(bytes_.data(), count, static_cast<char*>(to));
    bytes_.remove_prefix(count);
  }

  std::string_view bytes_;
  bool good_ = true;
};

/// What a file begins with, before the digest of the rest.
std::string head_of(const std::string& key) { return kMagic + std::to_string(key.size()) + "\n" + key + "\n"; }

/// Splats and cameras by contents, and how they are prepared.
std::string key_of_scene(const PrepareOptions& options, const Scene& scene) {
  const SceneRecord record = record_of({ScenePart::kSplats, ScenePart::kCameras}, scene);
  json key = {{"pliant", PLIANT_VERSION},
              {"scene", record.values},
              {"options",
               {options.neighbours, options.part, options.least_parts, options.most_views, options.view_pixels,
                options.view.area, options.view.color, options.view.least, options.view.render.antialiased}}};
  for (const auto& [role, file] : record.files) key["files"][role] = hash_of_input(file);
  return key.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

void write_prepared_scene(const fs::path& file, const std::string& key, const PreparedScene& scene) {
  Writer writer;
  visit_scene(scene, [&](const auto& values) { writer(values); });
  writer(static_cast<uint64_t>(scene.views.size()));
  for (const RegionView& view : scene.views) {
    writer(view.window.source);
    visit_view(view, [&](const auto& values) { writer(values); });
  }
  write_text(file, head_of(key) + sha256_of_text(writer.bytes()) + writer.bytes());
}

std::optional<PreparedScene> read_prepared_scene(const fs::path& file, const std::string& key,
                                                 const PrepareOptions& options, const std::vector<Camera>& cameras) {
  if (!fs::is_regular_file(file)) return {};
  const std::string bytes = read_text(file), head = head_of(key);
  if (!bytes.starts_with(head) || bytes.size() < head.size() + kDigest) return {};
  const std::string body = bytes.substr(head.size() + kDigest);
  if (bytes.compare(head.size(), kDigest, sha256_of_text(body)) != 0) return {};
  PreparedScene scene;
  scene.options = options;
  Reader reader(body);
  visit_scene(scene, [&](auto& values) { reader(values); });
  uint64_t count = 0;
  reader(count);
  for (uint64_t k = 0; k < count && reader.good(); ++k) {
    int source = -1;
    reader(source);
    if (source < 0 || source >= static_cast<int>(cameras.size())) return {};
    RegionView view{whole_picture(cameras, source, options.view_pixels), {}, {}, {}, {}, {}, {}, {}, {}};
    visit_view(view, [&](auto& values) { reader(values); });
    scene.views.push_back(std::move(view));
  }
  if (!reader.finished()) return {};
  scene.adjacency = Adjacency(scene.graph.nodes.size(), scene.graph.edges);
  return scene;
}

PreparedScene prepared_scene(const Context& context, const RunDirectory& run, const Scene& scene) {
  PrepareOptions options;
  options.view.render.antialiased = scene.report.antialiased;
  const std::string key = key_of_scene(options, scene);
  const fs::path file = run / kFile;
  if (std::optional<PreparedScene> ready = read_prepared_scene(file, key, options, scene.cameras))
    return *std::move(ready);
  context.progress.say("segment: preparing the scene for selection");
  const auto start = std::chrono::steady_clock::now();
  PreparedScene out = prepare_scene(options, scene.cloud, scene.cameras);
  try {
    write_prepared_scene(file, key, out);
  } catch (const Error& error) {
    context.progress.warn(std::string("segment: the prepared scene cannot be kept for the next time: ") + error.what());
  }
  context.progress.say(fmt::format("segment: prepared {} Gaussians in {} parts and {} views ({:.1f} s)",
                                   scene.cloud.size(), out.parts.size(), out.views.size(),
                                   std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()));
  return out;
}

GestureOptions gesture_options(const Context& context, const Scene& scene) {
  GestureOptions options;
  options.seed = context.seed;
  options.up = scene.up.cast<float>();
  options.render.antialiased = scene.report.antialiased;
  return options;
}

}  // namespace pliant
