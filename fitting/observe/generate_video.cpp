#include "fitting/observe/generate_video.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "fitting/observe/child_process.h"
#include "fitting/observe/frame_source.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

json json_of(const Camera& camera) {
  json rows = json::array();
  for (int r = 0; r < 4; ++r) {
    json row = json::array();
    for (int c = 0; c < 4; ++c) row.push_back(camera.cam_from_world.matrix()(r, c));
    rows.push_back(row);
  }
  return {{"name", camera.name}, {"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},     {"cx", camera.cx},       {"cy", camera.cy},         {"cam_from_world", rows}};
}

fs::path frame_file(const fs::path& folder, int frame) { return folder / "frames" / fmt::format("{:04}.png", frame); }

constexpr const char* kMadeFor = "made_for.json";  // written once all frames are there

/// Returns the end of what it printed.
std::string run_program(const GenerateOptions& options, const ImageF& first, const Camera& camera,
                        const fs::path& folder) {
  fs::remove(folder / kMadeFor);
  fs::remove_all(folder / "frames");
  fs::create_directories(folder / "frames");
  write_image(folder / "first.png", first);
  write_json(folder / "camera.json", json_of(camera));
  write_json(folder / "request.json", {{"protocol", 1},
                                       {"frames", options.frames},
                                       {"fps", options.fps},
                                       {"width", camera.width},
                                       {"height", camera.height},
                                       {"seed", options.seed},
                                       {"prompt", options.prompt},
                                       {"first", "first.png"},
                                       {"camera", "camera.json"},
                                       {"write", "frames/%04d.png"}});

  ChildOptions child;
  child.command = options.command;
  child.argument = fs::absolute(folder).string();
  child.log = folder / "log.txt";
  child.interrupted = options.interrupted;
  ChildProcess process(child);
  const std::optional<int> code = process.wait(options.time_limit);
  if (!code) {
    process.kill();
    throw input_error(options.command, "",
                      fmt::format("generated no video within {:.4g} s{}", options.time_limit, process.last_words()),
                      "allow it more time, or ask for fewer frames");
  }
  if (*code != 0)
    throw input_error(options.command, "", fmt::format("ended with exit code {}{}", *code, process.last_words()),
                      "see " + (folder / "log.txt").string());
  return process.last_words();
}

ReferenceVideo read_frames(const GenerateOptions& options, const Camera& camera, const fs::path& folder,
                           const std::string& last_words) {
  const fs::path frames = folder / "frames";
  ReferenceVideo video;
  video.camera = camera;
  video.fps = video.source_fps = options.fps;
  video.frames_in_file = options.frames;
  for (int f = 0; f < options.frames; ++f) {
    const fs::path file = frame_file(folder, f);
    if (!fs::exists(file)) {
      throw input_error(options.command, file.filename().string(),
                        fmt::format("is missing: {} of {} frames were requested and {} images are in {}{}", f + 1,
                                    options.frames, pictures_in_order(frames).size(), frames.string(), last_words),
                        "it must write frames/0000.png and so on, as request.json says");
    }
    ImageF picture = read_image(file);
    if (picture.width != camera.width || picture.height != camera.height) {
      throw input_error(options.command, file.filename().string(),
                        fmt::format("has {} x {} pixels, {} x {} were requested", picture.width, picture.height,
                                    camera.width, camera.height),
                        "it must write frames of the size in request.json");
    }
    video.frames.push_back(std::move(picture));
  }
  const size_t written = pictures_in_order(frames).size();
  if (written > static_cast<size_t>(options.frames))
    video.warnings.push_back(fmt::format("`{}` wrote {} frames, {} were requested: the rest are ignored",
                                         options.command, written, options.frames));
  return video;
}

}  // namespace

bool has_generated(const GenerateOptions& options, const fs::path& folder) {
  if (options.made_for.empty() || !fs::exists(folder / kMadeFor)) return false;
  for (int f = 0; f < options.frames; ++f)
    if (!fs::exists(frame_file(folder, f))) return false;
  return read_text(folder / kMadeFor) == options.made_for;
}

ReferenceVideo generate_video(const GenerateOptions& options, const ImageF& first, const Camera& camera,
                              const fs::path& folder) {
  if (options.frames < 2 || !(options.fps > 0)) {
    throw usage_error("--video-model-cmd", options.frames < 2 ? "frames" : "fps",
                      fmt::format("is {}", options.frames < 2 ? options.frames : options.fps),
                      "ask for at least two frames at a positive rate");
  }
  CHECK(first.width == camera.width && first.height == camera.height && first.channels == 3);
  if (has_generated(options, folder)) return read_frames(options, camera, folder, "");
  const std::string last_words = run_program(options, first, camera, folder);
  ReferenceVideo video = read_frames(options, camera, folder, last_words);
  if (!options.made_for.empty()) write_text(folder / kMadeFor, options.made_for);
  return video;
}

}  // namespace pliant
