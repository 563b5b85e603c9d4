#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "app/commands/command.h"
#include "app/demo/kinds/kinds.h"
#include "app/demo/make_demo.h"
#include "app/demo/motion_cache.h"
#include "app/run/run_directory.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/file_lock.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The options of the demo, and its scene file, which stands only beside a whole scene.
constexpr const char *kRecord = "demo.json", *kScene = "scene.json";
/// What else is written into the folder of a scene.
const std::vector<std::string> kContents = {"splats.ply",  "transforms.json", "photos", "masks",
                                            "labels.json", "reference.mp4",   "videos", "truth"};
/// In a folder that is there already: where the scene is made, and what keeps others from it.
constexpr const char *kPartial = ".partial", *kLock = ".lock";

/// A file or folder that goes with its scope, also when what is done there fails.
struct RemovedAtEnd {
  fs::path file;
  ~RemovedAtEnd() {
    std::error_code ignored;
    fs::remove_all(file, ignored);
  }
};

/// Whether a folder that is there holds the wanted demo.  Throws Error{kUsage} where it holds another one that is not
/// to be overwritten, or anything that is not part of a demo.
bool holds_demo(const fs::path& out, const json& wanted, bool overwrite) {
  if (!fs::is_directory(out)) throw usage_error("--out", out.string(), "is a file", "give a folder");
  const bool is_demo = fs::exists(out / kRecord);
  const json before = is_demo ? json::parse(read_text(out / kRecord), nullptr, false) : json();
  const bool same = before == wanted;
  if (same && fs::exists(out / kScene)) return true;
  std::set<std::string> own = {kPartial, kLock};
  if (is_demo) {
    own.insert({kRecord, kScene});
    own.insert(kContents.begin(), kContents.end());
  }
  for (const auto& entry : fs::directory_iterator(out))
    if (const std::string name = entry.path().filename(); !own.count(name))
      throw usage_error("--out", out.string(), "contains '" + name + "', which is not part of a demo",
                        "give a new or an empty folder");
  if (is_demo && !same && !overwrite)
    throw usage_error(
        "--out", out.string(),
        "contains another demo: " + (before.is_object() ? first_difference(before, wanted, "setting")
                                                        : kRecord + std::string(" is not a record of one")),
        "give --overwrite, or another folder");
  return false;
}

/// Moves a whole scene into a folder that is there, in place of the demo that it holds.
void move_in(const fs::path& partial, const fs::path& out) {
  fs::remove(out / kScene);
  fs::rename(partial / kRecord, out / kRecord);
  for (const std::string& name : kContents) {
    fs::remove_all(out / name);
    if (fs::exists(partial / name)) fs::rename(partial / name, out / name);
  }
  fs::rename(partial / kScene, out / kScene);
}

/// Makes the scene in a temporary folder, from which it is moved when whole.  A folder that is there stays, as it may
/// be a mount point or the current one.
json make_demo_once(Context& context, DemoOptions options) {
  // Without a slash at its end: what is made beside it is named after it.
  fs::path out = fs::weakly_canonical(options.out);
  if (!out.has_filename()) out = out.parent_path();
  json wanted = {{"pliant", PLIANT_VERSION},     {"seed", options.seed},     {"gaussians", options.gaussians},
                 {"training", options.training}, {"photos", options.photos}, {"width", options.width},
                 {"height", options.height},     {"video", options.video}};
  if (options.kind != kPottedFlower) wanted["kind"] = options.kind;
  const bool there = fs::exists(out);
  if (there && holds_demo(out, wanted, context.overwrite)) {
    context.progress.say("demo: unchanged, kept");
    return wanted;
  }
  if (out.has_parent_path()) fs::create_directories(out.parent_path());
  const auto beside_or_in = [&](const char* name) { return there ? out / name : fs::path(out.string() + name); };
  const fs::path partial = beside_or_in(kPartial), locked = beside_or_in(kLock);
  const FileLock lock(locked, out.string());
  const RemovedAtEnd lock_file{locked};
  fs::remove_all(partial);
  const RemovedAtEnd unfinished{partial};
  options.out = partial;
  options.interrupted = context.interrupted;
  const DemoSummary summary = make_demo(options);
  write_text(partial / kRecord, wanted.dump(2) + "\n");
  if (there)
    move_in(partial, out);
  else
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
  add_overwrite(*command, program, "Replace a demo that was made with other options");
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
