#include "app/segment/label_choice.h"

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// Whether the photos are to be labelled, or it is said how.
bool asks_for_labels(const LabelStage& label) {
  return label.photos || label.everything || label.track || !label.text.empty();
}

}  // namespace

bool has_gestures(const SegmentStage& stage) {
  return !stage.boxes.empty() || !stage.clicks.empty() || !stage.strokes.empty();
}

bool prompts_segmenter(const SegmentStage& stage) {
  const ModelChoice& models = stage.label.models;
  return has_gestures(stage) && !asks_for_labels(stage.label) && !models.segmenter.empty() && models.detector.empty() &&
         models.tagger.empty();
}

bool labels_photos(const SegmentStage& stage) {
  const ModelChoice& models = stage.label.models;
  return asks_for_labels(stage.label) || !models.detector.empty() || !models.tagger.empty() ||
         (!models.segmenter.empty() && !has_gestures(stage));
}

TypedOption labelling_option(const LabelStage& stage) {
  const ModelChoice& models = stage.models;
  if (stage.everything) return {"--everything", ""};
  if (!stage.text.empty()) return {"--text", stage.text};
  if (!models.detector.empty()) return {"--detector", models.detector};
  if (!models.tagger.empty()) return {"--tagger", models.tagger};
  if (stage.track) return {"--track", ""};
  if (!models.segmenter.empty()) return {"--segmenter", models.segmenter};
  return {"--label-photos", ""};
}

void check_networks(const SegmentStage& stage) {
  const LabelStage& label = stage.label;
  const ModelChoice& models = label.models;
  if (!models.tracker.empty() && !label.track)
    throw usage_error("--tracker", models.tracker, "was given without --track",
                      "add --track if the photos are in order, else leave it out");
  if (!models.vocabularies.empty() && models.detector.empty() && models.tagger.empty())
    throw usage_error("--vocabulary", models.vocabularies.front(), "belongs to no network",
                      "give the --detector or --tagger that reads it");
  if (models.trust_torchscript && models.files().empty())
    throw usage_error("--trust-torchscript", "", "does nothing without a network", "leave it out");
  if (!labels_photos(stage)) return;
  const TypedOption typed = labelling_option(label);
  if (label.everything) {
    if (!models.detector.empty() || !models.tagger.empty() || !label.text.empty())
      throw usage_error("--everything", "", "was given together with --detector, --tagger or --text",
                        "leave it out, or leave those out: it uses no names");
    return;
  }
  if (models.detector.empty() && typed.name == "--segmenter")
    throw usage_error(typed.name, typed.value, "has no prompt to segment",
                      "point at the object with --click, --box or --stroke, or give --detector FILE, or --everything");
  if (models.detector.empty() && typed.name == "--tagger")
    throw usage_error(typed.name, typed.value, "finds names but no locations", "also give --detector FILE");
  if (models.detector.empty())
    throw usage_error(typed.name, typed.value, "needs a detector",
                      typed.name == "--text" ? "give --detector FILE"
                                             : "give --detector FILE, or --everything to segment without names");
  if (!models.tagger.empty() && !label.text.empty())
    throw usage_error("--tagger", models.tagger, "was given together with --text, which sets the names to look for",
                      "leave one of them out");
}

}  // namespace pliant
