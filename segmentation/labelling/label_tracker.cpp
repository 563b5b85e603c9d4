#include "segmentation/labelling/label_tracker.h"

#include <algorithm>

#include "gaussians/base/error.h"

namespace pliant {

IdImage LabelTracker::next(const ImageF& picture) {
  CHECK(every_ > 0);
  const int k = count_++;
  TrackedFrame frame;
  if (k > 0) frame = tracker_.step(picture);
  if (k % every_ != 0 && frame.lost.empty()) return frame.ids;
  const LabelledPhoto photo = label_photo(options_, models_, picture);
  if (k == 0) said_ = photo.said;
  // Every photo numbers its things from 1 on; those numbers are no ids of things met before.
  IdImage detections = photo.ids;
  for (uint32_t& id : detections.data)
    if (id != 0) id += last_;
  frame = k == 0 ? tracker_.start(picture, detections) : tracker_.add(detections);
  for (const uint32_t id : frame.ids.data) last_ = std::max(last_, id);
  for (const uint32_t id : frame.lost) last_ = std::max(last_, id);
  // An id without a name takes that of the detection on which most of it lies.
  std::map<uint32_t, std::map<uint32_t, size_t>> pixels;
  for (size_t i = 0; i < frame.ids.data.size(); ++i)
    if (frame.ids.data[i] != 0 && photo.ids.data[i] != 0) ++pixels[frame.ids.data[i]][photo.ids.data[i]];
  for (const auto& [id, of_detection] : pixels) {
    const auto most = std::max_element(of_detection.begin(), of_detection.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (const std::string& name = photo.things[most->first - 1].name; !name.empty()) names_.try_emplace(id, name);
  }
  return frame.ids;
}

}  // namespace pliant
