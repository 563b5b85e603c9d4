#include "segmentation/models/make_models.h"

#include <map>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "segmentation/models/grounding_dino.h"
#include "segmentation/models/lama.h"
#include "segmentation/models/ram.h"
#include "segmentation/models/sam.h"
#include "segmentation/models/xmem.h"
#include "segmentation/models/yolox.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// The option for each kind of network.
const std::map<std::string, std::string> kOptionOf = {
    {"grounding-dino", "--detector"}, {"yolox", "--detector"},        {"ram", "--tagger"},   {"sam", "--segmenter"},
    {"sam-encoder", "--segmenter"},   {"sam-decoder", "--segmenter"}, {"xmem", "--tracker"}, {"lama", "--inpainter"}};

std::unique_ptr<NeuralModule> load(const ModelChoice& choice, const std::string& option, const fs::path& file) {
  if (!fs::is_regular_file(file))
    throw usage_error(option, file.string(), "is not a file", "give an ONNX or TorchScript file");
  const ModelFile model = read_model_file(file);
  const std::string kind = model.kind();
  if (const auto known = kOptionOf.find(kind); known != kOptionOf.end() && known->second != option)
    throw usage_error(option, file.string(), "holds '" + kind + "'", "give it as " + known->second);
  ModuleOptions options;
  options.option = option;
  options.trust_torchscript = choice.trust_torchscript;
  options.networks = choice.networks();
  if (YoloxDetector::recognises(model) && kOptionOf.at("yolox") != option)
    options.advice = "its inputs and outputs are those of YOLOX; give it as " + kOptionOf.at("yolox");
  if (option == "--tracker" && model.format == ModelFile::Format::kOnnx)
    throw usage_error(
        option, file.string(),
        "is ONNX, which has one network and no methods; it " + outline_text(model.graph) +
            "; the contract of a tracker has the methods encode_key (which takes frame), encode_value and segment",
        options.advice.empty() ? "give the TorchScript file of segmentation/models/export/export_xmem.py"
                               : options.advice);
  return std::make_unique<NeuralModule>(file, options);
}

std::vector<std::string> segmenter_files(const ModelChoice& choice) {
  if (choice.segmenter.empty()) return {};
  const size_t comma = choice.segmenter.find(',');
  if (comma == std::string::npos) return {choice.segmenter};
  return {choice.segmenter.substr(0, comma), choice.segmenter.substr(comma + 1)};
}

bool of_text_encoder(const fs::path& vocabulary) {
  const std::string text = read_text(vocabulary);
  return text.rfind("[CLS]", 0) == 0 || text.find("\n[CLS]") != std::string::npos;
}

/// The list of words that belongs to `network`: one that was given, or the file beside it.
fs::path vocabulary_of(const ModelChoice& choice, const fs::path& network, bool text_encoder) {
  for (const std::string& file : choice.vocabularies)
    if (of_text_encoder(file) == text_encoder) return file;
  const fs::path beside = fs::path(network).replace_extension(".txt");
  if (fs::exists(beside)) return beside;
  throw usage_error("--vocabulary", network.string(),
                    std::string("needs ") +
                        (text_encoder ? "the vocabulary of its text encoder (vocab.txt of BERT)" : "its tag list"),
                    "give --vocabulary FILE, or put it next to the network as " + beside.filename().string());
}

/// The names of YOLOX's classes in a list of words: one that was given, or the file beside it.  Empty = those of its
/// own file.  A list of another length is refused, unless a tagger may be meant.
std::vector<std::string> class_names(const ModelChoice& choice, const ModelFile& network) {
  const size_t classes = YoloxDetector::classes(network);
  std::vector<fs::path> lists(choice.vocabularies.begin(), choice.vocabularies.end());
  if (const fs::path beside = fs::path(choice.detector).replace_extension(".txt");
      lists.empty() && fs::is_regular_file(beside))
    lists.push_back(beside);
  std::string lengths;
  for (const fs::path& list : lists) {
    const std::vector<std::string> names = TagList::read(list).names;
    if (names.size() == classes) return names;
    lengths += (lengths.empty() ? "" : ", ") + list.string() + " has " + std::to_string(names.size()) + " names";
  }
  if (lists.empty() || !choice.tagger.empty()) return {};
  throw usage_error("--vocabulary", lists.front().string(),
                    "does not name the " + std::to_string(classes) + " classes of " + choice.detector + ": " + lengths,
                    "give a file with the name of each class, one per line, in the order of the network");
}

}  // namespace

int ModelChoice::networks() const {
  int count = static_cast<int>(segmenter_files(*this).size());
  for (const std::string& file : {detector, tagger, tracker, inpainter}) count += !file.empty();
  return count;
}

std::vector<fs::path> ModelChoice::files() const {
  std::set<fs::path> all;
  for (const std::string& file : {detector, tagger, tracker, inpainter}) all.insert(file);
  for (const std::string& file : segmenter_files(*this)) all.insert(file);
  for (const std::string& file : vocabularies) all.insert(file);
  for (const std::string& file : {detector, tagger})
    if (const fs::path beside = fs::path(file).replace_extension(".txt"); !file.empty() && fs::exists(beside))
      all.insert(beside);
  all.erase(fs::path());
  return {all.begin(), all.end()};
}

std::unique_ptr<Detector> make_detector(const ModelChoice& choice) {
  if (choice.detector.empty()) return nullptr;
  auto module = load(choice, "--detector", choice.detector);
  if (YoloxDetector::recognises(module->file())) {
    YoloxDetector::Options options;
    options.names = class_names(choice, module->file());
    return std::make_unique<YoloxDetector>(std::move(module), options);
  }
  if (module->file().format == ModelFile::Format::kOnnx && module->file().kind().empty() &&
      module->file().graph.inputs.size() < 7)
    throw input_error(choice.detector, "", "is neither YOLOX nor Grounding DINO",
                      "give one of them; scripts that export them are in segmentation/models/export");
  WordPiece tokenizer(vocabulary_of(choice, choice.detector, true));
  return std::make_unique<GroundingDino>(std::move(module), std::move(tokenizer), GroundingDino::Options());
}

std::unique_ptr<Tagger> make_tagger(const ModelChoice& choice) {
  if (choice.tagger.empty()) return nullptr;
  auto module = load(choice, "--tagger", choice.tagger);
  module->require(Ram::contract("K"), {});
  return std::make_unique<Ram>(std::move(module), TagList::read(vocabulary_of(choice, choice.tagger, false)));
}

std::unique_ptr<PromptableSegmenter> make_segmenter(const ModelChoice& choice) {
  const std::vector<std::string> files = segmenter_files(choice);
  if (files.empty()) return nullptr;
  auto encoder = load(choice, "--segmenter", files[0]);
  if (files.size() == 2) return std::make_unique<Sam>(std::move(encoder), load(choice, "--segmenter", files[1]));
  encoder->require(Sam::encoder_contract(encoder->file()), {});
  if (encoder->file().format == ModelFile::Format::kOnnx || encoder->file().kind() == "sam-encoder")
    throw usage_error("--segmenter", files[0], "is only an encoder", "give --segmenter ENCODER,DECODER");
  return std::make_unique<Sam>(std::move(encoder), nullptr);
}

std::unique_ptr<Tracker> make_tracker(const ModelChoice& choice) {
  if (choice.tracker.empty()) return nullptr;
  return std::make_unique<Xmem>(load(choice, "--tracker", choice.tracker), Xmem::Options());
}

std::unique_ptr<Inpainter> make_inpainter(const ModelChoice& choice) {
  if (choice.inpainter.empty()) return nullptr;
  return std::make_unique<Lama>(load(choice, "--inpainter", choice.inpainter), Lama::Options());
}

}  // namespace pliant
