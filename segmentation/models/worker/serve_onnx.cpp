// Runs an ONNX file with OpenCV's DNN module (4.6 or newer), which computes in float32.

#include <opencv2/dnn.hpp>

#include "segmentation/models/worker/serve.h"

namespace pliant {
namespace {

cv::Mat to_blob(const Tensor& tensor) {
  std::vector<int> sizes(tensor.shape.begin(), tensor.shape.end());
  if (sizes.size() == 1) sizes.push_back(1);  // a cv::Mat has two axes at least
  cv::Mat blob(static_cast<int>(sizes.size()), sizes.data(), CV_32F);
  float* out = blob.ptr<float>();
  if (tensor.type == Tensor::Type::kFloat32)
    std::copy(tensor.values.begin(), tensor.values.end(), out);
  else
    std::copy(tensor.integers.begin(), tensor.integers.end(), out);
  return blob;
}

Tensor from_blob(const cv::Mat& blob) {
  Tensor tensor;
  for (int axis = 0; axis < blob.dims; ++axis) tensor.shape.push_back(blob.size[axis]);
  if (blob.type() != CV_32F) {
    tensor.type = Tensor::Type::kOther;
    return tensor;
  }
  const cv::Mat whole = blob.isContinuous() ? blob : blob.clone();
  tensor.values.assign(whole.ptr<float>(), whole.ptr<float>() + whole.total());
  return tensor;
}

class OnnxBackend : public Backend {
 public:
  OnnxBackend(const std::string& file, int threads) {
    cv::setNumThreads(threads);
    net_ = cv::dnn::readNetFromONNX(file);
    net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  }

  std::vector<Tensor> run(const std::string&, const std::vector<std::string>& input_names,
                          const std::vector<Tensor>& inputs, const std::vector<std::string>& outputs) override {
    for (size_t i = 0; i < inputs.size(); ++i) net_.setInput(to_blob(inputs[i]), input_names[i]);
    std::vector<cv::Mat> blobs;
    net_.forward(blobs, outputs);
    std::vector<Tensor> tensors;
    for (const cv::Mat& blob : blobs) tensors.push_back(from_blob(blob));
    return tensors;
  }

 private:
  cv::dnn::Net net_;
};

}  // namespace
}  // namespace pliant

int main() {
  return pliant::serve([](const std::string& file, int threads) -> std::unique_ptr<pliant::Backend> {
    return std::make_unique<pliant::OnnxBackend>(file, threads);
  });
}
