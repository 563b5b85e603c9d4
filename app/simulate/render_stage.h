#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// render: clip.mp4 from a fixed camera, clip_orbit.mp4 from a moving one.
struct RenderStage {
  std::string camera;  ///< name of the fixed camera; empty = the video's, else one that sees the object well
  bool orbit = true;
  bool frames = false;  ///< also clip/000000.png ..., which lose nothing
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(RenderStage& stage);
StageInputs<RenderStage> inputs_of(const RunDirectory& run, const Scene& scene, const RenderStage& stage);
nlohmann::json run_render(const Context& context, RunDirectory& run, const Scene& scene, const RenderStage& stage);

}  // namespace pliant
