#include "fitting/observe/generate_video.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "fitting/observe/child_process.h"
#include "fitting/observe/frame_source.h"
#include "gaussians/base/error.h"
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

}  // namespace

ReferenceVideo generate_video(const GenerateOptions& options, const ImageF& first, const Camera& camera,
                              const fs::path& folder) {
  if (options.frames < 2 || !(options.fps > 0)) {
    throw usage_error("--video-model-cmd", options.frames < 2 ? "frames" : "fps",
                      fmt::format("is {}", options.frames < 2 ? options.frames : options.fps),
                      "ask for at least two frames at a positive rate");
  }
  CHECK(first.width == camera.width && first.height == camera.height && first.channels == 3);
  const fs::path frames = folder / "frames";
  fs::remove_all(frames);
  fs::create_directories(frames);
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

  ReferenceVideo video;
  video.camera = camera;
  video.fps = video.source_fps = options.fps;
  video.frames_in_file = options.frames;
  for (int f = 0; f < options.frames; ++f) {
    const fs::path file = frames / fmt::format("{:04}.png", f);
    if (!fs::exists(file)) {
      throw input_error(
          options.command, file.filename().string(),
          fmt::format("is missing: {} of {} frames were requested and {} images are in {}{}", f + 1, options.frames,
                      pictures_in_order(frames).size(), frames.string(), process.last_words()),
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

}  // namespace pliant
