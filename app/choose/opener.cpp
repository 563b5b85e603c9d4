#include "app/choose/opener.h"

#include <fmt/format.h>
#include <omp.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/splats/splats.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A browser that is told what happens, and says nothing.
class Listener : public Client {
 public:
  void receive(std::string) override {}
};

}  // namespace

void tell_progress(Progress& progress, const Context& outer, std::function<void(const json&)> tell) {
  progress.listen([&outer, tell = std::move(tell)](const ProgressEvent& event) {
    if (event.fraction >= 0) return tell({{"progress", {{"text", event.text}, {"fraction", event.fraction}}}});
    if (!event.warning) outer.progress.say(event.text);
    tell({{"said", event.text}, {"warning", event.warning}});
  });
}

Opener::Opener(const Context& context, LiveSite& site, fs::path folder, std::function<fs::path(const fs::path&)> run_of,
               std::function<void(const Context&, const fs::path&)> open)
    : context_(context),
      site_(site),
      folder_(std::move(folder)),
      run_of_(std::move(run_of)),
      open_(std::move(open)),
      thread_([this] { work(); }) {
  site_.at_end([this] { stop(); });
}

Opener::~Opener() { stop(); }

void Opener::stop() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Opener::show() {
  site_.show({open_page(), [](std::shared_ptr<Connection>) { return std::make_unique<Listener>(); }});
}

/// The file in a folder that is not there yet: with its name, or with a number behind its stem where that is taken.
fs::path Opener::free_place(const fs::path& name) const {
  const auto place = [&](const std::string& stem) {
    return folder_ / ("dropped_" + stem) / (stem + name.extension().string());
  };
  fs::path out = place(name.stem().string());
  for (int k = 2; fs::exists(out.parent_path()) || fs::exists(run_of_(out)); ++k)
    out = place(fmt::format("{}-{}", name.stem().string(), k));
  return out;
}

std::string Opener::take(const std::string& name, const fs::path& file) {
  const std::lock_guard lock(mutex_);
  std::error_code error;
  if (taken_) {
    fs::remove(file, error);
    return "A scene is open already: reload this page.";
  }
  // What a file is may be told by its name alone.
  const fs::path scene = free_place(name);
  fs::create_directory(scene.parent_path(), error);
  if (!error) fs::rename(file, scene, error);
  if (error) {
    const std::string why = error.message();
    fs::remove(scene.parent_path(), error);
    return "The file cannot be kept: " + why;
  }
  if (splats_at(scene).empty()) {
    fs::remove(scene, error);
    fs::remove(scene.parent_path(), error);
    return name + " is not a splat file: give .ply, .splat, .spz or .sog.";
  }
  scene_ = scene;
  taken_ = true;
  wake_.notify_one();
  return "";
}

void Opener::work() {
  Progress progress(true);
  tell_progress(progress, context_, [this](const json& message) { tell(message); });
  const Context context{progress, [this] { return ended_ || context_.interrupted(); }, context_.seed, context_.threads,
                        context_.overwrite};
  if (context_.threads > 0) omp_set_num_threads(context_.threads);
  for (;;) {
    fs::path scene;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return ended_ || !scene_.empty(); });
      if (ended_) return;
      scene.swap(scene_);
    }
    try {
      open_(context, scene);
      tell({{"reload", true}});
    } catch (const std::exception& error) {
      {
        const std::lock_guard lock(mutex_);
        taken_ = false;
      }
      tell({{"failed", error.what()}});
    }
  }
}

void Opener::tell(const json& message) { site_.tell(message.dump(-1, ' ', false, json::error_handler_t::replace)); }

}  // namespace pliant
