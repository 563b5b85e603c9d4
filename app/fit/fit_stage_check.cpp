#include "app/fit/fit_stage.h"
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
  return {{stage.typed("video-mask"), !stage.video_mask().empty()},
          {stage.typed("refine-camera"), stage.refine_camera},
          {stage.typed("video-first"), stage.first > 0},
          {stage.typed("video-last"), stage.last > 0},
          {stage.typed("compare-fps"), stage.compare_fps > 0},
          {stage.typed("start"), stage.from >= 0},
          {stage.typed("end"), stage.until > 0},
          {stage.typed("periods"), stage.periods != FitStage().periods},
          {stage.typed("points"), stage.points != FitStage().points}};
}

/// What only a fit to pictures uses, of a video or of a drawn motion.
std::vector<Choice> of_pictures(const FitStage& stage) {
  const CompareStage& c = stage.compare;
  std::vector<Choice> all = of_watching(stage);
  const std::vector<Choice> more = {{stage.typed("video"), !stage.video().empty()},
                                    {stage.typed("video-camera"), !stage.camera().empty()},
                                    {stage.typed("video-pose"), !stage.pose.empty()},
                                    {stage.typed("video-fps"), stage.fps > 0},
                                    {stage.typed("field"), !stage.field.empty()},
                                    {stage.typed("recipe"), stage.recipe != "search"},
                                    {stage.typed("loss"), !c.loss.empty()},
                                    {stage.typed("flow-weight"), c.flow_weight > 0},
                                    {stage.typed("fit-poisson"), c.poisson},
                                    {stage.typed("fit-density"), c.density},
                                    {stage.typed("guidance-cmd"), !c.guide.empty()},
                                    {stage.typed("video-model-cmd"), !stage.generate.command.empty()}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// What only a fit to markers uses.
std::vector<Choice> of_markers(const FitStage& stage) {
  const MarkerStage usual, &markers = stage.markers;
  return {{stage.typed("marker-axes"), markers.axes != usual.axes},
          {stage.typed("marker-units"), markers.units != usual.units},
          {stage.typed("marker-offset"), !markers.offset.empty()},
          {stage.typed("marker-reach"), markers.reach != usual.reach},
          {stage.typed("marker-rest"), markers.rest.has_value()},
          {stage.typed("marker-release"), markers.release.has_value()},
          {stage.typed("marker-window"), markers.window != usual.window},
          {stage.typed("marker-load"), !markers.interactions.empty()}};
}

/// What only gradients use.
std::vector<Choice> of_gradients(const FitStage& stage) {
  return {{stage.typed("gradient-window"), stage.compare.window.has_value()},
          {stage.typed("gradient-iterations"), stage.compare.iterations.has_value()}};
}

/// What only a loss of pictures uses.
std::vector<Choice> of_picture_loss(const FitStage& stage) {
  const CompareStage usual;
  return {{stage.typed("loss-lambda"), stage.compare.lambda != usual.lambda},
          {stage.typed("image-weight"), stage.compare.picture_weight.has_value()}};
}

/// What only a motion uses that is drawn for a program to judge, without a video.
std::vector<Choice> of_drawing(const FitStage& stage) {
  return {{stage.typed("guidance-frames"), stage.compare.guide_frames.has_value()},
          {stage.typed("guidance-load"), !stage.compare.load.empty()}};
}

std::vector<Choice> of_guide(const FitStage& stage) {
  const CompareStage usual;
  std::vector<Choice> all = {{stage.typed("guidance-weight"), stage.compare.guide_weight != usual.guide_weight},
                             {stage.typed("guidance-timeout"), stage.compare.guide_limit != usual.guide_limit}};
  const std::vector<Choice> more = of_drawing(stage);
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// What only a program uses that makes the video.
std::vector<Choice> of_generating(const FitStage& stage) {
  return {{stage.typed("video-model-frames"), stage.generate.frames != GenerateStage().frames},
          {stage.typed("video-model-prompt"), !stage.generate.prompt.empty()}};
}

/// What --initial-material says too.
std::vector<Choice> of_constants(const FitStage& stage) {
  return {{stage.typed("young"), stage.material.young.has_value()},
          {stage.typed("poisson"), stage.material.poisson.has_value()},
          {stage.typed("density"), stage.material.density.has_value()}};
}

std::vector<Choice> of_parts(const FitStage& stage) {
  return {{stage.typed("parts"), stage.parts != FitStage().parts},
          {stage.typed("part-labels"), !stage.part_labels.empty()}};
}

}  // namespace

FitStage with_recipe(FitStage stage) {
  const bool physdreamer = stage.physdreamer(), pictures = physdreamer || stage.kinematic();
  CompareStage& compare = stage.compare;
  if (stage.field.empty()) stage.field = physdreamer ? "triplanes" : "uniform";
  if (compare.loss.empty()) compare.loss = pictures ? "image" : "tracks";
  if (!compare.picture_weight) compare.picture_weight = pictures ? 1 : 10;
  if (!compare.window) compare.window = physdreamer ? 1 : 0;
  if (!compare.iterations)
    compare.iterations = stage.kinematic() ? 500 : stage.distilled() ? 50 : stage.released_code() ? 200 : 100;
  if (!compare.guide_frames) compare.guide_frames = stage.distilled() ? 16 : 14;
  return stage;
}

double fitted_periods(const FitStage& stage) {
  if (stage.periods == "all") return INFINITY;
  const double count = parse_numbers(stage.typed("periods"), stage.periods, 1)[0];
  if (!(count >= 1))
    throw usage_error("fit", stage.typed("periods"), "is " + stage.periods, "give at least 1, or 'all'");
  return count;
}

std::string FitStage::typed(const std::string& option) const {
  return "--" + (brief_options().count(option) ? "" : prefix) + option;
}

void check_no_fit_stage(const FitStage& stage, const std::string& where, const std::string& advice) {
  refuse({{stage.typed("markers"), !stage.markers.file.empty()},
          {stage.typed("released-fields"), stage.released_young.has_value()},
          {stage.typed("initial-material"), !stage.initial_material.empty()}},
         where, advice);
  for (const auto& of : {of_pictures, of_markers, of_gradients, of_picture_loss, of_guide, of_generating, of_parts})
    refuse(of(stage), where, advice);
}

void check_fit_stage(const FitStage& stage, bool with_video) {
  const CompareStage& c = stage.compare;
  const bool has_video = with_video && !stage.distilled();  // which leaves the scene's alone
  const bool markers = !stage.markers.file.empty(), guided = !c.guide.empty();
  if (markers)
    refuse(of_pictures(stage), "with " + stage.typed("markers"), "leave it out, or fit to a video");
  else
    refuse(of_markers(stage), "without markers", "add " + stage.typed("markers") + " FILE");
  if (stage.released_young) {
    refuse({{stage.typed("markers"), markers},
            {stage.typed("young"), stage.material.young.has_value()},
            {stage.typed("initial-material"), !stage.initial_material.empty()},
            {stage.typed("solver"), stage.solver != FitStage().solver}},
           "with " + stage.typed("released-fields"), "leave one of them out");
    refuse(of_pictures(stage), "with " + stage.typed("released-fields") + ", which are used unchanged",
           "leave it out, or fit to the video");
  }
  const bool recipe = stage.recipe != FitStage().recipe;
  const std::string with_recipe_text = "with " + stage.typed("recipe") + " " + stage.recipe;
  fitted_periods(stage);
  if (recipe)
    refuse({{stage.typed("periods"), stage.periods != FitStage().periods}},
           with_recipe_text + ", which does not look for periods", "leave it out, or use " + stage.typed("end"));
  if (recipe && !stage.distilled())
    refuse({{stage.typed("guidance-cmd"), guided}}, with_recipe_text + ", which only compares with the video",
           "leave one of them out");
  if (stage.kinematic()) {
    refuse(of_constants(stage), with_recipe_text + ", which has no physics", "leave it out, or use another recipe");
    refuse({{stage.typed("field"), !stage.field.empty()},
            {stage.typed("fit-poisson"), c.poisson},
            {stage.typed("fit-density"), c.density},
            {stage.typed("gradient-window"), c.window.has_value()},
            {stage.typed("initial-material"), !stage.initial_material.empty()},
            {stage.typed("solver"), stage.solver != FitStage().solver},
            {stage.typed("start"), stage.from >= 0}},
           with_recipe_text + ", which has no physics", "leave it out, or use another recipe");
  }
  if (!stage.initial_material.empty())
    refuse(of_constants(stage), "with " + stage.typed("initial-material"), "leave one of them out");
  if (stage.distilled()) {
    if (!guided)
      throw usage_error("fit", stage.typed("recipe") + " " + stage.recipe, "lets a program judge the motion",
                        "add " + stage.typed("guidance-cmd") + " CMD");
    refuse({{stage.typed("video"), !stage.video().empty()},
            {stage.typed("video-model-cmd"), !stage.generate.command.empty()}},
           with_recipe_text + ", which uses no video", "leave it out, or leave the recipe out");
    const bool network = stage.recipe == "dreamphysics" && stage.field == "kan";
    refuse({{stage.typed("field"), !stage.field.empty() && !network},
            {stage.typed("fit-poisson"), c.poisson},
            {stage.typed("fit-density"), c.density},
            {stage.typed("gradient-window"), c.window.has_value()},
            {stage.typed("guidance-weight"), c.guide_weight != CompareStage().guide_weight}},
           with_recipe_text + ", whose constants vary from particle to particle by a rule of its own",
           "leave it out, or leave the recipe out");
  }
  if (stage.released_code())
    refuse({{stage.typed("field"), !stage.field.empty()},
            {stage.typed("loss"), !c.loss.empty()},
            {stage.typed("loss-lambda"), c.lambda != CompareStage().lambda},
            {stage.typed("image-weight"), c.picture_weight.has_value()},
            {stage.typed("flow-weight"), c.flow_weight > 0},
            {stage.typed("fit-poisson"), c.poisson},
            {stage.typed("fit-density"), c.density}},
           with_recipe_text + ", whose fields and loss are those of the released code",
           "leave it out, or use --recipe physdreamer");
  const FitStage chosen = with_recipe(stage);
  const std::string& loss = chosen.compare.loss;
  const bool by_gradients = recipe || chosen.field == "triplanes" || chosen.field == "kan" || loss != "tracks" ||
                            c.flow_weight > 0 || c.poisson || c.density || guided;
  const std::string pictures = "add " + stage.typed("loss") + " image or both";
  if (has_video && chosen.field == "uniform")
    refuse({{stage.typed("fit-density"), c.density}},
           "with a uniform field: a free motion determines E / density, not the density",
           "add " + stage.typed("field") + " parts or smooth, or leave it out");
  if (!by_gradients)
    refuse(of_gradients(stage), "without gradients: the tracked points are fitted by Gauss-Newton",
           pictures + ", " + stage.typed("flow-weight") + ", " + stage.typed("field") + " triplanes or kan, or " +
               stage.typed("recipe") + " physdreamer");
  if (loss == "tracks") refuse(of_picture_loss(stage), "without an image loss", pictures);
  if (!guided) refuse(of_guide(stage), "without a guidance program", "add " + stage.typed("guidance-cmd") + " CMD");
  if (guided && has_video) refuse(of_drawing(stage), "with a video, which sets what is rendered", "leave it out");
  if (guided && !has_video) {
    refuse(of_watching(stage), "without a video", "leave it out, or add --video FILE");
    refuse({{stage.typed("video-camera") + " " + kFindCamera, stage.camera() == kFindCamera},
            {"a second " + stage.typed("video-camera"), stage.cameras.size() > 1}},
           "without a video", "give the name of one camera, or leave it out");
    refuse({{stage.typed("loss"), !c.loss.empty()}, {stage.typed("flow-weight"), c.flow_weight > 0}}, "without a video",
           "give --video FILE, or leave it out");
  }
  if (stage.generate.command.empty())
    refuse(of_generating(stage), "without a program that generates the video",
           "add " + stage.typed("video-model-cmd") + " CMD");
  else
    refuse({{stage.typed("video"), !stage.video().empty()},
            {stage.typed("video-camera") + " " + kFindCamera, stage.camera() == kFindCamera},
            {stage.typed("video-first"), stage.first > 0},
            {stage.typed("video-last"), stage.last > 0},
            {stage.typed("refine-camera"), stage.refine_camera},
            {stage.typed("compare-fps"), stage.compare_fps > 0}},
           "with " + stage.typed("video-model-cmd") + ", whose video is used unchanged", "leave it out");
  if (chosen.field != "parts")
    refuse(of_parts(stage), "without parts", "add " + stage.typed("field") + " parts");
  else if (!stage.part_labels.empty())
    refuse({{stage.typed("parts"), stage.parts != FitStage().parts}},
           "with " + stage.typed("part-labels") + ", which set their number", "leave it out");
}

}  // namespace pliant
