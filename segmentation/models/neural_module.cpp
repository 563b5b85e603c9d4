#include "segmentation/models/neural_module.h"

#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <regex>

#include "gaussians/base/error.h"
#include "segmentation/models/worker_process.h"

namespace pliant {
namespace {

constexpr const char* kExport =
    "export it with the script of segmentation/models/export, with the versions that it names";

/// OpenCV's complaints with the operator first: "Node [Foo@ai.onnx]:(name) ..." names the one that it cannot run.
std::string plain(const std::string& text) {
  std::smatch match;
  if (std::regex_search(text, match, std::regex(R"(Node \[([^\]@]+)[^\]]*\]:\(([^)]*)\))")))
    return "needs the operator " + match[1].str() + " (node " + match[2].str() +
           ") in a form that OpenCV's DNN module does not support";
  return "cannot be used: " + text.substr(0, 400);
}

}  // namespace

uint64_t memory_share(int networks) {
  const uint64_t machine =
      static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return machine / 4 * 3 / static_cast<uint64_t>(std::max(networks, 1));
}

class NeuralModule::Process {
 public:
  explicit Process(const std::filesystem::path& program) : worker(program) {}
  WorkerProcess worker;
};

NeuralModule::NeuralModule(const std::filesystem::path& file, const ModuleOptions& options)
    : file_(read_model_file(file)), options_(options) {
  const bool torch = file_.format == ModelFile::Format::kTorchScript;
  if (torch && !options.trust_torchscript)
    throw usage_error(options.option, file.string(), "is TorchScript, which is a program with all your permissions",
                      "add --trust-torchscript if you trust where it comes from");
  if (options_.threads <= 0) options_.threads = omp_get_max_threads();
  if (options_.memory == 0) options_.memory = memory_share(options_.networks);
  const std::filesystem::path program = program_folder() / (torch ? "pliant_torch_worker" : "pliant_onnx_worker");
  if (!std::filesystem::exists(program))
    throw input_error(file.string(), "", "needs " + program.string() + ", which does not exist",
                      torch ? "build with libtorch (Debian: libtorch-dev), or give an ONNX file"
                            : "build the target pliant_onnx_worker");
  process_ = std::make_unique<Process>(program);
  Message request;
  request.kind = Message::Kind::kLoad;
  request.text = std::filesystem::absolute(file).string();
  request.threads = static_cast<uint64_t>(options_.threads);
  request.memory = options_.memory;
  Message answer;
  try {
    answer = process_->worker.ask(request, options_.load_seconds, options_.memory);
  } catch (const std::runtime_error& error) {
    throw input_error(file.string(), "", std::string(error.what()) + " while it was loaded", kExport);
  }
  if (answer.kind == Message::Kind::kNoMemory)
    throw input_error(file.string(), "",
                      "needs more than " + std::to_string(options_.memory >> 20) + " MB to be loaded",
                      "give a smaller network");
  if (answer.kind != Message::Kind::kDone) throw input_error(file.string(), "", plain(answer.text), kExport);
}

NeuralModule::~NeuralModule() = default;

std::string NeuralModule::advice() const { return options_.advice.empty() ? kExport : options_.advice; }

void NeuralModule::require(const Contract& contract, const Lengths& lengths) const {
  if (file_.format != ModelFile::Format::kOnnx) return;
  std::string wrong = breach_of_outline(contract, file_.graph, lengths);
  if (contract.method != "forward")
    wrong =
        "is ONNX, which has one network and no method '" + contract.method + "'; the file " + outline_text(file_.graph);
  if (!wrong.empty()) throw input_error(file_.file.string(), contract.method, wrong, advice());
}

std::vector<Tensor> NeuralModule::verify(const Contract& contract, const Lengths& lengths) {
  require(contract, lengths);
  return run_within(contract, example_inputs(contract, lengths), options_.load_seconds);
}

std::vector<Tensor> NeuralModule::verify_on(const Contract& contract, const std::vector<Tensor>& inputs) {
  require(contract, {});
  return run_within(contract, inputs, options_.load_seconds);
}

std::vector<Tensor> NeuralModule::run(const Contract& contract, const std::vector<Tensor>& inputs) {
  return run_within(contract, inputs, options_.run_seconds);
}

std::vector<Tensor> NeuralModule::run_within(const Contract& contract, const std::vector<Tensor>& inputs,
                                             double seconds) {
  const std::string name = file_.file.string(), method = contract.method;
  CHECK(inputs.size() == contract.inputs.size());
  Lengths lengths;
  Message request;
  request.kind = Message::Kind::kRun;
  request.text = method;
  request.tensors = inputs;
  for (size_t i = 0; i < inputs.size(); ++i) {
    const std::string wrong = breach_of_shape(contract.inputs[i], inputs[i], lengths);
    CHECK_MSG(wrong.empty(), describe(contract.inputs[i]) + " " + wrong);
    request.names.push_back(contract.inputs[i].name);
  }
  for (const TensorLine& line : contract.outputs) request.names.push_back(line.name);

  Message answer;
  try {
    answer = process_->worker.ask(request, seconds, options_.memory);
  } catch (const std::runtime_error& error) {
    throw input_error(name, method, error.what(), "the network does not work with this program");
  }
  if (answer.kind == Message::Kind::kNoMemory)
    throw input_error(name, method, "needs more than " + std::to_string(options_.memory >> 20) + " MB",
                      "give a smaller network or smaller images");
  if (answer.kind != Message::Kind::kDone) throw input_error(name, method, plain(answer.text), kExport);
  if (answer.tensors.size() < contract.outputs.size())
    throw input_error(name, method,
                      "gives " + std::to_string(answer.tensors.size()) + " outputs, the contract has " +
                          std::to_string(contract.outputs.size()) + "; missing is " +
                          describe(contract.outputs[answer.tensors.size()]),
                      advice());
  answer.tensors.resize(contract.outputs.size());
  for (size_t i = 0; i < contract.outputs.size(); ++i) {
    const TensorLine& line = contract.outputs[i];
    Tensor& tensor = answer.tensors[i];
    const bool vector = line.shape.find(',') == std::string::npos;  // OpenCV gives [n] as [n,1]
    if (vector && tensor.shape.size() == 2 && tensor.shape[1] == 1 && file_.format == ModelFile::Format::kOnnx)
      tensor.shape.pop_back();
    std::string wrong = breach_of_shape(line, tensor, lengths);
    if (wrong.empty()) wrong = breach_of_range(line, tensor);
    if (!wrong.empty())
      throw input_error(name, "output '" + line.name + "' of " + method,
                        wrong + "; the contract says " + describe(line), advice());
  }
  return std::move(answer.tensors);
}

}  // namespace pliant
