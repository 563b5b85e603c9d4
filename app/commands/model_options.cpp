#include "app/commands/stage_options.h"

namespace pliant {

void add_model_options(CLI::App& command, ModelChoice& models) {
  const auto network = [&](const std::string& name, std::string& file, const std::string& description) {
    command.add_option(name, file, description)->type_name("FILE")->group("Networks (ONNX or TorchScript)");
  };
  network("--detector", models.detector, "Names to boxes: YOLOX, Grounding DINO");
  network("--tagger", models.tagger, "Picture to names: RAM");
  network("--segmenter", models.segmenter, "Boxes and points to masks: the SAM family, one file or ENCODER,DECODER");
  network("--tracker", models.tracker, "Masks through a sequence: XMem, DEVA");
  network("--inpainter", models.inpainter, "Fills holes: LaMa");
  command.add_option("--vocabulary", models.vocabularies, "Tag list or vocabulary of a text encoder (default: NETWORK.txt beside the network); can be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("FILE")
      ->group("Networks (ONNX or TorchScript)");
  command.add_flag("--trust-torchscript", models.trust_torchscript, "Run TorchScript files: they are programs and may do anything that you may")
      ->group("Networks (ONNX or TorchScript)");
}

}  // namespace pliant
