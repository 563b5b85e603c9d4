#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/predict/predict_preview.h"
#include "app/predict/predict_stage.h"
#include "fitting/predict/material_table.h"
#include "gaussians/base/error.h"

namespace pliant {

void add_predict(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("predict", "Predict what the object is made of, from its name and shape");
  auto directory = std::make_shared<std::string>();
  auto stage = std::make_shared<PredictStage>();
  auto list = std::make_shared<bool>(false);
  command->add_option("DIR", *directory, "Run directory");
  add_options(*command, program, options_of(*stage));
  command->add_flag("--list", *list, "Print the known materials and objects, and where their values come from");
  auto preview = std::make_shared<bool>(false);
  command->add_flag(
      "--preview", *preview,
      "Also make softness.mp4: short clips at softness 0, 0.5 and 1, side by side; without other options, of "
      "the prediction that is there");
  add_overwrite(*command, program);
  add_common(*command, program);
  command->callback([=, &program] {
    if (!*list && directory->empty()) throw CLI::RequiredError("DIR");
    program.action = [=](Context& context) {
      if (*list) {
        refuse_given(*command, options_of(*stage), {"does nothing with --list", "leave it out", {}});
        if (*preview) throw usage_error("predict", "--preview", "does nothing with --list", "leave it out");
        std::fputs(material_list(material_table()).c_str(), stdout);
        return nlohmann::json::object();
      }
      RunDirectory run = RunDirectory::open(*directory);
      Scene scene = load_run_scene(run);
      if (*preview && given_option(*command, options_of(*stage)).empty()) take_last_options(run, *stage);
      inputs_of(run, scene, *stage);  // nothing is assumed for what will be refused
      assume_height(context, run, scene, *stage);
      const nlohmann::json summary = run_predict(context, run, scene, *stage);
      if (*preview) run_preview(context, run, scene, *stage);
      return summary;
    };
  });
}

}  // namespace pliant
