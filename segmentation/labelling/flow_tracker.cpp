#include "segmentation/labelling/flow_tracker.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/vision/optical_flow.h"
#include "segmentation/labelling/mask_measures.h"
#include "segmentation/labelling/picture_window.h"

namespace pliant {
namespace {

/// Distance to the border of the mask [px], positive inside.
ImageF signed_distance(const ImageF& mask) {
  cv::Mat inside(mask.height, mask.width, CV_8U), in, out;
  for (size_t i = 0; i < mask.data.size(); ++i) inside.data[i] = mask.data[i] > 0;
  cv::distanceTransform(inside, in, cv::DIST_L2, 5, CV_32F);
  cv::distanceTransform(cv::Mat(inside == 0), out, cv::DIST_L2, 5, CV_32F);
  ImageF distance(mask.width, mask.height, 1);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) distance(x, y) = in.at<float>(y, x) - out.at<float>(y, x);
  return distance;
}

MaskPrompt::Box grown_box(const ImageF& mask, float share) {
  const MaskPrompt::Box box = box_of_mask(mask);
  const float margin = std::max(3.0f, share * std::max(box.x1 - box.x0, box.y1 - box.y0));
  return {box.x0 - margin, box.y0 - margin, box.x1 + margin, box.y1 + margin};
}

/// Colours of the mask, and of what lies in the box around it but not in the mask.
struct Looks {
  ColorHistogram thing, around;
};
Looks looks_of(const ImageF& lab, const ImageF& mask, float context) {
  const MaskPrompt::Box box = grown_box(mask, context);
  Looks looks;
  looks.thing = histogram_of(lab, [&](size_t i) { return mask.data[i] > 0; });
  looks.around = histogram_of(lab, [&](size_t i) {
    const float x = static_cast<float>(i % mask.width), y = static_cast<float>(i / mask.width);
    return mask.data[i] <= 0 && x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
  });
  return looks;
}

}  // namespace

TrackedFrame FlowTracker::start(const ImageF& picture, const IdImage& masks) {
  things_.clear();
  width_ = picture.width;
  height_ = picture.height;
  take(picture);
  return add(masks);
}

/// Keeps the picture at the size at which it is followed.
void FlowTracker::take(const ImageF& picture) {
  const int longest = std::min(options_.longest, std::max(width_, height_));
  const PictureWindow all(width_, height_, {0, 0, static_cast<float>(width_), static_cast<float>(height_)}, longest);
  picture_ = all.read(picture);
  lab_ = lab_picture(picture_);
}

IdImage FlowTracker::scaled(const IdImage& ids) const {
  IdImage out(picture_.width, picture_.height, 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      out(x, y) = ids((2 * x + 1) * ids.width / (2 * out.width), (2 * y + 1) * ids.height / (2 * out.height));
  return out;
}

TrackedFrame FlowTracker::frame() const {
  IdImage small(picture_.width, picture_.height, 1);
  TrackedFrame frame;
  for (const auto& [id, thing] : things_) {
    if (thing.lost)
      frame.lost.push_back(id);
    else
      for (size_t i = 0; i < small.data.size(); ++i)
        if (thing.mask.data[i] > 0) small.data[i] = id;
  }
  frame.ids = IdImage(width_, height_, 1);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x)
      frame.ids(x, y) = small((2 * x + 1) * small.width / (2 * width_), (2 * y + 1) * small.height / (2 * height_));
  return frame;
}

void FlowTracker::follow(uint32_t id, const ImageF& mask) {
  Thing& thing = things_[id];
  thing.mask = mask;
  thing.pixels = pixels_of(mask);
  thing.lost = false;
  thing.look.blend(looks_of(lab_, mask, options_.context).thing, 0.5f);
}

TrackedFrame FlowTracker::step(const ImageF& picture) {
  CHECK_MSG(!picture_.empty(), "step before start");
  if (picture.width != width_ || picture.height != height_ || picture.channels != 3)
    throw input_error("picture", "size",
                      std::to_string(picture.width) + "x" + std::to_string(picture.height) + ", the first one had " +
                          std::to_string(width_) + "x" + std::to_string(height_),
                      "give images of one size");
  const ImageF before = picture_, lab_before = lab_;
  take(picture);
  const std::vector<ImageF> frames = {before, picture_};
  const std::pair<int, int> pairs[2] = {{1, 0}, {0, 1}};
  std::vector<ImageF> flow = dense_flows(frames, pairs);
  const Flows flows{std::move(flow[0]), std::move(flow[1])};

  std::vector<Thing*> followed, lost;
  for (auto& [id, thing] : things_) (thing.lost ? lost : followed).push_back(&thing);
  parallel_for(static_cast<std::ptrdiff_t>(followed.size()), [&](std::ptrdiff_t k) {
    Thing& thing = *followed[k];
    const std::optional<Carried> flown = carry_by_flow(flows, lab_before, thing),
                                 shifted = carry_by_shift(lab_before, thing);
    const bool shift_first = shifted && (!flown || shifted->misfit < options_.better * flown->misfit);
    thing.lost = !settle(shift_first ? shifted : flown, thing) && !settle(shift_first ? flown : shifted, thing);
  });
  // A pixel that two things claim is the one's whose cut is surer.
  std::vector<uint8_t> taken(picture_.pixels(), 0);
  for (size_t i = 0; i < taken.size(); ++i) {
    Thing* best = nullptr;
    for (Thing* thing : followed)
      if (!thing->lost && thing->mask.data[i] > 0 && (!best || thing->mask.data[i] > best->mask.data[i])) best = thing;
    for (Thing* thing : followed)
      if (thing != best) thing->mask.data[i] = std::min(thing->mask.data[i], -1.0f);
    taken[i] = best != nullptr;
  }
  for (Thing* thing : followed) {
    if (thing->lost) continue;
    const size_t pixels = pixels_of(thing->mask);
    thing->lost = pixels < options_.least_pixels;
  }
  if (!lost.empty()) {
    const ColorHistogram ground = histogram_of(lab_, [](size_t) { return true; });
    for (Thing* thing : lost)
      if (recall(lab_, ground, taken, *thing)) {
        thing->lost = false;
        for (size_t i = 0; i < taken.size(); ++i) taken[i] |= thing->mask.data[i] > 0;
      }
  }
  return frame();
}

/// What GrabCut makes of a mask that was carried; `trust` 0..1 weighs its log odds.  The colours that the thing had
/// count where they are mostly others than those around it.
ImageF FlowTracker::cut_around(const ImageF& carried, const ImageF& trust, const ImageF& lab,
                               const ColorHistogram& look) const {
  constexpr float kFloor = 1e-3f, kMost = 3;
  const ColorHistogram around = looks_of(lab, carried, options_.context).around;
  const float telling = around.empty() ? 0 : std::max(0.0f, 1 - 2 * look.likeness(around));
  const ImageF distance = signed_distance(carried);
  const float size = std::sqrt(static_cast<float>(std::max<size_t>(1, pixels_of(carried))));
  ImageF prior(carried.width, carried.height, 1);
  for (size_t i = 0; i < prior.data.size(); ++i) {
    const Vec3f color = Eigen::Map<const Vec3f>(lab.data.data() + 3 * i);
    const float odds = std::log((look.share(color) + kFloor) / (around.share(color) + kFloor));
    prior.data[i] =
        trust.data[i] * options_.prior * std::clamp(distance.data[i] / (options_.border * size), -1.0f, 1.0f) +
        telling * std::clamp(odds, -kMost, kMost);
  }
  const PictureWindow window(carried.width, carried.height, grown_box(carried, options_.context), options_.window);
  const ImageF colors = window.read(lab), odds = window.read(prior), far = window.read(distance);
  GrabCutInput input;
  input.width = window.width;
  input.height = window.height;
  input.prior = odds.data;
  for (size_t i = 0; i < colors.pixels(); ++i) {
    input.lab.push_back(Eigen::Map<const Vec3f>(colors.data.data() + 3 * i));
    input.start.push_back(odds.data[i] > 0);
    input.seed.push_back(far.data[i] < -options_.context * size ? PixelSeed::kBackground : PixelSeed::kUnknown);
  }
  GrabCutOptions cut = options_.cut;
  cut.levels = {1};
  ImageF logits(input.width, input.height, 1);
  logits.data = grab_cut(cut, input).logit;
  return window.write(logits, carried.width, carried.height, kOut);
}

/// Gives the thing the mask that was carried, with its border cut anew; false, and as it was, when it does not look
/// like the thing any more.
bool FlowTracker::settle(const std::optional<Carried>& carried, Thing& thing) const {
  if (!carried || pixels_of(carried->mask) < options_.least_pixels) return false;
  ImageF mask = cut_around(carried->mask, carried->trust, lab_, thing.look);
  if (mask_iou(mask, carried->mask) < options_.least_kept) mask = carried->mask;
  const Looks looks = looks_of(lab_, mask, options_.context);
  // What a thing looks like is told by a person or a detector, never learnt from what was carried: that would drift
  // along.
  const float alike = looks.thing.likeness(thing.look);
  if (alike < options_.least_alike || alike < looks.around.likeness(thing.look)) return false;
  thing.mask = std::move(mask);
  return true;
}

/// Looks for a lost thing by its colours; true when it is there.
bool FlowTracker::recall(const ImageF& lab, const ColorHistogram& ground, const std::vector<uint8_t>& taken,
                         Thing& thing) const {
  if (thing.look.likeness(ground) > options_.recall_common) return false;
  cv::Mat odds(lab.height, lab.width, CV_32F), number, stats, centres;
  float* value = odds.ptr<float>();
  for (size_t i = 0; i < lab.pixels(); ++i) {
    const Vec3f color = Eigen::Map<const Vec3f>(lab.data.data() + 3 * i);
    value[i] = taken[i] ? 0 : std::min(4.0f, thing.look.share(color) / (ground.share(color) + 1e-3f));
  }
  cv::GaussianBlur(odds, odds, cv::Size(), 1.5);
  const int count = cv::connectedComponentsWithStats(odds > 2, number, stats, centres, 8, CV_32S);
  const float before = static_cast<float>(thing.pixels);
  const auto right_size = [&](float pixels) {
    return pixels * options_.recall_size >= before && pixels <= before * options_.recall_size;
  };
  float best = 0;
  ImageF found;
  for (int k = 1; k < count; ++k) {
    if (!right_size(static_cast<float>(stats.at<int>(k, cv::CC_STAT_AREA)))) continue;
    ImageF blob(lab.width, lab.height, 1, -1.0f);
    for (int y = 0; y < lab.height; ++y)
      for (int x = 0; x < lab.width; ++x)
        if (number.at<int>(y, x) == k) blob(x, y) = 1;
    if (looks_of(lab, blob, 0).thing.likeness(thing.look) < options_.least_alike) continue;
    ImageF mask = cut_around(blob, ImageF(lab.width, lab.height, 1, options_.doubt), lab, thing.look);
    const size_t pixels = pixels_of(mask);
    if (pixels < options_.least_pixels || !right_size(static_cast<float>(pixels))) continue;
    const Looks looks = looks_of(lab, mask, options_.context);
    const float alike = looks.thing.likeness(thing.look);
    if (alike < options_.recall_alike || alike < looks.around.likeness(thing.look) + 0.1f || alike <= best) continue;
    best = alike;
    found = std::move(mask);
  }
  if (best > 0) thing.mask = std::move(found);
  return best > 0;
}

TrackedFrame FlowTracker::add(const IdImage& detections) {
  CHECK_MSG(!picture_.empty(), "add before start");
  if (detections.width != width_ || detections.height != height_)
    throw input_error("masks", "size",
                      std::to_string(detections.width) + "x" + std::to_string(detections.height) + ", the image has " +
                          std::to_string(width_) + "x" + std::to_string(height_),
                      "give masks of the image's size");
  const IdImage ids = scaled(detections);
  std::map<uint32_t, ImageF> given;
  for (size_t i = 0; i < ids.data.size(); ++i)
    if (const uint32_t id = ids.data[i]; id != 0) {
      ImageF& mask = given[id];
      if (mask.empty()) mask = ImageF(ids.width, ids.height, 1, -1.0f);
      mask.data[i] = 1;
    }
  std::vector<uint32_t> met;  // followed things that a detection has taken already
  for (const auto& [id, mask] : given) {
    if (pixels_of(mask) < options_.least_pixels) continue;
    const ColorHistogram look = histogram_of(lab_, [&](size_t i) { return mask.data[i] > 0; });
    uint32_t best = 0;
    float overlap = options_.match, alike = options_.recall_alike;
    for (const auto& [other, thing] : things_) {
      if (thing.lost || std::count(met.begin(), met.end(), other)) continue;
      if (const float iou = mask_iou(mask, thing.mask); iou >= overlap) {
        overlap = iou;
        best = other;
      }
    }
    if (best == 0 && things_.count(id) && things_.at(id).lost) best = id;
    if (best == 0)
      for (const auto& [other, thing] : things_)
        if (thing.lost && look.likeness(thing.look) > alike) {
          alike = look.likeness(thing.look);
          best = other;
        }
    if (best == 0) best = things_.count(id) ? std::max(things_.rbegin()->first, given.rbegin()->first) + 1 : id;
    follow(best, mask);
    met.push_back(best);
    for (auto& [other, thing] : things_)
      if (other != best && !thing.lost)
        for (size_t i = 0; i < mask.data.size(); ++i)
          if (mask.data[i] > 0) thing.mask.data[i] = std::min(thing.mask.data[i], -1.0f);
  }
  return frame();
}

}  // namespace pliant
