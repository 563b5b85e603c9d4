#include "app/evaluate/evaluate.h"

#include <fmt/format.h>

#include <cstdio>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands/evaluate_tables.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {

namespace {

void add_score(CLI::App& command, SegmentationScore& score) {
  command
      .add_option(
          "--band", score.band,
          fmt::format("Width of the contour band of boundary_miou [px]; 0 = 2 % of the diagonal [{}]", score.band))
      ->check(CLI::Range(0, 1000))
      ->option_text("N");
  command
      .add_option("--match", score.match,
                  fmt::format("How IDs are matched: by name, else by ID (auto); id; overlap [{}]", score.match))
      ->check(CLI::IsMember({"auto", "id", "overlap"}))
      ->option_text("auto|id|overlap");
  command.add_flag("--common", score.common, "Skip images without a prediction instead of scoring them 0");
}

void add_interval(CLI::App& command, ClipPart& score) {
  command.add_option("--fps", score.fps, "Frames per second of image folders")
      ->check(CLI::PositiveNumber)
      ->option_text("X");
  command
      .add_option("--from", score.from, fmt::format("Start of the compared interval of videos [s] [{}]", score.from))
      ->check(CLI::NonNegativeNumber)
      ->option_text("X");
  command
      .add_option("--until", score.until, "End of the compared interval of videos [s] (default: the end of the clip)")
      ->check(CLI::PositiveNumber)
      ->option_text("X");
}

void add_score(CLI::App& command, MotionScore& score) {
  add_interval(command, score);
  command
      .add_option("--free-from", score.free_from,
                  "Time after which no force acts [s], of videos counted from --from (default: of trajectories the end "
                  "of the loads in interactions.json, else where the motion is largest)")
      ->check(CLI::NonNegativeNumber)
      ->option_text("X");
}

void warn_of(const nlohmann::json& result, const Context& context) {
  for (const nlohmann::json& warning : result.value("warnings", nlohmann::json::array()))
    context.progress.warn(warning.get<std::string>());
}

void add_slices(CLI::App& evaluate, Program& program) {
  CLI::App* sub = evaluate.add_subcommand("slices", "Space-time slices of a reference video and others, side by side");
  struct Files {
    std::string reference;
    std::vector<std::string> clips;
    SliceScore score;
  };
  auto files = std::make_shared<Files>();
  sub->add_option("REFERENCE", files->reference, "Video or folder of frames")->required();
  sub->add_option("CLIPS", files->clips, "Videos or folders to compare with it")->required();
  add_interval(*sub, files->score);
  sub->add_option("--row", files->score.row, "Pixel row (default: the one that changes most)")->option_text("N");
  sub->add_option("--column", files->score.column, "Pixel column (default: the one that changes most)")
      ->option_text("N");
  add_out(*sub, program, "Image to write (default: slices.png)")->option_text("FILE");
  add_common(*sub, program);
  sub->callback([files, &program] {
    program.action = [files, &program](Context& context) {
      const std::vector<std::filesystem::path> clips(files->clips.begin(), files->clips.end());
      nlohmann::json result =
          evaluate_slices(files->reference, clips, files->score, program.out.empty() ? "slices.png" : program.out);
      warn_of(result, context);
      if (!program.json) std::printf("%s\n", result.dump(2).c_str());
      return result;
    };
  });
}

}  // namespace

void add_evaluate(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("evaluate", "Compare results with ground truth");
  command->require_subcommand(1);
  const auto score = std::make_shared<SegmentationScore>();
  const auto motion = std::make_shared<MotionScore>();
  using Path = std::filesystem::path;
  struct Kind {
    const char* name;
    const char* description;
    std::function<nlohmann::json(const Path&, const Path&)> evaluate;
  };
  for (const Kind& kind :
       {Kind{"images", "PSNR, SSIM and MS-SSIM of two folders of images", evaluate_images},
        Kind{"segmentation", "mIoU of two folders of ID masks, or of two labelings",
             [score](const Path&a, const Path&b) { return evaluate_segmentation(a, b, *score); }},
        Kind{"lerf-mask", "mIoU and boundary mIoU of a scene of LERF-Mask, strict and as published",
             evaluate_lerf_mask},
        Kind{"nvos", "mIoU and accuracy over the scenes of NVOS", evaluate_nvos},
        Kind{"repair", "Filled hole of a run directory against the true background of its demo scene", evaluate_repair},
        Kind{"trajectory", "Position error, tip motion and frequency of two trajectory.h5", evaluate_trajectory},
        Kind{"motion", "Frequency, damping, amplitude and optical flow of two videos, or of two trajectory.h5",
             [motion](const Path&a, const Path&b) { return evaluate_motion(a, b, *motion); }},
        Kind{"material", "log10 error of two material fields", evaluate_material}}) {
    CLI::App* sub = command->add_subcommand(kind.name, kind.description);
    auto pred = std::make_shared<std::string>(), truth = std::make_shared<std::string>();
    auto asserts = std::make_shared<std::vector<std::string>>();
    sub->add_option("PRED", *pred, "Computed result")->required();
    sub->add_option("TRUTH", *truth, "Ground truth")->required();
    repeatable(sub->add_option("--assert", *asserts, "Fail unless this holds, for example psnr>=30; repeatable"))
        ->option_text("CONDITION");
    if (kind.name == std::string("segmentation")) add_score(*sub, *score);
    if (kind.name == std::string("motion")) add_score(*sub, *motion);
    add_out(*sub, program, "Also write the JSON to this file")->option_text("FILE");
    add_common(*sub, program);
    sub->callback([=, &program] {
      program.action = [=, &program](Context& context) {
        nlohmann::json result = kind.evaluate(*pred, *truth);
        warn_of(result, context);
        if (!program.out.empty()) write_text(program.out, result.dump(2) + "\n");
        if (!program.json) std::printf("%s\n", result.dump(2).c_str());
        const std::vector<std::string> failed = assert_metrics(result, *asserts);
        if (!failed.empty()) {
          if (program.json) std::printf("%s\n", result.dump(2).c_str());
          std::string all;
          for (const std::string& sentence : failed) all += (all.empty() ? "" : "; ") + sentence;
          throw Error(Failure::kInput, "evaluate", kind.name, all, "");
        }
        return result;
      };
    });
  }
  add_slices(*command, program);
  add_evaluate_suite(*command, program);
  add_evaluate_tables(*command, program);
}

}  // namespace pliant
