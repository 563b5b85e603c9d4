#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/render/clip_shot.h"
#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// render: clip.mp4 from a fixed camera or along a path, clip_orbit.mp4 from one that turns around the object.
struct RenderStage {
  ShotOptions shot;
  bool recorded = false;  ///< recording.h5 of `simulate --recording` instead of the simulated motion
  bool orbit = true;
  bool turntable = false;          ///< clip_orbit.mp4 turns once, also where photos show one side only
  bool frames = false;             ///< also clip/000000.png ..., which lose nothing
  bool gif = false, webp = false;  ///< clip.mp4 again, as an animated image
  bool layer = false;              ///< the object alone, see ObjectLayer
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(RenderStage& stage);
/// Throws Error{kUsage} for options that exclude each other or that the scene does not allow, Error{kInput} for a
/// camera path that cannot be read; names of cameras are those of a scene that has some.
void check_render_stage(const Scene& scene, const RenderStage& stage);
StageInputs<RenderStage> inputs_of(const RunDirectory& run, const Scene& scene, const RenderStage& stage);
nlohmann::json run_render(const Context& context, RunDirectory& run, const Scene& scene, const RenderStage& stage);

}  // namespace pliant
