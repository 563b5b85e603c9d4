#include "app/pipeline/fit_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

struct Choice {
  std::string option;
  bool made;  ///< differently from the default
};

void refuse(const std::vector<Choice>& choices, const std::string& where, const std::string& advice) {
  for (const Choice& choice : choices)
    if (choice.made) throw usage_error("fit", choice.option, "does nothing " + where, advice);
}

/// What only a fit to a video uses that is there already.
std::vector<Choice> of_watching(const FitStage& stage) {
  return {{"--video-mask", !stage.video_mask.empty()}, {"--refine-camera", stage.refine_camera},
          {"--video-first", stage.first > 0},          {"--video-last", stage.last > 0},
          {stage.typed("compare-fps"), stage.compare_fps > 0}, {stage.typed("from"), stage.from >= 0},
          {stage.typed("until"), stage.until > 0},     {stage.typed("points"), stage.points != FitStage().points}};
}

/// What only a fit to pictures uses, of a video or of a drawn motion.
std::vector<Choice> of_pictures(const FitStage& stage) {
  const CompareStage& c = stage.compare;
  std::vector<Choice> all = of_watching(stage);
  const std::vector<Choice> more = {{"--video", !stage.video.empty()},
                                    {stage.prefix.empty() ? "--camera" : "--video-camera", !stage.camera.empty()},
                                    {"--video-pose", !stage.pose.empty()},
                                    {"--video-fps", stage.fps > 0},
                                    {stage.typed("field"), stage.field != "uniform"},
                                    {stage.typed("recipe"), stage.recipe != "search"},
                                    {stage.typed("loss"), c.loss != "tracks"},
                                    {stage.typed("flow-weight"), c.flow_weight > 0},
                                    {"--fit-poisson", c.poisson},
                                    {"--guide-with", !c.guide.empty()},
                                    {"--generate-with", !stage.generate.command.empty()}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::vector<Choice> of_markers(const MarkerStage& markers) {
  const MarkerStage usual;
  return {{"--marker-axes", markers.axes != usual.axes},   {"--marker-units", markers.units != usual.units},
          {"--marker-offset", !markers.offset.empty()},    {"--marker-reach", markers.reach != usual.reach},
          {"--marker-rest", markers.rest.has_value()},     {"--marker-release", markers.release.has_value()},
          {"--marker-window", markers.window != usual.window}, {"--marker-load", !markers.interactions.empty()}};
}

}  // namespace

void check_fit_stage(const FitStage& stage, bool has_video) {
  const CompareStage &c = stage.compare, usual;
  const bool markers = !stage.markers.file.empty(), guided = !c.guide.empty();
  if (markers) refuse(of_pictures(stage), "with --markers", "leave it out, or fit to a video");
  else refuse(of_markers(stage.markers), "without markers", "add --markers FILE");
  if (stage.released_young) {
    refuse({{"--markers", markers}}, "with --released-fields", "leave one of them out");
    refuse(of_pictures(stage), "with --released-fields, which are taken as they are", "leave it out, or fit to the video");
  }
  const bool recipe = stage.recipe == "physdreamer";
  if (recipe) refuse({{"--guide-with", guided}}, "with " + stage.typed("recipe") + " physdreamer, which compares with the video alone", "leave one of them out");
  const bool by_gradients = recipe || stage.field == "triplanes" || c.loss != "tracks" || c.flow_weight > 0 || c.poisson || guided;
  const std::string pictures = "add " + stage.typed("loss") + " pictures or both";
  if (!by_gradients)
    refuse({{stage.typed("gradient-window"), c.window != usual.window}, {stage.typed("gradient-iterations"), c.iterations != usual.iterations}},
           "where no gradients run: the points that are followed are fitted by Gauss-Newton",
           pictures + ", " + stage.typed("flow-weight") + ", " + stage.typed("field") + " triplanes or " + stage.typed("recipe") + " physdreamer");
  if (c.loss == "tracks")
    refuse({{stage.typed("loss-lambda"), c.lambda != usual.lambda}, {stage.typed("picture-weight"), c.picture_weight != usual.picture_weight}}, "without pictures", pictures);
  if (!guided)
    refuse({{"--guide-weight", c.guide_weight != usual.guide_weight}, {"--guide-limit", c.guide_limit != usual.guide_limit},
            {"--guide-frames", c.guide_frames != usual.guide_frames}, {"--guide-load", !c.load.empty()}},
           "without a program that judges", "add --guide-with CMD");
  if (guided && has_video)
    refuse({{"--guide-frames", c.guide_frames != usual.guide_frames}, {"--guide-load", !c.load.empty()}}, "beside a video, which says what is drawn", "leave it out");
  if (guided && !has_video) refuse(of_watching(stage), "without a video", "leave it out, or add --video FILE");
  const GenerateStage none;
  if (stage.generate.command.empty())
    refuse({{"--generate-frames", stage.generate.frames != none.frames}, {"--generate-prompt", !stage.generate.prompt.empty()}}, "without a program that makes the video",
           "add --generate-with CMD");
  else
    refuse({{"--video-first", stage.first > 0}, {"--video-last", stage.last > 0}, {"--refine-camera", stage.refine_camera}, {stage.typed("compare-fps"), stage.compare_fps > 0}},
           "with --generate-with, whose video is used as it is made", "leave it out");
  if (stage.field != "parts")
    refuse({{stage.typed("parts"), stage.parts != FitStage().parts}, {stage.typed("part-labels"), !stage.part_labels.empty()}}, "without parts",
           "add " + stage.typed("field") + " parts");
  else if (!stage.part_labels.empty())
    refuse({{stage.typed("parts"), stage.parts != FitStage().parts}}, "with " + stage.typed("part-labels") + ", which say how many there are", "leave it out");
}

}  // namespace pliant
