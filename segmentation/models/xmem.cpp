#include "segmentation/models/xmem.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

TensorLine line(const std::string& name, const std::string& shape, double low = std::numeric_limits<float>::lowest(),
                double high = std::numeric_limits<float>::max()) {
  return {name, Tensor::Type::kFloat32, shape, low, high, ""};
}

/// Entry k of a tensor [1, K, ...].
std::vector<float> entry(const Tensor& tensor, size_t k) {
  const size_t size = tensor.values.size() / static_cast<size_t>(tensor.shape[1]);
  return {tensor.values.begin() + static_cast<std::ptrdiff_t>(k * size),
          tensor.values.begin() + static_cast<std::ptrdiff_t>((k + 1) * size)};
}

/// Number of pixels of each id above 0.
std::map<uint32_t, size_t> areas(const IdImage& ids) {
  std::map<uint32_t, size_t> count;
  for (const uint32_t id : ids.data)
    if (id) ++count[id];
  return count;
}

}  // namespace

Xmem::Xmem(std::unique_ptr<NeuralModule> module, const Options& options)
    : module_(std::move(module)), options_(options) {
  CHECK(options_.correction >= 0.5);
  hidden_channels_ = module_->file().size_of("hidden", 64);
  const std::string hidden = "1,K," + std::to_string(hidden_channels_) + ",h,w";
  const TensorLine frame{
      "frame", Tensor::Type::kFloat32, "1,3,16h,16w", -2.2, 2.7, "ImageNet mean and deviation, red first"};
  key_ = {"encode_key",
          {frame},
          {line("key", "1,C,h,w"), line("shrinkage", "1,1,h,w"), line("selection", "1,C,h,w"), line("f16", "1,*,h,w"),
           line("f8", "1,*,2h,2w"), line("f4", "1,*,4h,4w")}};
  value_ = {"encode_value",
            {frame, line("f16", "1,*,h,w"), line("hidden", hidden), line("masks", "1,K,16h,16w", 0, 1)},
            {line("value", "1,K,V,h,w"), line("hidden", hidden)}};
  segment_ = {"segment",
              {line("f16", "1,*,h,w"), line("f8", "1,*,2h,2w"), line("f4", "1,*,4h,4w"), line("readout", "1,K,V,h,w"),
               line("hidden", hidden), line("last_masks", "1,K,16h,16w", 0, 1)},
              {line("hidden", hidden), line("probabilities", "1,K+1,16h,16w", 0, 1)}};
  // The whole chain once, for two things; shapes that one network gives are what the next one takes.
  const std::vector<Tensor> features = module_->verify(key_, {{"h", 4}, {"w", 5}});
  const Tensor image = example_inputs(key_, {{"h", 4}, {"w", 5}})[0];
  const Tensor hidden_state = Tensor::floats({1, 2, hidden_channels_, 4, 5}),
               masks = Tensor::floats({1, 2, 64, 80}, 0.25f);
  const std::vector<Tensor> value = module_->verify_on(value_, {image, features[3], hidden_state, masks});
  module_->verify_on(segment_, {features[3], features[4], features[5], value[0], value[1], masks});
}

TrackedFrame Xmem::start(const ImageF& picture, const IdImage& masks) {
  CHECK(masks.width == picture.width && masks.height == picture.height);
  memory_.clear();
  things_.clear();
  hidden_.clear();
  width_ = picture.width;
  height_ = picture.height;
  read_frame(picture);
  ids_ = masks;
  for (const auto& [id, area] : areas(masks)) things_.push_back(id);
  if (!things_.empty()) remember(masks_of(ids_), false);
  return current();
}

TrackedFrame Xmem::step(const ImageF& picture) {
  CHECK_MSG(width_ > 0, "start() comes first");
  if (picture.width != width_ || picture.height != height_)
    throw input_error("tracker", "picture",
                      "is " + std::to_string(picture.width) + " x " + std::to_string(picture.height) +
                          " pixels in a sequence of " + std::to_string(width_) + " x " + std::to_string(height_),
                      "start over for images of another size");
  read_frame(picture);
  ++since_memory_;
  if (things_.empty()) return current();
  const std::vector<Tensor>& f = features_;
  const std::vector<std::vector<float>> values = memory_.read(
      f[0].values, f[2].values, static_cast<size_t>(f[0].shape[1]), things_, static_cast<size_t>(options_.top));
  const int64_t h = f[0].shape[2], w = f[0].shape[3], count = static_cast<int64_t>(things_.size());
  Tensor readout;
  readout.shape = {1, count, static_cast<int64_t>(values[0].size()) / (h * w), h, w};
  for (const std::vector<float>& value : values)
    readout.values.insert(readout.values.end(), value.begin(), value.end());
  const std::vector<Tensor> out = module_->run(segment_, {f[3], f[4], f[5], readout, hidden_state(), last_masks_});
  ids_ = ids_of(out[1]);
  Tensor masks = Tensor::floats({1, count, 16 * h, 16 * w});
  std::copy(out[1].values.begin() + 16 * h * 16 * w, out[1].values.end(), masks.values.begin());
  if (since_memory_ >= options_.every) {
    remember(masks, false);
  } else {
    keep_hidden(out[0]);
    last_masks_ = std::move(masks);
  }
  return current();
}

TrackedFrame Xmem::add(const IdImage& detections) {
  CHECK_MSG(width_ > 0, "start() comes first");
  if (detections.width != width_ || detections.height != height_)
    throw input_error("tracker", "detections", "do not have the size of the images",
                      "give one ID for each pixel of the last image");
  std::map<uint32_t, std::map<uint32_t, size_t>> shared;  // detection -> followed thing -> pixels
  for (size_t i = 0; i < ids_.data.size(); ++i)
    if (detections.data[i] && ids_.data[i]) ++shared[detections.data[i]][ids_.data[i]];
  std::set<uint32_t> taken(things_.begin(), things_.end()), corrected;
  std::map<uint32_t, uint32_t> id_of;
  std::map<uint32_t, size_t> area_of = areas(ids_);
  for (const auto& [detection, area] : areas(detections)) {
    // Intersection over union as in DEVA; above .5 a detection and a thing have no other partner.
    for (const auto& [thing, pixels] : shared[detection])
      if (static_cast<double>(pixels) > options_.correction * static_cast<double>(area + area_of[thing] - pixels)) {
        id_of[detection] = thing;
        corrected.insert(thing);
      }
    if (id_of.count(detection)) continue;
    uint32_t id = detection;
    for (uint32_t next = *std::max_element(detections.data.begin(), detections.data.end()); taken.count(id); ++next)
      id = std::max(next, 1u);
    id_of[detection] = id;
    taken.insert(id);
    things_.push_back(id);
  }
  for (size_t i = 0; i < ids_.data.size(); ++i) {
    if (detections.data[i])
      ids_.data[i] = id_of.at(detections.data[i]);
    else if (corrected.count(ids_.data[i]))
      ids_.data[i] = 0;
  }
  if (!things_.empty()) remember(masks_of(ids_), memory_.frames() > 0 && since_memory_ == 0);
  return current();
}

/// Scales, pads and encodes the next picture.
void Xmem::read_frame(const ImageF& picture) {
  const double scale = std::min(1.0, static_cast<double>(options_.short_side) / std::min(width_, height_));
  scaled_width_ = std::max(1, static_cast<int>(std::lround(width_ * scale)));
  scaled_height_ = std::max(1, static_cast<int>(std::lround(height_ * scale)));
  const int width = (scaled_width_ + 15) / 16 * 16, height = (scaled_height_ + 15) / 16 * 16;
  const Tensor small = to_planes(resize_picture(picture, scaled_width_, scaled_height_), Normalisation::imagenet());
  frame_ = Tensor::floats({1, 3, height, width});
  for (int row = 0; row < 3 * scaled_height_; ++row)
    std::copy_n(small.values.begin() + static_cast<std::ptrdiff_t>(row) * scaled_width_, scaled_width_,
                frame_.values.begin() +
                    (static_cast<std::ptrdiff_t>(row / scaled_height_) * height + row % scaled_height_) * width);
  features_ = module_->run(key_, {frame_});
}

/// Puts the current frame with these masks [1, K, 16h, 16w] into the memory, in the place of its newest frame if
/// `again`.
void Xmem::remember(const Tensor& masks, bool again) {
  const std::vector<Tensor> out = module_->run(value_, {frame_, features_[3], hidden_state(), masks});
  FeatureMemory::Frame frame{features_[0].values, features_[1].values, {}};
  for (size_t k = 0; k < things_.size(); ++k) frame.value[things_[k]] = entry(out[0], k);
  const uint64_t bytes = std::max<uint64_t>(out[0].values.size() * sizeof(float), 1);
  const size_t most = std::clamp<size_t>(options_.memory / bytes, 2, static_cast<size_t>(std::max(options_.frames, 2)));
  if (again)
    memory_.replace_newest(std::move(frame));
  else
    memory_.add(std::move(frame), most);
  keep_hidden(out[1]);
  last_masks_ = masks;
  since_memory_ = 0;
}

/// [1, K, E, h, w]; zero for things that have none yet.
Tensor Xmem::hidden_state() const {
  const int64_t h = features_[0].shape[2], w = features_[0].shape[3];
  Tensor hidden = Tensor::floats({1, static_cast<int64_t>(things_.size()), hidden_channels_, h, w});
  const auto size = hidden_channels_ * h * w;
  for (size_t k = 0; k < things_.size(); ++k)
    if (const auto known = hidden_.find(things_[k]); known != hidden_.end())
      std::copy(known->second.begin(), known->second.end(),
                hidden.values.begin() + static_cast<std::ptrdiff_t>(k) * size);
  return hidden;
}

void Xmem::keep_hidden(const Tensor& hidden) {
  for (size_t k = 0; k < things_.size(); ++k) hidden_[things_[k]] = entry(hidden, k);
}

/// Masks of all things as the network sees them: 1 where a thing covers at least half of a pixel.
Tensor Xmem::masks_of(const IdImage& ids) const {
  const int64_t height = frame_.shape[2], width = frame_.shape[3];
  Tensor masks = Tensor::floats({1, static_cast<int64_t>(things_.size()), height, width});
  for (size_t k = 0; k < things_.size(); ++k) {
    ImageF whole(width_, height_, 1);
    for (size_t i = 0; i < ids.data.size(); ++i) whole.data[i] = ids.data[i] == things_[k];
    const ImageF small = resize_picture(whole, scaled_width_, scaled_height_);
    for (int y = 0; y < scaled_height_; ++y)
      for (int x = 0; x < scaled_width_; ++x)
        masks.values[(static_cast<int64_t>(k) * height + y) * width + x] = small(x, y) >= 0.5f;
  }
  return masks;
}

/// The most probable thing of each pixel of the picture.
IdImage Xmem::ids_of(const Tensor& probabilities) const {
  const int height = static_cast<int>(probabilities.shape[2]), width = static_cast<int>(probabilities.shape[3]);
  IdImage ids(width_, height_, 1);
  std::vector<float> best(ids.data.size(), -1);
  for (size_t k = 0; k <= things_.size(); ++k) {
    const cv::Mat padded(height, width, CV_32F, const_cast<float*>(probabilities.values.data()) + k * height * width);
    cv::Mat whole;
    cv::resize(padded(cv::Rect(0, 0, scaled_width_, scaled_height_)), whole, {width_, height_}, 0, 0, cv::INTER_LINEAR);
    for (size_t i = 0; i < best.size(); ++i)
      if (whole.ptr<float>()[i] > best[i]) {
        best[i] = whole.ptr<float>()[i];
        ids.data[i] = k ? things_[k - 1] : 0;
      }
  }
  return ids;
}

TrackedFrame Xmem::current() const {
  TrackedFrame frame{ids_, {}};
  std::map<uint32_t, size_t> count = areas(ids_);
  for (const uint32_t thing : things_)
    if (count[thing] < static_cast<size_t>(options_.least_pixels)) frame.lost.push_back(thing);
  return frame;
}

}  // namespace pliant
