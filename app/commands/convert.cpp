#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/splats/splats.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

struct ConvertOptions {
  std::string in, out;
  std::optional<int> degree, level;
  double scale = 1;
  bool antialiased = false;
};

OptionTable options_of(ConvertOptions& options) {
  return {"convert",
          {{.name = "sh-degree",
            .field = &options.degree,
            .help = "Keep spherical harmonics up to this degree",
            .low = 0,
            .high = 3},
           level_option(options.level),
           {.name = "scale",
            .field = &options.scale,
            .help = "Multiply all lengths by this; convert splats and cameras of a scene alike",
            .positive = true},
           {.name = "antialiased",
            .field = &options.antialiased,
            .help = "Mark the splats as trained with mip-splatting, which their file does not say"}}};
}

nlohmann::json convert_splats(const Context& context, const ConvertOptions& options) {
  ReadReport report;
  GaussianCloud cloud = read_splats(options.in, &report, options.level.value_or(kFinestLevel));
  for (const std::string& warning : report.warnings) context.progress.warn(warning);
  if (cloud.size() == 0) throw input_error(options.in, "", "contains no usable Gaussians", "give a trained scene");
  if (report.object_channels > 0) context.progress.warn(options.out + ": obj_dc_* of Gaussian Grouping are not kept");
  if (options.degree) cloud = with_sh_degree(cloud, *options.degree);
  for (Vec3f& x : cloud.position) x *= static_cast<float>(options.scale);
  for (Vec3f& s : cloud.log_scale) s.array() += static_cast<float>(std::log(options.scale));
  const bool antialiased = options.antialiased || report.antialiased;
  for (const std::string& lost : write_splats(options.out, cloud, antialiased, report.z_is_up))
    context.progress.warn(lost);
  return {{"gaussians", cloud.size()}, {"dropped", report.dropped}, {"sh_degree", cloud.sh_degree}};
}

/// The points of structure from motion that belong to the cameras; none where they cannot be read.
SparsePoints points_of(const Context& context, const ConvertOptions& options, const CameraFile& file) {
  try {
    SparsePoints points = read_sparse_points(options.in, file.cameras);
    for (Vec3f& x : points.position) x *= static_cast<float>(options.scale);
    for (const std::string& warning : points.warnings) context.progress.warn(warning);
    return points;
  } catch (const Error& error) {
    if (error.failure != Failure::kInput) throw;
    context.progress.warn(std::string(error.what()) + "; the points are left out");
    return {};
  }
}

nlohmann::json convert_cameras(const Context& context, const ConvertOptions& options) {
  CameraFile file = read_cameras(options.in);
  for (Camera& camera : file.cameras) camera.cam_from_world.translation() *= options.scale;
  for (const std::string& warning : file.warnings) context.progress.warn(warning);
  const SparsePoints points = points_of(context, options, file);
  const fs::path points_file = points_beside(options.out);
  if (!points.empty() && fs::exists(points_file) && !context.overwrite)
    throw usage_error(points_file.string(), "", "already exists", "give --overwrite, or another name");
  for (const std::string& lost : write_cameras(options.out, file.cameras, points)) context.progress.warn(lost);
  return {{"cameras", file.cameras.size()}, {"points", points.position.size()}};
}

}  // namespace

void add_convert(CLI::App& app, Program& program) {
  CLI::App* command =
      app.add_subcommand("convert", "Splats to splats (.ply, .splat, .spz, .glb), cameras to cameras (.json)");
  auto options = std::make_shared<ConvertOptions>();
  command->add_option("IN", options->in, "Splats or cameras in any supported format")->required();
  command->add_option("OUT", options->out, "File to write; its extension sets the format")->required();
  add_options(*command, program, options_of(*options));
  add_overwrite(*command, program, "Replace a file that exists");
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [options, command](Context& context) -> nlohmann::json {
      if (fs::exists(options->out) && !context.overwrite)
        throw usage_error(options->out, "", "already exists", "give --overwrite, or another name");
      const bool to_cameras = fs::path(options->out).extension() == ".json";
      if (to_cameras && !splats_at(options->in).empty())
        throw usage_error(options->out, "", "is a camera file but " + options->in + " contains splats",
                          "write splats to .ply, .splat, .spz or .glb");
      const Unused of_splats = {"does nothing for cameras", "leave it out", {"sh-degree", "level", "antialiased"}};
      if (to_cameras) refuse_given(*command, options_of(*options), of_splats);
      return to_cameras ? convert_cameras(context, *options) : convert_splats(context, *options);
    };
  });
}

}  // namespace pliant
