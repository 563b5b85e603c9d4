#pragma once

#include <memory>
#include <string>
#include <vector>

#include "segmentation/models/tensor.h"

namespace pliant {

/// A network inside the process that runs it.
class Backend {
 public:
  virtual ~Backend() = default;
  /// Outputs of `method`: those called `outputs` where the format knows names, else all of them in order.
  virtual std::vector<Tensor> run(const std::string& method, const std::vector<std::string>& input_names,
                                  const std::vector<Tensor>& inputs, const std::vector<std::string>& outputs) = 0;
};

using LoadBackend = std::unique_ptr<Backend> (*)(const std::string& file, int threads);

/// Serves the socket on descriptor 3 until it closes; the exit code of a worker.  Memory taken after the start is
/// limited to what the request to load allows; exceptions become messages.
int serve(LoadBackend load);

}  // namespace pliant
