#include "app/fit/fit_stage.h"
#include "app/simulate/simulate_stage.h"

namespace pliant {
namespace {

/// Videos, their cameras and their masks, paired in the order in which they are given.
OptionParser paired(FitStage& stage, std::string FitStage::*first, std::string FitStage::Further::*more) {
  return [&stage, first, more](const std::vector<std::string>& words) {
    if (stage.further.size() + 1 < words.size()) stage.further.resize(words.size() - 1);
    stage.*first = words[0];
    for (size_t i = 1; i < words.size(); ++i) stage.further[i - 1].*more = words[i];
  };
}

std::vector<Option> video_options(FitStage& stage) {
  using Further = FitStage::Further;
  return {
      {.name = "video",
       .field = paired(stage, &FitStage::video, &Further::video),
       .help = "Video of the moving object (default: scene.json's); repeatable",
       .value = "FILE"},
      {.name = "video-camera",
       .field = paired(stage, &FitStage::camera, &Further::camera),
       .help = "Camera that took it, or 'find'; once for each video",
       .value = "NAME",
       .formerly = "camera"},
      {.name = "video-mask",
       .field = paired(stage, &FitStage::video_mask, &Further::mask),
       .help =
           "Image, folder or video: what is dark there, such as a hand, is not compared; 'none' for a video without",
       .value = "FILE|none",
       .choices = {"none"},
       .exists = true},
      {.name = "video-pose",
       .field = &stage.pose,
       .help = "File with the camera that took it (transforms.json, cameras.json, COLMAP)",
       .value = "FILE",
       .exists = true},
      {.name = "refine-camera",
       .field = &stage.refine_camera,
       .help = "Move that camera until the scene looks like the first frame"},
      {.name = "video-first",
       .field = &stage.first,
       .help = "Beginning of the part of the video that is used [s]",
       .low = 0},
      {.name = "video-last", .field = &stage.last, .help = "End of that part [s]; 0 = the end of the video", .low = 0},
      {.name = "video-fps",
       .field = &stage.fps,
       .help = "Frames per second of a folder of frames, or instead of the file's; 0 = the file's",
       .low = 0},
      {.name = "compare-fps",
       .field = &stage.compare_fps,
       .help = "Frames per second that are compared; 0 = those of the first video",
       .low = 0,
       .high = 1000},
  };
}

std::vector<Option> compare_options(CompareStage& stage) {
  const char* const kGroup = "What gradients compare";
  return {
      {.name = "loss",
       .field = &stage.loss,
       .help = "tracks: points that are followed; image: rendered frames against the video's; both",
       .group = kGroup,
       .choices = {"tracks", "image", "both"}},
      {.name = "loss-lambda",
       .field = &stage.lambda,
       .help = "Share of L1 in the image loss, the rest is D-SSIM",
       .group = kGroup,
       .low = 0,
       .high = 1},
      {.name = "image-weight",
       .field = &stage.picture_weight,
       .help = "Weight of the image loss, in square pixels of the tracks",
       .group = kGroup,
       .positive = true,
       .formerly = "picture-weight"},
      {.name = "flow-weight",
       .field = &stage.flow_weight,
       .help = "Weight of a square pixel of optical flow, in square pixels of the tracks; 0 = none",
       .group = kGroup,
       .low = 0},
      {.name = "gradient-window",
       .field = &stage.window,
       .help = "Frames through which gradients run back (PhysDreamer: 1); 0 = all",
       .group = kGroup,
       .low = 0},
      {.name = "gradient-iterations",
       .field = &stage.iterations,
       .help = "Iterations of Adam",
       .group = kGroup,
       .low = 1,
       .high = 100000},
      {.name = "fit-poisson",
       .field = &stage.poisson,
       .help = "Fit one Poisson's ratio too, by gradients",
       .group = kGroup},
  };
}

std::vector<Option> guidance_options(CompareStage& stage) {
  const char* const kGroup = "A guidance model that judges the rendered motion";
  return {
      {.name = "guidance-cmd",
       .field = &stage.guide,
       .help = "Program that gives the derivative of its loss by each pixel, as in score distillation "
               "(fitting/observe/guidance.h)",
       .value = "CMD",
       .group = kGroup,
       .formerly = "guide-with"},
      {.name = "guidance-weight",
       .field = &stage.guide_weight,
       .help = "Weight of its loss, in square pixels of the tracks",
       .group = kGroup,
       .positive = true,
       .formerly = "guide-weight"},
      {.name = "guidance-timeout",
       .field = &stage.guide_limit,
       .help = "Longest time for each answer, and half of that for its start [s]",
       .group = kGroup,
       .positive = true,
       .formerly = "guide-limit"},
      {.name = "guidance-frames",
       .field = &stage.guide_frames,
       .help = "Without a video: frames that are rendered, at --video-fps (default 24)",
       .group = kGroup,
       .low = 2,
       .high = 1000,
       .formerly = "guide-frames"},
      {.name = "guidance-load",
       .field = &stage.load,
       .help = "Without a video: JSON array of what acts (default: one push sized to the stiffness)",
       .value = "FILE",
       .group = kGroup,
       .exists = true,
       .formerly = "guide-load"},
  };
}

std::vector<Option> generator_options(GenerateStage& stage) {
  const char* const kGroup = "A generated video";
  return {
      {.name = "video-model-cmd",
       .field = &stage.command,
       .help = "Program that makes the video from an image and a camera (fitting/observe/generate_video.h)",
       .value = "CMD",
       .group = kGroup,
       .formerly = "generate-with"},
      {.name = "video-model-frames",
       .field = &stage.frames,
       .help = "Frames that it is asked for, at --video-fps (default 24)",
       .group = kGroup,
       .low = 2,
       .high = 1000,
       .formerly = "generate-frames"},
      {.name = "video-model-prompt",
       .field = &stage.prompt,
       .help = "Text prompt of the video model",
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
       .help = "CSV of marker positions after the object was let go from rest: time, NAME_x, NAME_y, NAME_z",
       .value = "FILE",
       .group = kGroup},
      {.name = "marker-axes",
       .field = &stage.axes,
       .help = "Columns along the scene's x, y, z, with signs, such as y,-x,z",
       .value = "AXES",
       .group = kGroup},
      {.name = "marker-units",
       .field = &stage.units,
       .help = "Unit of columns that name none",
       .group = kGroup,
       .choices = {"metres", "scene"}},
      {.name = "marker-offset",
       .field = &stage.offset,
       .help = "Added to the markers, along the scene's axes, in those units",
       .value = "x,y,z",
       .group = kGroup,
       .numbers = 3},
      {.name = "marker-reach",
       .field = &stage.reach,
       .help = "Markers farther from the object's material are left out [m]; 0 = two cells",
       .group = kGroup,
       .low = 0},
      {.name = "marker-rest",
       .field = &stage.rest,
       .help = "Time in the table at which the object is at rest [s] (default: its beginning)",
       .group = kGroup},
      {.name = "marker-release",
       .field = &stage.release,
       .help = "Time at which it is let go [s] (default: where motion sets in)",
       .group = kGroup},
      {.name = "marker-window",
       .field = &stage.window,
       .help = "Time after the release that the fit sees [s]; as much again judges it",
       .group = kGroup,
       .positive = true},
      {.name = "marker-load",
       .field = &stage.interactions,
       .help = "JSON array of what acts from the release on, its time 0 (default: gravity)",
       .value = "FILE",
       .group = kGroup},
  };
}

}  // namespace

OptionTable options_of(FitStage& stage) {
  OptionTable table{"fit", video_options(stage)};
  const std::vector<Option> own = {
      {.name = "start",
       .field = &stage.from,
       .help = "Time in the video from which on nothing pushes the object [s]; -1 = found",
       .low = -1,
       .formerly = "from"},
      {.name = "end",
       .field = &stage.until,
       .help = "Time in the video after which frames only judge the fit [s]; 0 = all are used",
       .low = 0,
       .formerly = "until"},
      {.name = "points",
       .field = &stage.points,
       .help = "Points of the object's surface that are followed",
       .low = 20,
       .high = 20000},
      {.name = "field",
       .field = &stage.field,
       .help =
           "How stiffness may vary: uniform, parts (by place and look), smooth, triplanes (by gradients, with v0(x))",
       .choices = {"uniform", "parts", "smooth", "triplanes"}},
      {.name = "recipe",
       .field = &stage.recipe,
       .help = "search: over stiffness, then Gauss-Newton; physdreamer: gradients alone, v0(x) first, then E(x) from "
               "the given E",
       .choices = {"search", "physdreamer"}},
      {.name = "parts",
       .field = &stage.parts,
       .help = "Patches of the object for --field parts; those that look alike are one part",
       .low = 2,
       .high = 32},
      {.name = "part-labels",
       .field = &stage.part_labels,
       .help = "Labels of the scene's Gaussians (labels.h5, segmentation.h5) that say the parts instead",
       .value = "FILE",
       .exists = true},
      {.name = "released-fields",
       .field = &stage.released_young,
       .help = "Take the fields in a PhysDreamer scene folder with this E0 [Pa in its cube] instead of fitting",
       .value = "E0",
       .low = 0},
  };
  for (const std::vector<Option>& more :
       {own, material_options(stage.material), compare_options(stage.compare), guidance_options(stage.compare),
        generator_options(stage.generate), marker_options(stage.markers)})
    table.options.insert(table.options.end(), more.begin(), more.end());
  return table;
}

}  // namespace pliant
