#include "segmentation/models/worker/serve.h"

#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <limits>
#include <new>
#include <thread>

#include "segmentation/models/channel.h"

namespace pliant {
namespace {

constexpr int kSocket = 3;

/// Address space in use [B].
uint64_t used_memory() {
  unsigned long long pages = 0;
  if (FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit_memory(uint64_t bytes) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const rlim_t most = used_memory() + bytes;
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
}

/// A network that never returns must not outlive the program that asked for it.
void end_with_the_other_side() {
  std::thread([] {
    pollfd entry{kSocket, 0, 0};
    while (poll(&entry, 1, -1) <= 0) {
    }
    _exit(0);
  }).detach();
}

bool speaks_of_memory(const std::string& text) {
  for (const char* words : {"can't allocate memory", "not enough memory", "Insufficient memory", "Failed to allocate"})
    if (text.find(words) != std::string::npos) return true;
  return false;
}

Message answer_to(const Message& request, LoadBackend load, std::unique_ptr<Backend>& backend) {
  Message answer;
  if (request.kind == Message::Kind::kLoad) {
    limit_memory(request.memory);
    backend = load(request.text, static_cast<int>(request.threads));
  } else if (backend) {
    const auto inputs = request.names.begin() + static_cast<long>(request.tensors.size());
    answer.tensors =
        backend->run(request.text, {request.names.begin(), inputs}, request.tensors, {inputs, request.names.end()});
  }
  return answer;
}

}  // namespace

int serve(LoadBackend load) {
  signal(SIGINT, SIG_IGN);  // the program that asked decides when to stop
  end_with_the_other_side();
  Channel channel(kSocket);
  std::unique_ptr<Backend> backend;
  for (;;) {
    Message request, answer;
    if (channel.receive(request, std::numeric_limits<double>::max(), std::numeric_limits<uint64_t>::max()) !=
        Channel::Received::kMessage)
      return 0;
    try {
      answer = answer_to(request, load, backend);
    } catch (const std::bad_alloc&) {
      answer.kind = Message::Kind::kNoMemory;
    } catch (const std::exception& error) {
      answer.kind = speaks_of_memory(error.what()) ? Message::Kind::kNoMemory : Message::Kind::kFailed;
      answer.text = error.what();
    }
    if (!channel.send(answer, std::numeric_limits<double>::max())) return 0;
  }
}

}  // namespace pliant
