#include "app/pipeline/fit_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

struct Choice {
  const char* option;
  bool made;  ///< differently from the default
};

void refuse(const std::vector<Choice>& choices, const std::string& where, const std::string& advice) {
  for (const Choice& choice : choices)
    if (choice.made) throw usage_error("fit", choice.option, "does nothing " + where, advice);
}

/// What only a fit to a video uses.
std::vector<Choice> of_videos(const FitStage& stage) {
  const CompareStage& c = stage.compare;
  return {{"--camera", !stage.camera.empty()},  {"--video-pose", !stage.pose.empty()},   {"--refine-camera", stage.refine_camera}, {"--video-mask", !stage.video_mask.empty()},
          {"--video-first", stage.first > 0},   {"--video-last", stage.last > 0},        {"--from", stage.from >= 0},
          {"--until", stage.until > 0},         {"--field", stage.field != "uniform"}, {"--recipe", stage.recipe != "search"},   {"--loss", c.loss != "tracks"},
          {"--flow-weight", c.flow_weight > 0}, {"--fit-poisson", c.poisson},            {"--guide-with", !c.guide.empty()},
          {"--generate-with", !stage.generate.command.empty()}};
}

}  // namespace

void check_fit_stage(const FitStage& stage, bool has_video) {
  const CompareStage &c = stage.compare, usual;
  const bool markers = !stage.markers.file.empty(), guided = !c.guide.empty();
  if (markers) refuse(of_videos(stage), "with --markers", "leave it out, or fit to a video");
  if (stage.released_young) {
    refuse({{"--markers", markers}}, "with --released-fields", "leave one of them out");
    refuse(of_videos(stage), "with --released-fields, which are taken as they are", "leave it out, or fit to the video");
  }
  const bool recipe = stage.recipe == "physdreamer";
  if (recipe) refuse({{"--guide-with", guided}}, "with --recipe physdreamer, which compares with the video alone", "leave one of them out");
  const bool by_gradients = recipe || stage.field == "triplanes" || c.loss != "tracks" || c.flow_weight > 0 || c.poisson || guided;
  if (!by_gradients)
    refuse({{"--gradient-window", c.window != usual.window}, {"--gradient-iterations", c.iterations != usual.iterations}},
           "where no gradients run: the points that are followed are fitted by Gauss-Newton", "add --loss pictures or both, --flow-weight, --field triplanes or --recipe physdreamer");
  if (c.loss == "tracks")
    refuse({{"--loss-lambda", c.lambda != usual.lambda}, {"--picture-weight", c.picture_weight != usual.picture_weight}}, "without pictures", "add --loss pictures or both");
  if (!guided)
    refuse({{"--guide-weight", c.guide_weight != usual.guide_weight}, {"--guide-limit", c.guide_limit != usual.guide_limit},
            {"--guide-frames", c.guide_frames != usual.guide_frames}, {"--guide-load", !c.load.empty()}},
           "without a program that judges", "add --guide-with CMD");
  if (guided && has_video)
    refuse({{"--guide-frames", c.guide_frames != usual.guide_frames}, {"--guide-load", !c.load.empty()}}, "beside a video, which says what is drawn", "leave it out");
  const GenerateStage none;
  if (stage.generate.command.empty())
    refuse({{"--generate-frames", stage.generate.frames != none.frames}, {"--generate-prompt", !stage.generate.prompt.empty()}}, "without a program that makes the video",
           "add --generate-with CMD");
  else
    refuse({{"--video-first", stage.first > 0}, {"--video-last", stage.last > 0}}, "with --generate-with, whose video is used whole", "leave it out");
  if (stage.field != "parts")
    refuse({{"--parts", stage.parts != FitStage().parts}, {"--part-labels", !stage.part_labels.empty()}}, "without parts", "add --field parts");
  else if (!stage.part_labels.empty())
    refuse({{"--parts", stage.parts != FitStage().parts}}, "with --part-labels, which say how many there are", "leave it out");
}

}  // namespace pliant
