#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

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
/// Whether what the stage `render` or `page` has left shows the motion that is there; of one that was begun and has not
/// finished nobody knows, so that it does not.
bool shows_motion(const RunDirectory& run, const std::string& stage);
/// Removes the page of an earlier motion.
void drop_page(RunDirectory& run);
/// The same into a file of one's own.
nlohmann::json export_page(const Context& context, const RunDirectory& run, const Scene& scene, const PageStage& stage,
                           const std::filesystem::path& file);
/// Eight cameras around `centre` (scene units) that stand for where a page is looked at from: the first is `camera`,
/// the others follow at equal angles all around, or on a swing by 25 degrees to either side, where the third and the
/// seventh are its ends.
std::vector<Camera> page_views(const Camera& camera, const Vec3d& centre, const Vec3d& up, bool all_around);

}  // namespace pliant
