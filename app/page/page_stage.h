#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// page: clip.html, the moving scene in one file, in which any browser lets a person grab the object.
struct PageStage {
  bool html = true;          ///< in `run`
  size_t size = 12'000'000;  ///< bytes of the file at most
  bool grows = false;        ///< the smallest page that has a solver is made however large it is
  std::string licence;       ///< of the scene, which the page shows
  std::string command;       ///< that makes it, likewise
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(PageStage& stage);
StageInputs<PageStage> inputs_of(const RunDirectory& run, const Scene& scene, const PageStage& stage);
nlohmann::json run_page(const Context& context, RunDirectory& run, const Scene& scene, const PageStage& stage);
/// Whether what the stage `render` or `page` has left shows the motion that is there, as far as is known.
bool shows_motion(const RunDirectory& run, const std::string& stage);
/// Removes the page of an earlier motion.
void drop_page(RunDirectory& run);
/// The same into a file of one's own.
nlohmann::json export_page(const Context& context, const RunDirectory& run, const Scene& scene, const PageStage& stage,
                           const std::filesystem::path& file);

}  // namespace pliant
