#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "segmentation/model_interfaces/detector.h"
#include "segmentation/model_interfaces/inpainter.h"
#include "segmentation/model_interfaces/promptable_segmenter.h"
#include "segmentation/model_interfaces/tagger.h"
#include "segmentation/model_interfaces/tracker.h"
#include "segmentation/models/neural_module.h"

namespace pliant {

/// Files of the networks that a person gives; empty = none.
struct ModelChoice {
  std::string detector, tagger, tracker, inpainter;
  std::string segmenter;                  ///< one file, or "ENCODER,DECODER"
  std::vector<std::string> vocabularies;  ///< tag list, names of classes, vocabulary of a text encoder; else the file
                                          ///< beside the network that ends in .txt
  bool trust_torchscript = false;

  bool empty() const { return files().empty(); }
  /// Number of networks, each of which gets that share of the memory.
  int networks() const;
  /// Everything that is read, for hashes.
  std::vector<std::filesystem::path> files() const;
};

// Networks of a choice, null where none is given.  What a file is follows from what its export script wrote into it,
// YOLOX and files of others from their outline; a file of another kind is an Error{kUsage} that names the option for
// it.
std::unique_ptr<Detector> make_detector(const ModelChoice& choice);
std::unique_ptr<Tagger> make_tagger(const ModelChoice& choice);
std::unique_ptr<PromptableSegmenter> make_segmenter(const ModelChoice& choice);
std::unique_ptr<Tracker> make_tracker(const ModelChoice& choice);
std::unique_ptr<Inpainter> make_inpainter(const ModelChoice& choice);

}  // namespace pliant
