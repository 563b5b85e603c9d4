#pragma once

#include <string>
#include <vector>

namespace pliant {

struct HttpPost {
  std::string url;                   ///< http or https; redirections are not followed
  std::vector<std::string> headers;  ///< "Name: value"
  std::string body;
  double timeout = 20;             ///< s for the whole exchange, positive
  size_t max_answer = 256 * 1024;  ///< bytes
};

struct HttpAnswer {
  long status = 0;  ///< 0 = none came
  std::string body;
  std::string failure;  ///< why no whole answer came, in words; empty otherwise
};

/// Sends one request and waits for its answer.  Never throws for what the other side does.
HttpAnswer post(const HttpPost& request);

}  // namespace pliant
