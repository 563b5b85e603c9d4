#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/predict/object_prior.h"
#include "app/predict/predict_preview.h"
#include "app/predict/predict_stage.h"
#include "fitting/predict/material_table.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// The rows of both tables.
nlohmann::json to_json(const MaterialTable& table) {
  nlohmann::json materials = nlohmann::json::array(), objects = nlohmann::json::array();
  for (const KnownMaterial& m : table.materials)
    materials.push_back({{"name", m.name},
                         {"synonyms", m.synonyms},
                         {"class", m.group},
                         {"young_pa", band_json(m.young)},
                         {"poisson", band_json(m.poisson)},
                         {"density_kg_m3", band_json(m.density)},
                         {"law", law_name(m.law.law)},
                         {"kind", row_kind_name(m.kind)},
                         {"source", m.source},
                         {"licence", m.licence},
                         {"reason", m.reason}});
  for (const KnownObject& o : table.objects) {
    nlohmann::json parts = nlohmann::json::array();
    for (const KnownPart& part : o.parts)
      parts.push_back(
          {{"material", table.materials[part.material].name}, {"share", part.share}, {"moves", part.moves}});
    objects.push_back({{"name", o.name},
                       {"synonyms", o.synonyms},
                       {"parts", parts},
                       {"height_m", band_json(o.height)},
                       {"longest", o.longest},
                       {"bulk_density_kg_m3", o.bulk_density > 0 ? nlohmann::json(o.bulk_density) : nlohmann::json()},
                       {"frequency_hz", band_json(o.frequency)}});
  }
  return {{"materials", materials}, {"objects", objects}};
}

}  // namespace

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
  add_common(*command, program);
  command->callback([=, &program] {
    if (!*list && directory->empty()) throw CLI::RequiredError("DIR");
    program.action = [=, &program](Context& context) -> nlohmann::json {
      if (*list) {
        refuse_given(*command, options_of(*stage), {"does nothing with --list", "leave it out", {}});
        if (*preview) throw usage_error("predict", "--preview", "does nothing with --list", "leave it out");
        if (!program.json) std::fputs(material_list(material_table()).c_str(), stdout);
        return to_json(material_table());
      }
      RunDirectory run = RunDirectory::open(*directory);
      Scene scene = load_run_scene(run);
      if (*preview && given_option(*command, options_of(*stage)).empty()) take_last_options(run, *stage);
      keep_known_object(run, *stage);
      // Nothing is assumed or replaced for what will be refused.
      inputs_of(run, scene, *stage);
      if (*preview) check_preview(run, scene, *stage);
      warn_of_selection(context, run);
      const std::optional<double> height = assume_height(context, run, scene, *stage);
      const nlohmann::json summary = run_predict(context, run, scene, *stage);
      record_assumed_height(run, height);
      if (*preview) run_preview(context, run, scene, *stage);
      return summary;
    };
  });
}

}  // namespace pliant
