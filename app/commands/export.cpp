#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/page/page_stage.h"
#include "app/simulate/export_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// What `export` writes: splat files, those of PhysGaussian, or a page.
struct ExportOptions {
  ExportStage splats;
  PageStage page;
  std::string html;  ///< file
};

OptionTable options_of(ExportOptions& options) {
  OptionTable table = options_of(options.splats);
  table.options.push_back({.name = "html",
                           .field = &options.html,
                           .help = "File for the moving scene as a page that any browser plays",
                           .value = "FILE"});
  for (Option& option : options_of(options.page).options)
    if (option.name != "no-html") table.options.push_back(std::move(option));
  return table;
}

void check_given(const CLI::App& command, ExportOptions& options) {
  check_given(command, options.splats);
  const OptionTable table = options_of(options);
  if (options.html.empty()) {
    refuse_given(command, table, {"does nothing without --html", "add --html FILE", {"html-size", "html-license"}});
    return;
  }
  refuse_given(command, table,
               {"does nothing with --html",
                "leave one of them out",
                {"ply-sequence", "physgaussian-output", "material", "every", "object-only", "recorded"}});
}

nlohmann::json run_export(const Context& context, RunDirectory& run, const Scene& scene, const ExportOptions& options) {
  if (options.html.empty()) return run_export(context, run, scene, options.splats);
  const std::filesystem::path file = options.html;
  if (std::filesystem::exists(file) && !context.overwrite)
    throw usage_error("--html", file.string(), "exists", "give another name, or --overwrite");
  return export_page(context, run, scene, options.page, file);
}

}  // namespace

void add_export(CLI::App& app, Program& program) {
  add_stage_command<ExportOptions>(app, program, "export", "Write the moving scene as splat files or as a page",
                                   run_export, check_given, "Replace files that exist");
}

}  // namespace pliant
