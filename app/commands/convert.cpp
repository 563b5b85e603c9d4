#include <filesystem>

#include "app/commands/command.h"
#include "gaussians/base/error.h"
#include "gaussians/io/ply.h"
#include "gaussians/io/transforms.h"

namespace pliant {

void add_convert(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("convert", "Splats to splats (.ply), cameras to cameras (.json)");
  auto in = std::make_shared<std::string>(), out = std::make_shared<std::string>();
  auto degree = std::make_shared<int>(-1);
  command->add_option("IN", *in, "File to read")->required();
  command->add_option("OUT", *out, "File to write; its extension says the format")->required();
  command->add_option("--sh-degree", *degree, "Keep spherical harmonics up to this degree")->check(CLI::Range(0, 3));
  add_overwrite(*command, program);
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context& context) -> nlohmann::json {
      const std::filesystem::path from = *in, to = *out;
      if (std::filesystem::exists(to) && !context.overwrite)
        throw usage_error(to.string(), "", "exists already", "give --overwrite, or another name");
      if (from.extension() != to.extension())
        throw usage_error(to.string(), "", "'" + from.extension().string() + "' cannot become '" + to.extension().string() + "'",
                          "splats: .ply; cameras: transforms .json");
      if (to.extension() == ".json") {
        const std::vector<Camera> cameras = read_transforms(from).cameras;
        write_transforms(to, cameras);
        return {{"cameras", cameras.size()}};
      }
      if (to.extension() != ".ply")
        throw usage_error(to.string(), "", "is of an unknown format", "splats: .ply; cameras: transforms .json");
      ReadReport report;
      GaussianCloud cloud = read_ply(from, &report);
      for (const std::string& warning : report.warnings) context.progress.warn(warning);
      if (*degree >= 0) cloud = with_sh_degree(cloud, *degree);
      write_ply(to, cloud, report.antialiased);
      return {{"gaussians", cloud.size()}, {"dropped", report.dropped}, {"sh_degree", cloud.sh_degree}};
    };
  });
}

}  // namespace pliant
