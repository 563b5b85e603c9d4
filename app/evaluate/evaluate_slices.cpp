#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/evaluate/clip.h"
#include "app/report/space_time_slices.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {

json evaluate_slices(const fs::path& reference, const std::vector<fs::path>& clips, const SliceScore& score,
                     const fs::path& picture) {
  std::vector<fs::path> all = {reference};
  all.insert(all.end(), clips.begin(), clips.end());
  check_fps(score, all);
  const ClipSize compared = compared_size(reference, score);
  const Camera& size = compared.camera;
  std::vector<ReferenceVideo> videos = {read_clip(reference, score, 0, size)};
  std::vector<std::string> names = {reference.stem().string()};
  size_t frames = videos[0].frames.size();
  for (const fs::path& clip : clips) {
    videos.push_back(read_clip(clip, score, videos[0].fps, size, videos[0].start));
    names.push_back(clip.stem().string());
    frames = std::min(frames, videos.back().frames.size());
  }
  SliceLines lines = most_changed_lines(videos[0].frames);
  const auto take = [](const char* option, const std::optional<int>& given, int length, int& line) {
    if (!given) return;
    if (*given < 0 || *given >= length)
      throw usage_error("evaluate", option, "is " + std::to_string(*given),
                        "the reference has lines 0 to " + std::to_string(length - 1));
    line = *given;
  };
  take("--row", score.row, size.height, lines.row);
  take("--column", score.column, size.width, lines.column);
  SpaceTimeSlices slices(names, lines);
  for (size_t f = 0; f < frames; ++f) {
    std::vector<const ImageF*> now;
    for (const ReferenceVideo& video : videos) now.push_back(&video.frames[f]);
    slices.add(now);
  }
  write_image(picture, slices.picture());
  json out = {{"kind", "slices"},       {"row", lines.row},
              {"column", lines.column}, {"width", size.width},
              {"height", size.height},  {"fps", videos[0].fps},
              {"frames", frames},       {"picture", picture.string()},
              {"clips", json::array()}, {"warnings", compared.warnings}};
  for (const ReferenceVideo& video : videos)
    for (const std::string& warning : video.warnings) out["warnings"].push_back(warning);
  for (const fs::path& clip : clips)
    if (const std::string scaled = other_size(clip, score, compared); !scaled.empty())
      out["warnings"].push_back(scaled);
  for (size_t k = 1; k < videos.size(); ++k) {
    const auto [row, column] = slices.rmse(k);
    out["clips"].push_back({{"file", clips[k - 1].string()}, {"row_rmse", row}, {"column_rmse", column}});
    if (videos.size() == 2) {
      out["row_rmse"] = row;
      out["column_rmse"] = column;
    }
  }
  return out;
}

}  // namespace pliant
