#include "gaussians/io/splats/splats.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/text.h"
#include "gaussians/io/splats/glb.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/splat_file.h"
#include "gaussians/io/splats/spz.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

enum class Format { kNone, kPly, kSplat, kSpz, kSog, kSogLevels, kKsplat, kCheckpoint };

Format format_of_json(const fs::path& file) {
  try {
    const nlohmann::json json = read_json(file);
    if (!json.is_object()) return Format::kNone;
    if (json.contains("lodLevels")) return Format::kSogLevels;
    return json.contains("means") ? Format::kSog : Format::kNone;
  } catch (const Error&) {
    // A damaged meta.json is still one, and its reader says what is wrong.
    if (file.filename() == "lod-meta.json") return Format::kSogLevels;
    return file.filename() == "meta.json" ? Format::kSog : Format::kNone;
  }
}

Format format_of(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return Format::kNone;
  const std::string extension = lower_extension(file);
  if (extension == ".json") return format_of_json(file);
  std::string magic(4, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(magic.data(), 4);
  magic.resize(static_cast<size_t>(in.gcount()));
  if (magic.substr(0, 3) == "ply" && magic.size() == 4 && (magic[3] == '\n' || magic[3] == '\r')) return Format::kPly;
  if (magic == "NGSP" || magic.substr(0, 2) == "\x1f\x8b") return Format::kSpz;
  if (magic == "PK\3\4") {
    const bool torch = extension == ".pt" || extension == ".pth" || extension == ".ckpt";
    return torch ? Format::kCheckpoint : Format::kSog;
  }
  if (extension == ".splat") return Format::kSplat;
  if (extension == ".ply") return Format::kPly;
  if (extension == ".spz") return Format::kSpz;
  if (extension == ".sog") return Format::kSog;
  return extension == ".ksplat" ? Format::kKsplat : Format::kNone;
}

}  // namespace

fs::path splats_at(const fs::path& path) {
  if (format_of(path) != Format::kNone) return path;
  for (const char* name : {"lod-meta.json", "meta.json"}) {
    if (format_of(path / name) != Format::kNone) return path / name;
  }
  return {};
}

GaussianCloud read_splats(const fs::path& path, ReadReport* report, int level) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw input_error(path.string(), "", "does not exist", "check the name");
  const fs::path file = splats_at(path);
  const Format format = format_of(file);
  if (format != Format::kSogLevels && level != kFinestLevel && level != 0) {
    throw usage_error(path.string(), "--level", "is " + std::to_string(level),
                      "only streamed SOG (lod-meta.json) has levels of detail");
  }
  switch (format) {
    case Format::kPly:
      return read_ply(file, report);
    case Format::kSplat:
      return read_splat(file, report);
    case Format::kSpz:
      return read_spz(file, report);
    case Format::kSog:
      return read_sog(file, report);
    case Format::kSogLevels:
      return read_sog_levels(file, level, report);
    case Format::kKsplat:
      throw input_error(file.string(), "", "is a .ksplat file, a format that is no longer developed",
                        "convert it, for example with: splat-transform in.ksplat out.ply");
    case Format::kCheckpoint:
      throw input_error(file.string(), "", "is a checkpoint of a training",
                        "export a PLY first: `ns-export gaussian-splat` of nerfstudio, or `--save_ply` of gsplat's "
                        "simple_trainer");
    case Format::kNone:
      break;
  }
  throw input_error(path.string(), "", "is not a known splat file",
                    "give a .ply, .splat, .spz, .sog, or the meta.json or lod-meta.json of a SOG");
}

std::vector<std::string> write_splats(const fs::path& file, const GaussianCloud& cloud, bool antialiased,
                                      bool z_is_up) {
  const std::string extension = lower_extension(file);
  std::vector<std::string> lost;
  if (extension == ".ply") {
    write_ply(file, cloud, antialiased, z_is_up);
  } else if (extension == ".spz") {
    const size_t clamped = write_spz(file, cloud, antialiased, z_is_up);
    if (clamped > 0) {
      lost.push_back(file.string() + ": " + std::to_string(clamped) +
                     " Gaussians are farther away, flatter or more saturated than .spz can store; they are clamped");
    }
  } else if (extension == ".glb") {
    write_glb(file, cloud, z_is_up);
    if (antialiased)
      lost.push_back(file.string() + ": glTF does not record that the scene was trained with mip-splatting");
  } else if (extension == ".splat") {
    write_splat(file, cloud);
    if (cloud.sh_degree > 0)
      lost.push_back(file.string() + ": .splat has no harmonics: colors no longer depend on the viewing direction");
    if (antialiased)
      lost.push_back(file.string() + ": .splat does not record that the scene was trained with mip-splatting");
    if (z_is_up) lost.push_back(file.string() + ": .splat does not record that z is up");
  } else {
    throw usage_error(file.string(), "", "is in a format that cannot be written", "splats: .ply, .splat, .spz or .glb");
  }
  return lost;
}

}  // namespace pliant
