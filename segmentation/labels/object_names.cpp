#include "segmentation/labels/object_names.h"

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {

std::string list_of_objects(const Segmentation& segmentation, size_t most) {
  std::string list;
  for (size_t c = 0; c < segmentation.class_id.size() && c < most; ++c)
    list += (c ? ", " : "") + std::to_string(segmentation.class_id[c]) + " = " + segmentation.class_name[c];
  if (segmentation.class_id.size() > most)
    list += ", ... (" + std::to_string(segmentation.class_id.size()) + " in total)";
  return list;
}

size_t class_of_object(const Segmentation& segmentation, const std::string& option, const std::string& wanted) {
  std::vector<std::string> known;
  std::vector<size_t> named;
  for (size_t c = 0; c < segmentation.class_id.size(); ++c) {
    if (wanted == std::to_string(segmentation.class_id[c])) return c;
    if (wanted == segmentation.class_name[c]) named.push_back(c);
    known.push_back(std::to_string(segmentation.class_id[c]));
    known.push_back(segmentation.class_name[c]);
  }
  if (named.size() == 1) return named[0];
  if (named.size() > 1) {
    std::string ids;
    for (size_t c : named) ids += (ids.empty() ? "" : ", ") + std::to_string(segmentation.class_id[c]);
    throw usage_error(option, wanted, "is the name of several objects", "give an id: " + ids);
  }
  throw usage_error(
      option, wanted, "is not in this scene",
      "did you mean '" + nearest_name(wanted, known) + "'? The objects are " + list_of_objects(segmentation));
}

}  // namespace pliant
