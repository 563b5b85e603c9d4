#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "segmentation/models/contract.h"
#include "segmentation/models/model_file.h"

namespace pliant {

/// How a network is run.
struct ModuleOptions {
  std::string option;              ///< the one that named the file, "--detector", for messages
  bool trust_torchscript = false;  ///< TorchScript is code that may do anything that this program may
  int threads = 0;                 ///< 0 = as many as this program has now
  uint64_t memory = 0;             ///< most memory that the network may take [B]; 0 = three quarters of the machine's
  double load_seconds = 300;       ///< longest time for reading the file and the dry run
  double run_seconds = 900;        ///< longest time for one run after that
};

/// A network from an ONNX or TorchScript file, run by a process of its own (worker_process.h).
class NeuralModule {
 public:
  /// Reads the file in a new process.  TorchScript without trust is an Error{kUsage}; a file that is not a network, one
  /// that needs operators the runtime lacks, more memory or more time than allowed is an Error{kInput}.
  NeuralModule(const std::filesystem::path& file, const ModuleOptions& options);
  ~NeuralModule();

  const ModelFile& file() const { return file_; }

  /// Runs `contract.method` once on example inputs of these lengths and checks what comes out, before any picture does.
  /// Returns that.  Throws Error{kInput} with the line of the contract that was broken and what was found.
  std::vector<Tensor> verify(const Contract& contract, const Lengths& lengths);

  /// Outputs in the order of the contract.  Inputs that do not fit it are a broken invariant, outputs that do not
  /// an Error{kInput} as in `verify`.
  std::vector<Tensor> run(const Contract& contract, const std::vector<Tensor>& inputs);

 private:
  class Process;

  std::vector<Tensor> run_within(const Contract& contract, const std::vector<Tensor>& inputs, double seconds);

  ModelFile file_;
  ModuleOptions options_;
  std::unique_ptr<Process> process_;
};

}  // namespace pliant
