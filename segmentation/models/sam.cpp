#include "segmentation/models/sam.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

std::string fixed(const std::vector<int64_t>& shape) {
  std::string text = shape_text(shape);
  return text.substr(1, text.size() - 2);
}

bool has_input(const ModelFile& file, const std::string& name) {
  return std::any_of(file.graph.inputs.begin(), file.graph.inputs.end(),
                     [&](const GraphTensor& input) { return input.name == name; });
}

/// Order of the masks, best first: a clear prompt has one meaning, the first of four; a point alone may have several.
std::vector<size_t> order_of(const std::vector<float>& iou, bool clear) {
  std::vector<size_t> order(iou.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return iou[a] > iou[b]; });
  if (iou.size() == 4) {
    order.erase(std::find(order.begin(), order.end(), 0));
    order.insert(clear ? order.begin() : order.end(), 0);
  }
  return order;
}

std::vector<std::string> feature_names(const ModelFile& file) {
  return file.about().value("features", std::vector<std::string>{"image_embeddings"});
}

}  // namespace

Contract Sam::encoder_contract(const ModelFile& file) {
  const std::vector<std::string> names = feature_names(file);
  const bool onnx = file.format == ModelFile::Format::kOnnx;
  const auto type = Tensor::Type::kFloat32;
  Contract contract;
  contract.inputs = {{"image", type, "1,3,S,S", -2.2, 2.7, "ImageNet mean and deviation, red first"}};
  if (onnx && file.graph.inputs.size() == 1) contract.inputs[0].name = file.graph.inputs[0].name;
  for (const std::string& name : names) {
    const bool image = names.size() == 1 || name == "image_embeddings" || name == "image_embed";
    TensorLine line{name, type, image ? "1,256,h,w" : "1,*,*,*"};
    if (onnx && names.size() == 1 && file.graph.outputs.size() == 1) line.name = file.graph.outputs[0].name;
    contract.outputs.push_back(line);
  }
  return contract;
}

Sam::Sam(std::unique_ptr<NeuralModule> encoder, std::unique_ptr<NeuralModule> decoder)
    : encoder_(std::move(encoder)), decoder_(std::move(decoder)) {
  const ModelFile& file = encoder_->file();
  const nlohmann::json about = file.about();
  size_ = file.size_of("size", 1024);
  square_ = about.value("fit", "longest") == "square";
  pads_boxes_ = about.value("pad_boxes", false);
  const std::vector<std::string> names = feature_names(file);
  const auto type = Tensor::Type::kFloat32;
  encode_ = encoder_contract(file);
  if (!decoder_) {
    encode_.method = "encode";
    decode_.method = "decode";
  }
  const std::vector<Tensor> features = encoder_->verify(encode_, {{"S", size_}});
  int64_t height = 0, width = 0;
  for (size_t i = 0; i < features.size(); ++i) {
    decode_.inputs.push_back({names[i], type, fixed(features[i].shape)});
    if (encode_.outputs[i].shape == "1,256,h,w") {
      height = features[i].shape[2];
      width = features[i].shape[3];
    }
  }
  takes_size_ =
      !decoder_ || decoder_->file().format != ModelFile::Format::kOnnx || has_input(decoder_->file(), "orig_im_size");
  decode_.inputs.push_back(
      {"point_coords", type, "1,N,2", 0, static_cast<double>(size_), "pixels of the scaled image"});
  decode_.inputs.push_back(
      {"point_labels", type, "1,N", 1, 1, "0 background, 1 foreground, 2 and 3 corners of a box, -1 none"});
  decode_.inputs.push_back(
      {"mask_input", type, "1,1," + std::to_string(4 * height) + "," + std::to_string(4 * width), 0, 0, "zero"});
  decode_.inputs.push_back({"has_mask_input", type, "1", 0, 0, "zero"});
  if (takes_size_) decode_.inputs.push_back({"orig_im_size", type, "2", 64, 64, "height and width"});
  decode_.outputs = {{"iou_predictions", type, "1,M"},
                     {"low_res_masks", type, "1,M," + std::to_string(4 * height) + "," + std::to_string(4 * width),
                      -1e30, 1e30, "logits"}};
  (decoder_ ? *decoder_ : *encoder_).verify(decode_, {{"N", 2}});
}

void Sam::encode(const ImageF& picture) {
  width_ = picture.width;
  height_ = picture.height;
  Fitted fitted;
  if (square_) {
    fitted.picture = resize_picture(picture, size_, size_);
    fitted.width = fitted.height = size_;
  } else
    fitted = fit_picture(picture, size_, size_, 0);
  scaled_width_ = fitted.width;
  scaled_height_ = fitted.height;
  Tensor image = to_planes(fitted.picture, Normalisation::imagenet());
  for (int c = 0; c < 3; ++c)  // padding is zero after the normalisation
    for (int y = 0; y < size_; ++y)
      for (int x = y < fitted.height ? fitted.width : 0; x < size_; ++x)
        image.values[(static_cast<size_t>(c) * size_ + y) * size_ + x] = 0;
  features_ = encoder_->run(encode_, {std::move(image)});
}

std::vector<SegmentedMask> Sam::segment(const MaskPrompt& prompt) {
  CHECK_MSG(!features_.empty(), "encode() comes first");
  if (!prompt.box && prompt.points.empty())
    throw usage_error("prompt", "", "has no box and no point", "give a point or a box");
  std::vector<float> places, labels;
  const auto add = [&](float x, float y, float label) {  // SAM counts from the centres of pixels
    places.push_back(x * scaled_width_ / width_ - 0.5f);
    places.push_back(y * scaled_height_ / height_ - 0.5f);
    labels.push_back(label);
  };
  for (const MaskPrompt::Point& point : prompt.points) {
    if (!(point.x >= 0 && point.y >= 0 && point.x <= width_ && point.y <= height_))
      throw usage_error(
          "prompt", "",
          "has a point outside the image of " + std::to_string(width_) + " x " + std::to_string(height_) + " pixels",
          "point into it");
    add(point.x, point.y, point.foreground ? 1 : 0);
  }
  if (prompt.box) {
    const MaskPrompt::Box& box = *prompt.box;
    const float x0 = std::max(box.x0, 0.f), y0 = std::max(box.y0, 0.f);
    const float x1 = std::min(box.x1, static_cast<float>(width_)), y1 = std::min(box.y1, static_cast<float>(height_));
    if (!(x0 < x1 && y0 < y1))
      throw usage_error(
          "prompt", "",
          "has a box outside the image of " + std::to_string(width_) + " x " + std::to_string(height_) + " pixels",
          "draw it inside");
    add(x0, y0, 2);
    add(x1, y1, 3);
  }
  if (!prompt.box || pads_boxes_) {
    places.insert(places.end(), {0, 0});
    labels.push_back(-1);
  }
  const auto count = static_cast<int64_t>(labels.size());
  std::vector<Tensor> inputs = features_;
  const std::vector<int64_t>& embeddings = [&]() -> const std::vector<int64_t>& {
    for (size_t i = 0; i < features_.size(); ++i)
      if (encode_.outputs[i].shape == "1,256,h,w") return features_[i].shape;
    return features_[0].shape;
  }();
  inputs.push_back(Tensor::floats({1, count, 2}, places));
  inputs.push_back(Tensor::floats({1, count}, labels));
  inputs.push_back(Tensor::floats({1, 1, 4 * embeddings[2], 4 * embeddings[3]}));
  inputs.push_back(Tensor::floats({1}));
  if (takes_size_) inputs.push_back(Tensor::floats({2}, {static_cast<float>(height_), static_cast<float>(width_)}));
  const std::vector<Tensor> out = (decoder_ ? *decoder_ : *encoder_).run(decode_, inputs);

  const auto rows = static_cast<int>(out[1].shape[2]), columns = static_cast<int>(out[1].shape[3]);
  std::vector<SegmentedMask> masks;
  for (const size_t m : order_of(out[0].values, prompt.box || prompt.points.size() > 1))
    masks.push_back(
        {to_picture(out[1].values.data() + m * rows * columns, columns, rows), std::clamp(out[0].values[m], 0.f, 1.f)});
  return masks;
}

/// Logits of the small mask on the pixels of the picture: up to the encoder's size, without the padding, and down
/// again.
ImageF Sam::to_picture(const float* logits, int width, int height) const {
  const cv::Mat small(height, width, CV_32F, const_cast<float*>(logits));
  cv::Mat large, whole;
  cv::resize(small, large, {size_, size_}, 0, 0, cv::INTER_LINEAR);
  ImageF mask(width_, height_, 1);
  whole = cv::Mat(height_, width_, CV_32F, mask.data.data());
  cv::resize(large(cv::Rect(0, 0, scaled_width_, scaled_height_)), whole, whole.size(), 0, 0, cv::INTER_LINEAR);
  return mask;
}

}  // namespace pliant
