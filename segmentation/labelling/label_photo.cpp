#include "segmentation/labelling/label_photo.h"

#include <algorithm>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/edit_distance.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/text.h"

namespace pliant {
namespace {

/// Words in lower case, without the s of a plural.
std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(lower_case(text));
  std::vector<std::string> words;
  for (std::string word; in >> word;) {
    if (word.size() > 3 && word.back() == 's') word.pop_back();
    words.push_back(word);
  }
  return words;
}

/// The name in `vocabulary` that `wanted` means, empty when there is none: the same words; the wanted word that stands
/// last in English, else an earlier one, as a word of the name; at most a third of the letters different.
std::string meant_name(const std::string& wanted, const std::vector<std::string>& vocabulary) {
  const std::vector<std::string> words = words_of(wanted);
  for (const std::string& name : vocabulary)
    if (words_of(name) == words) return name;
  for (auto word = words.rbegin(); word != words.rend(); ++word) {
    std::string best;
    for (const std::string& name : vocabulary) {
      const std::vector<std::string> its = words_of(name);
      if (std::count(its.begin(), its.end(), *word) && (best.empty() || name.size() < best.size())) best = name;
    }
    if (!best.empty()) return best;
  }
  const std::string nearest = nearest_name(lower_case(wanted), vocabulary);
  return 3 * edit_distance(lower_case(wanted), lower_case(nearest)) <= wanted.size() ? nearest : "";
}

/// Tags that the detector can look for.
std::vector<std::string> names_from_tags(const ImageF& picture, Tagger& tagger, const Detector& detector) {
  const std::vector<std::string> vocabulary = detector.vocabulary();
  std::vector<std::string> names;
  for (const Tag& tag : tagger.tag(picture)) {
    std::string name = tag.name;
    if (!vocabulary.empty()) {
      const auto same = std::find_if(vocabulary.begin(), vocabulary.end(),
                                     [&](const std::string& v) { return words_of(v) == words_of(name); });
      if (same == vocabulary.end()) continue;
      name = *same;
    }
    if (!std::count(names.begin(), names.end(), name)) names.push_back(name);
  }
  return names;
}

}  // namespace

std::vector<std::string> names_for(const Detector& detector, const std::vector<std::string>& wanted,
                                   std::vector<std::string>& said) {
  const std::vector<std::string> vocabulary = detector.vocabulary();
  if (vocabulary.empty()) return wanted;
  std::vector<std::string> names;
  for (const std::string& text : wanted) {
    const std::string name = meant_name(text, vocabulary);
    if (name.empty())
      throw usage_error("--text", text, "is not a name that this detector knows",
                        "it knows " + std::to_string(vocabulary.size()) + " names, the nearest is '" +
                            nearest_name(text, vocabulary) +
                            "'; give one of them or a detector with an open vocabulary");
    if (words_of(name) != words_of(text))
      said.push_back("the detector has a fixed list of names: '" + name + "' is searched for instead of '" + text +
                     "'");
    if (!std::count(names.begin(), names.end(), name)) names.push_back(name);
  }
  return names;
}

LabelledPhoto label_photo(const LabelOptions& options, const LabelModels& models, const ImageF& picture) {
  CHECK(models.segmenter);
  if (!models.detector) {
    CHECK_MSG(options.names.empty(), "names need a detector");
    return paint_masks(options.paint, picture.width, picture.height,
                       segment_everything(options.everything, picture, *models.segmenter));
  }
  std::vector<std::string> said, names = names_for(*models.detector, options.names, said);
  LabelledPhoto empty;
  empty.ids = IdImage(picture.width, picture.height, 1);
  if (names.empty() && models.tagger) {
    names = names_from_tags(picture, *models.tagger, *models.detector);
    if (names.empty()) return empty;  // it saw nothing that the detector knows
  }
  if (names.empty() && models.detector->vocabulary().empty())
    throw usage_error("--detector", "", "needs names to look for", "give --text NAME or a --tagger");
  std::vector<Detection> detections = models.detector->detect(picture, names);
  std::erase_if(detections,
                [&](const Detection& d) { return d.score < options.least_score || !(d.x1 > d.x0 && d.y1 > d.y0); });
  std::vector<MaskPrompt::Box> boxes;
  std::vector<float> scores;
  for (const Detection& d : detections) {
    boxes.push_back({d.x0, d.y0, d.x1, d.y1});
    scores.push_back(d.score);
  }
  std::vector<PictureMask> masks;
  if (!detections.empty()) models.segmenter->encode(picture);
  for (size_t k : suppress_duplicates(boxes, scores, options.box_nms)) {
    PictureMask mask =
        picture_mask(models.segmenter->segment({boxes[k], {}}).front().logits, detections[k].label, scores[k]);
    if (mask.pixels > 0) masks.push_back(std::move(mask));
  }
  LabelledPhoto photo = paint_masks(options.paint, picture.width, picture.height, std::move(masks));
  photo.said = std::move(said);
  return photo;
}

}  // namespace pliant
