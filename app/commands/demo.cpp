#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/commands/command.h"
#include "app/demo/kinds/kinds.h"
#include "app/demo/make_demo.h"
#include "app/demo/motion_cache.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/file_lock.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A file that goes with its scope, also when what is done there fails.
struct RemovedAtEnd {
  fs::path file;
  ~RemovedAtEnd() {
    std::error_code ignored;
    fs::remove(file, ignored);
  }
};

/// Makes the scene in a temporary folder that is renamed when whole.  A folder made with equal options is kept; one
/// made with other options is a usage error unless the user asks to overwrite.
json make_demo_once(Context& context, DemoOptions options) {
  // Without a slash at its end: what is made beside it is named after it.
  fs::path out = fs::weakly_canonical(options.out);
  if (!out.has_filename()) out = out.parent_path();
  json wanted = {{"pliant", PLIANT_VERSION},     {"seed", options.seed},     {"gaussians", options.gaussians},
                 {"training", options.training}, {"photos", options.photos}, {"width", options.width},
                 {"height", options.height},     {"video", options.video}};
  if (options.kind != kPottedFlower) wanted["kind"] = options.kind;
  if (fs::exists(out) && !(fs::is_directory(out) && fs::is_empty(out))) {
    const fs::path record = out / "demo.json";
    if (fs::exists(record) && json::parse(read_text(record), nullptr, false) == wanted) {
      context.progress.say("demo: unchanged, kept");
      return wanted;
    }
    if (!fs::exists(record) || !context.overwrite)
      throw usage_error("--out", out.string(),
                        fs::exists(record) ? "contains a demo made with other options" : "contains other files",
                        fs::exists(record) ? "give --overwrite, or another folder" : "give a new folder");
  }
  if (out.has_parent_path()) fs::create_directories(out.parent_path());
  const fs::path partial = out.string() + ".partial", locked = out.string() + ".lock";
  const FileLock lock(locked, out.string());
  const RemovedAtEnd lock_file{locked};
  fs::remove_all(partial);
  options.out = partial;
  const DemoSummary summary = make_demo(options);
  write_text(partial / "demo.json", wanted.dump(2) + "\n");
  fs::remove_all(out);
  fs::rename(partial, out);
  context.progress.say(
      fmt::format("demo: {} Gaussians, {} photos in {}", summary.gaussians, summary.photos, out.string()));
  return wanted;
}

}  // namespace

void add_demo(CLI::App& app, Program& program) {
  CLI::App* command =
      app.add_subcommand("demo", "Make a procedural scene: splats, photos, masks, reference videos, truth/");
  auto options = std::make_shared<DemoOptions>();
  command
      ->add_option("--kind", options->kind,
                   fmt::format("Object of the scene: {} [{}]", fmt::join(demo_kind_names(), ", "), options->kind))
      ->check(CLI::IsMember(demo_kind_names()))
      ->option_text("KIND");
  const auto add_number = [&](const char* name, int& field, const std::string& help) {
    return command->add_option(name, field, fmt::format("{} [{}]", help, field))->option_text("N");
  };
  add_number("--gaussians", options->gaussians, "Number of Gaussians in the scene")->check(CLI::Range(2000, 5000000));
  add_number("--training", options->training,
             "Training iterations of the Gaussians on the photos; 0 = keep the initial flat disks")
      ->check(CLI::NonNegativeNumber);
  add_number("--photos", options->photos, "Number of photos")->check(CLI::Range(2, 1000));
  add_number("--width", options->width, "Width of the photos [px]")->check(CLI::Range(16, 8000));
  add_number("--height", options->height, "Height of the photos [px]")->check(CLI::Range(16, 8000));
  command->add_flag_callback(
      "--no-video", [options] { options->video = false; }, "Skip the reference videos and their simulation");
  add_out(*command, program, "Scene folder to write")->required();
  add_overwrite(*command, program);
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context& context) {
      options->out = program.out;
      options->seed = program.seed;
      options->cache = demo_cache_folder();
      return make_demo_once(context, *options);
    };
  });
}

}  // namespace pliant
