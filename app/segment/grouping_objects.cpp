#include "app/segment/grouping_objects.h"

#include <algorithm>

#include "app/import/gaussian_grouping.h"
#include "gaussians/base/error.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

Segmentation grouping_objects(const Scene& scene, const std::filesystem::path& classifier_file,
                              const std::filesystem::path& labels) {
  constexpr int kY = kSemanticChannels;
  const GroupingClassifier classifier = read_grouping_classifier(classifier_file);
  const std::string splats = scene.settings.splats.string();
  if (scene.report.object_channels == 0)
    throw input_error(splats, "obj_dc_0", "is missing: these splats were not trained by Gaussian Grouping",
                      "give the point_cloud.ply next to classifier.pth");
  if (scene.report.object_channels != kY || classifier.channels != kY)
    throw input_error(
        classifier.channels != kY ? classifier_file.string() : splats, "obj_dc",
        "has " + std::to_string(classifier.channels != kY ? classifier.channels : scene.report.object_channels) +
            " channels, 16 are expected",
        "give the two files of one model");
  Segmentation all;
  all.attribute = scene.report.object_features;
  all.classifier = classifier.weight;
  all.classifier_bias = classifier.bias;
  CHECK(all.attribute.size() == scene.cloud.size() * kY);
  for (int c = 0; c < classifier.classes; ++c) all.class_id.push_back(static_cast<uint32_t>(c));
  update_labels(all);

  std::vector<size_t> members(all.class_id.size(), 0);
  for (uint32_t label : all.label) ++members[label];
  MaskSet names;
  if (!labels.empty()) names.names = read_label_names(labels);
  Segmentation used;
  for (size_t c = 0; c < members.size(); ++c) {
    if (members[c] == 0) continue;
    const uint32_t id = all.class_id[c];
    used.class_id.push_back(id);
    used.class_name.push_back(id == 0 ? "background" : names.name_of(id));
    used.classifier.insert(used.classifier.end(), all.classifier.begin() + static_cast<std::ptrdiff_t>(c * kY),
                           all.classifier.begin() + static_cast<std::ptrdiff_t>((c + 1) * kY));
    used.classifier_bias.push_back(all.classifier_bias[c]);
  }
  used.attribute = std::move(all.attribute);
  used.antialiased = scene.report.antialiased;
  used.seen.assign(scene.cloud.size(), 1);
  used.next_id = static_cast<uint32_t>(classifier.classes);
  update_labels(used);
  return used;
}

}  // namespace pliant
