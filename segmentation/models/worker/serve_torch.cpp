// Runs a TorchScript file with libtorch.

#include <caffe2/serialize/inline_container.h>
#include <torch/csrc/jit/frontend/builtin_functions.h>
#include <torch/csrc/jit/runtime/operator.h>
#include <torch/script.h>
#include <torch/utils.h>
#include <torch/version.h>

#include "segmentation/models/worker/operators.h"
#include "segmentation/models/worker/serve.h"

namespace pliant {
namespace {

at::Tensor to_torch(const Tensor& tensor) {
  const at::IntArrayRef shape(tensor.shape);
  if (tensor.type == Tensor::Type::kFloat32)
    return torch::from_blob(const_cast<float*>(tensor.values.data()), shape, torch::kFloat32).clone();
  at::Tensor whole = torch::from_blob(const_cast<int64_t*>(tensor.integers.data()), shape, torch::kInt64).clone();
  return tensor.type == Tensor::Type::kBool ? whole.to(torch::kBool) : whole;
}

Tensor from_torch(const at::Tensor& given) {
  Tensor tensor;
  tensor.shape = given.sizes().vec();
  const at::Tensor dense = given.detach().to(torch::kCPU).contiguous();
  switch (given.scalar_type()) {
    case torch::kFloat32:
      tensor.values.assign(dense.data_ptr<float>(), dense.data_ptr<float>() + dense.numel());
      return tensor;
    case torch::kInt64:
      tensor.type = Tensor::Type::kInt64;
      break;
    case torch::kBool:
      tensor.type = Tensor::Type::kBool;
      break;
    case torch::kFloat16:
      tensor.type = Tensor::Type::kFloat16;
      return tensor;
    case torch::kFloat64:
      tensor.type = Tensor::Type::kFloat64;
      return tensor;
    case torch::kInt32:
      tensor.type = Tensor::Type::kInt32;
      return tensor;
    default:
      tensor.type = Tensor::Type::kOther;
      return tensor;
  }
  const at::Tensor whole = dense.to(torch::kInt64);
  tensor.integers.assign(whole.data_ptr<int64_t>(), whole.data_ptr<int64_t>() + whole.numel());
  return tensor;
}

void collect(const c10::IValue& value, std::vector<Tensor>& tensors) {
  if (value.isTensor())
    tensors.push_back(from_torch(value.toTensor()));
  else if (value.isTuple())
    for (const c10::IValue& part : value.toTupleRef().elements()) collect(part, tensors);
  else if (value.isTensorList())
    for (const at::Tensor& part : value.toTensorVector()) tensors.push_back(from_torch(part));
  else if (value.isList())
    for (const c10::IValue& part : value.toListRef()) collect(part, tensors);
  else
    throw std::runtime_error("returns a " + value.tagKind() + " where the contract has tensors");
}

/// The first line of a message of libtorch, which is what a person can use.
std::string first_line(const std::string& text) {
  const std::string line = text.substr(0, text.find('\n'));
  return line.empty() ? text : line;
}

/// Operators that the code in a TorchScript file calls and that this libtorch does not have.
std::set<std::string> missing_operators(const std::string& file) {
  std::set<std::string> missing;
  caffe2::serialize::PyTorchStreamReader archive(file);
  for (const std::string& record : archive.getAllRecords()) {
    if (record.rfind("code/", 0) != 0 || !record.ends_with(".py")) continue;
    const auto [data, size] = archive.getRecord(record);
    for (const std::string& name : operators_in({static_cast<const char*>(data.get()), size})) {
      const auto symbol = c10::Symbol::fromQualString(name);
      if (torch::jit::getAllOperatorsFor(symbol).empty() && torch::jit::getAllBuiltinFunctionsFor(symbol).empty())
        missing.insert(name);
    }
  }
  return missing;
}

/// What a person can do with the message of a failed load.
std::string load_failure(const std::string& file, const std::string& message) {
  const std::string first = operator_of_message(message);
  if (first.empty()) return first_line(message);
  std::set<std::string> missing = missing_operators(file);
  if (missing.empty())
    return "needs " + operators_text({first}) + " in a form that libtorch " TORCH_VERSION " does not have";
  return "needs " + operators_text(missing) + ", which libtorch " TORCH_VERSION " does not have";
}

class TorchBackend : public Backend {
 public:
  TorchBackend(const std::string& file, int threads) {
    torch::set_num_threads(threads);
    try {
      module_ = torch::jit::load(file, torch::kCPU);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const c10::Error& error) {
      throw std::runtime_error(load_failure(file, error.what_without_backtrace()));
    } catch (const std::exception& error) {  // of the compiler: torch::jit::ErrorReport
      throw std::runtime_error(load_failure(file, error.what()));
    }
    module_.eval();
  }

  std::vector<Tensor> run(const std::string& method, const std::vector<std::string>&, const std::vector<Tensor>& inputs,
                          const std::vector<std::string>&) override {
    const auto found = module_.find_method(method);
    if (!found) throw std::runtime_error("has no method '" + method + "'");
    const size_t arguments = found->function().getSchema().arguments().size() - 1;  // without self
    if (arguments != inputs.size())
      throw std::runtime_error("takes " + std::to_string(arguments) + " inputs in '" + method +
                               "' where the contract has " + std::to_string(inputs.size()));
    std::vector<c10::IValue> values;
    for (const Tensor& tensor : inputs) values.push_back(to_torch(tensor));
    c10::InferenceMode inference;
    std::vector<Tensor> outputs;
    try {
      collect((*found)(std::move(values)), outputs);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      throw std::runtime_error("stops in '" + method + "': " + reason(error.what()));
    }
    return outputs;
  }

 private:
  /// The sentence that matters in a message of interpreted code: what follows "RuntimeError: ".
  static std::string reason(const std::string& text) {
    const std::string words = "RuntimeError: ";
    const size_t at = text.rfind(words);
    return first_line(at == std::string::npos ? text : text.substr(at + words.size()));
  }

  torch::jit::Module module_;
};

}  // namespace
}  // namespace pliant

int main() {
  return pliant::serve([](const std::string& file, int threads) -> std::unique_ptr<pliant::Backend> {
    return std::make_unique<pliant::TorchBackend>(file, threads);
  });
}
