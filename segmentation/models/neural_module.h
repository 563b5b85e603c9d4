#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "segmentation/models/contract.h"
#include "segmentation/models/model_file.h"

namespace pliant {

/// Most memory for each of `networks` that run at the same time [B]: three quarters of the machine's, in equal shares.
uint64_t memory_share(int networks);

/// How a network is run.
struct ModuleOptions {
  std::string option;              ///< the one that named the file, "--detector", for messages
  bool trust_torchscript = false;  ///< TorchScript is code that may do anything that this program may
  int threads = 0;                 ///< 0 = as many as this program has now
  int networks = 1;                ///< that run beside each other, this one among them
  uint64_t memory = 0;             ///< most memory that the network may take [B]; 0 = memory_share(networks)
  double load_seconds = 300;       ///< longest time for reading the file, and for each call of the dry run
  double run_seconds = 900;        ///< longest time for one run after that
  std::string advice;              ///< what to do with a file that breaks the contract; empty = export it anew
};

/// A network from an ONNX or TorchScript file, run by a process of its own (worker_process.h).
class NeuralModule {
 public:
  /// Reads the file in a new process.  TorchScript without trust is an Error{kUsage}; a file that is not a network, one
  /// that needs operators the runtime lacks, more memory or more time than allowed is an Error{kInput}.
  NeuralModule(const std::filesystem::path& file, const ModuleOptions& options);
  ~NeuralModule();

  const ModelFile& file() const { return file_; }

  /// Compares what an ONNX file says about itself with the contract (breach_of_outline), without running it;
  /// TorchScript says nothing.  Throws Error{kInput} with the line that is broken and what the file has.
  void require(const Contract& contract, const Lengths& lengths) const;

  /// `require`, then runs `contract.method` once on example inputs of these lengths and checks what comes out, before
  /// any picture does.  Returns that.  Throws Error{kInput} with the line of the contract that was broken and what was
  /// found.
  std::vector<Tensor> verify(const Contract& contract, const Lengths& lengths);
  /// The same on given inputs.
  std::vector<Tensor> verify_on(const Contract& contract, const std::vector<Tensor>& inputs);

  /// Outputs in the order of the contract.  Inputs that do not fit it are a broken invariant, outputs that do not
  /// an Error{kInput} as in `verify`.
  std::vector<Tensor> run(const Contract& contract, const std::vector<Tensor>& inputs);

 private:
  class Process;

  std::string advice() const;
  std::vector<Tensor> run_within(const Contract& contract, const std::vector<Tensor>& inputs, double seconds);

  ModelFile file_;
  ModuleOptions options_;
  std::unique_ptr<Process> process_;
};

}  // namespace pliant
