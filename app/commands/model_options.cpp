#include "app/commands/stage_options.h"

namespace pliant {
namespace {

const char* const kGroup = "Networks (ONNX or TorchScript)";

void add_network(CLI::App& command, const std::string& name, std::string& file, const std::string& description) {
  command.add_option(name, file, description)->type_name("FILE")->group(kGroup);
}

}  // namespace

void add_labelling_networks(CLI::App& command, ModelChoice& models) {
  add_network(command, "--detector", models.detector, "Names to boxes: YOLOX, Grounding DINO");
  add_network(command, "--tagger", models.tagger, "Picture to names: RAM");
  add_network(command, "--segmenter", models.segmenter,
              "Boxes and points to masks: the SAM family, one file or ENCODER,DECODER");
  add_network(command, "--tracker", models.tracker, "Masks through a sequence, with --track: XMem, DEVA");
  command
      .add_option("--vocabulary", models.vocabularies,
                  "Tag list or vocabulary of a text encoder (default: NETWORK.txt beside the network); can be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("FILE")
      ->group(kGroup);
}

void add_inpainter(CLI::App& command, ModelChoice& models) {
  add_network(command, "--inpainter", models.inpainter, "Fills holes: LaMa");
}

void add_trust(CLI::App& command, std::vector<ModelChoice*> choices) {
  command
      .add_flag_callback(
          "--trust-torchscript",
          [choices] {
            for (ModelChoice* models : choices) models->trust_torchscript = true;
          },
          "Run TorchScript files: they are programs and may do anything that you may")
      ->group(kGroup);
}

}  // namespace pliant
