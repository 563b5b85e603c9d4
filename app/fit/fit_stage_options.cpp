#include "app/fit/fit_stage.h"
#include "app/simulate/simulate_stage.h"

namespace pliant {
namespace {

std::vector<Option> video_options(FitStage& stage) {
  return {
      {.name = "video",
       .field = &stage.videos,
       .help = "Video of the moving object (default: scene.json's); repeatable",
       .value = "FILE",
       .recorded = Recorded::kElsewhere},
      {.name = "video-camera",
       .field = &stage.cameras,
       .help = "Camera of the video, or 'find'; once per video",
       .value = "NAME",
       .formerly = "camera"},
      {.name = "video-mask",
       .field = &stage.masks,
       .help = "Image, folder or video: dark regions, such as a hand, are ignored; 'none' for a video without a mask",
       .value = "FILE|none",
       .choices = {"none"},
       .exists = true,
       .recorded = Recorded::kElsewhere},
      {.name = "video-pose",
       .field = &stage.pose,
       .help = "File with the video's camera (transforms.json, cameras.json, COLMAP)",
       .value = "FILE",
       .exists = true,
       .recorded = Recorded::kContents},
      {.name = "refine-camera",
       .field = &stage.refine_camera,
       .help = "Refine the video's camera until the rendered scene matches the first frame"},
      {.name = "video-first", .field = &stage.first, .help = "Start of the used part of the video [s]", .low = 0},
      {.name = "video-last",
       .field = &stage.last,
       .help = "End of the used part of the video [s]; 0 = its end",
       .low = 0},
      {.name = "video-fps",
       .field = &stage.fps,
       .help = "Frames per second of a folder of frames, or to override the file's; 0 = the file's",
       .low = 0},
      {.name = "compare-fps",
       .field = &stage.compare_fps,
       .help = "Frames per second for the comparison; 0 = those of the first video",
       .low = 0,
       .high = 1000},
  };
}

std::vector<Option> compare_options(CompareStage& stage) {
  const char* const kGroup = "Loss of gradient-based fits";
  return {
      {.name = "loss",
       .field = &stage.loss,
       .help = "tracks: tracked points; image: rendered frames against the video; both (default: tracks; physdreamer: "
               "image)",
       .group = kGroup,
       .choices = {"tracks", "image", "both"}},
      {.name = "loss-lambda",
       .field = &stage.lambda,
       .help = "Weight of L1 in the image loss; D-SSIM has the rest",
       .group = kGroup,
       .low = 0,
       .high = 1},
      {.name = "image-weight",
       .field = &stage.picture_weight,
       .help = "Weight of the image loss against the squared track error [px^2] (default: 10; physdreamer: 1)",
       .group = kGroup,
       .positive = true,
       .formerly = "picture-weight"},
      {.name = "flow-weight",
       .field = &stage.flow_weight,
       .help = "Weight of the squared optical-flow error against the squared track error; 0 = none",
       .group = kGroup,
       .low = 0},
      {.name = "gradient-window",
       .field = &stage.window,
       .help = "Frames through which the gradient of E is backpropagated; 0 = all (default: 0; physdreamer: 1)",
       .group = kGroup,
       .low = 0},
      {.name = "gradient-iterations",
       .field = &stage.iterations,
       .help = "Iterations (default: 100; physdreamer-code: 200, 300 for v0; physics3d, dreamphysics: 50; "
               "dreamgaussian4d: 500)",
       .group = kGroup,
       .low = 1,
       .high = 100000},
      {.name = "fit-poisson",
       .field = &stage.poisson,
       .help = "Also fit a uniform Poisson's ratio, by gradients",
       .group = kGroup},
  };
}

std::vector<Option> guidance_options(CompareStage& stage) {
  const char* const kGroup = "Guidance model for the rendered motion";
  return {
      {.name = "guidance-cmd",
       .field = &stage.guide,
       .help = "Program that returns its loss gradient for each pixel, as in score distillation "
               "(fitting/observe/guidance.h)",
       .value = "CMD",
       .group = kGroup,
       .formerly = "guide-with"},
      {.name = "guidance-weight",
       .field = &stage.guide_weight,
       .help = "Weight of the guidance loss against the squared track error [px^2]",
       .group = kGroup,
       .positive = true,
       .formerly = "guide-weight"},
      {.name = "guidance-timeout",
       .field = &stage.guide_limit,
       .help = "Time limit for each answer of the program [s]; twice that for its startup",
       .group = kGroup,
       .positive = true,
       .formerly = "guide-limit",
       .recorded = Recorded::kElsewhere},
      {.name = "guidance-frames",
       .field = &stage.guide_frames,
       .help =
           "Without a video: frames of a clip, at --video-fps (default 24) (default: 14; physics3d, dreamphysics: 16)",
       .group = kGroup,
       .low = 2,
       .high = 1000,
       .formerly = "guide-frames"},
      {.name = "guidance-load",
       .field = &stage.load,
       .help = "Without a video: JSON array of interactions (default: one push scaled to the stiffness)",
       .value = "FILE",
       .group = kGroup,
       .exists = true,
       .formerly = "guide-load",
       .recorded = Recorded::kContents},
  };
}

std::vector<Option> generator_options(GenerateStage& stage) {
  const char* const kGroup = "Generated video";
  return {
      {.name = "video-model-cmd",
       .field = &stage.command,
       .help = "Program that generates the video from an image and a camera (fitting/observe/generate_video.h)",
       .value = "CMD",
       .group = kGroup,
       .formerly = "generate-with"},
      {.name = "video-model-frames",
       .field = &stage.frames,
       .help = "Frames to generate, at --video-fps (default 24)",
       .group = kGroup,
       .low = 2,
       .high = 1000,
       .formerly = "generate-frames"},
      {.name = "video-model-prompt",
       .field = &stage.prompt,
       .help = "Text prompt for the video model",
       .value = "TEXT",
       .group = kGroup,
       .formerly = "generate-prompt"},
  };
}

std::vector<Option> marker_options(MarkerStage& stage) {
  const char* const kGroup = "Markers instead of a video";
  return {
      {.name = "markers",
       .field = &stage.file,
       .help = "CSV of marker positions after release from rest: time, NAME_x, NAME_y, NAME_z",
       .value = "FILE",
       .group = kGroup,
       .recorded = Recorded::kContents},
      {.name = "marker-axes",
       .field = &stage.axes,
       .help = "Marker columns along the scene's x, y, z, with signs, such as y,-x,z",
       .value = "AXES",
       .group = kGroup},
      {.name = "marker-units",
       .field = &stage.units,
       .help = "Unit of columns whose names state none",
       .group = kGroup,
       .choices = {"metres", "scene"}},
      {.name = "marker-offset",
       .field = &stage.offset,
       .help = "Offset added to the markers, along the scene's axes, in --marker-units",
       .value = "x,y,z",
       .group = kGroup,
       .numbers = 3},
      {.name = "marker-reach",
       .field = &stage.reach,
       .help = "Maximum distance of used markers from the object's material [m]; 0 = two cells",
       .group = kGroup,
       .low = 0},
      {.name = "marker-rest",
       .field = &stage.rest,
       .help = "Start of rest before the release, in recording time [s] (default: the first row)",
       .group = kGroup},
      {.name = "marker-release",
       .field = &stage.release,
       .help = "Release time of the object, in recording time [s] (default: the onset of motion)",
       .group = kGroup},
      {.name = "marker-window",
       .field = &stage.window,
       .help = "Fitted time after the release [s]; as much again is held out for evaluation",
       .group = kGroup,
       .positive = true},
      {.name = "marker-load",
       .field = &stage.interactions,
       .help = "JSON array of interactions, with time 0 at the release (default: gravity)",
       .value = "FILE",
       .group = kGroup,
       .recorded = Recorded::kContents},
  };
}

}  // namespace

OptionTable options_of(FitStage& stage) {
  OptionTable table{"fit", video_options(stage)};
  const std::vector<Option> own = {
      {.name = "start",
       .field = &stage.from,
       .help = "Video time after which no external force acts [s]; -1 = estimated",
       .low = -1,
       .formerly = "from"},
      {.name = "end",
       .field = &stage.until,
       .help = "Video time after which frames are held out for evaluation [s]; 0 = all are fitted",
       .low = 0,
       .formerly = "until"},
      {.name = "periods",
       .field = &stage.periods,
       .help =
           "Periods of the dominant mode over which simulated motion is fitted, or 'all'; the search uses all frames",
       .value = "N|all"},
      {.name = "points",
       .field = &stage.points,
       .help = "Number of tracked points on the object's surface",
       .low = 20,
       .high = 20000},
      {.name = "field",
       .field = &stage.field,
       .help = "Stiffness model: uniform, parts, smooth, triplanes (with v0(x)), kan (default: uniform; physdreamer: "
               "triplanes)",
       .choices = {"uniform", "parts", "smooth", "triplanes", "kan"}},
      {.name = "recipe",
       .field = &stage.recipe,
       .help = "search: over stiffness, then Gauss-Newton; else the paper's method, re-created (see fitting/README.md)",
       .choices = {"search", "physdreamer", "physdreamer-code", "physics3d", "dreamphysics", "dreamgaussian4d"}},
      {.name = "parts",
       .field = &stage.parts,
       .help = "Patches of the object for --field parts; patches of similar appearance form one part",
       .low = 2,
       .high = 32},
      {.name = "part-labels",
       .field = &stage.part_labels,
       .help = "Labels of the scene's Gaussians (labels.h5, segmentation.h5) that define the parts instead",
       .value = "FILE",
       .exists = true,
       .recorded = Recorded::kContents},
      {.name = "released-fields",
       .field = &stage.released_young,
       .help =
           "Use the published fields of a PhysDreamer scene folder with this E0 [Pa in its cube] instead of fitting",
       .value = "E0",
       .low = 0},
      solver_option(stage.solver),
  };
  for (const std::vector<Option>& more :
       {own, material_options(stage.material), compare_options(stage.compare), guidance_options(stage.compare),
        generator_options(stage.generate), marker_options(stage.markers)})
    table.options.insert(table.options.end(), more.begin(), more.end());
  return table;
}

}  // namespace pliant
