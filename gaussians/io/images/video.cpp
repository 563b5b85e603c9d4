#include "gaussians/io/images/video.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <vector>

#include "gaussians/base/error.h"

namespace pliant {
namespace fs = std::filesystem;

struct VideoWriter::State {
  fs::path file, temporary;
  int width, height;
  pid_t encoder = -1;
  int pipe = -1;
  std::vector<uint8_t> frame;

  Error failed() const {
    return input_error(file.string(), "", "could not be encoded by ffmpeg",
                       "install ffmpeg with libx264 (Debian: ffmpeg), and check that the folder can be written");
  }
  /// Ends the encoder; true when it wrote a whole file.
  bool finish() {
    if (pipe >= 0) {
      ::close(pipe);
      pipe = -1;
    }
    if (encoder < 0) return false;
    int status = 0;
    while (waitpid(encoder, &status, 0) < 0 && errno == EINTR) {
    }
    encoder = -1;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }
};

VideoWriter::VideoWriter(const fs::path& file, double fps, int width, int height, VideoCoding coding)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.file = file;
  s.temporary =
      file.parent_path() / (file.stem().string() + ".tmp" + std::to_string(getpid()) + file.extension().string());
  s.width = width & ~1;
  s.height = height & ~1;
  s.frame.resize(static_cast<size_t>(s.width) * s.height * 3);
  const std::string size = std::to_string(s.width) + "x" + std::to_string(s.height), rate = std::to_string(fps);
  const bool faithful = coding == VideoCoding::kFaithful;
  std::vector<std::string> arguments = {"ffmpeg",
                                        "-v",
                                        "error",
                                        "-y",
                                        "-f",
                                        "rawvideo",
                                        "-pix_fmt",
                                        "rgb24",
                                        "-s",
                                        size,
                                        "-r",
                                        rate,
                                        "-i",
                                        "pipe:0",
                                        "-an",
                                        "-c:v",
                                        "libx264",
                                        "-preset",
                                        "medium",
                                        "-crf",
                                        faithful ? "12" : "18",
                                        "-threads",
                                        "1",
                                        "-pix_fmt",
                                        faithful ? "yuv444p" : "yuv420p",
                                        "-movflags",
                                        "+faststart",
                                        "-fflags",
                                        "+bitexact",
                                        "file:" + s.temporary.string()};
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  // An encoder that dies must show as a failed write, not as a signal that ends the program.
  signal(SIGPIPE, SIG_IGN);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw s.failed();
  s.encoder = fork();
  if (s.encoder == 0) {
    // The encoder finishes its file even when the terminal interrupts the program.
    setpgid(0, 0);
    dup2(ends[0], STDIN_FILENO);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  ::close(ends[0]);
  s.pipe = ends[1];
  if (s.encoder < 0) throw s.failed();
}

VideoWriter::~VideoWriter() {
  if (state_->encoder < 0 && state_->pipe < 0) return;
  state_->finish();
  std::error_code ignored;
  fs::remove(state_->temporary, ignored);
}

void VideoWriter::write(const ImageF& rgb) {
  State& s = *state_;
  CHECK(rgb.channels == 3 && rgb.width >= s.width && rgb.height >= s.height);
  for (int y = 0; y < s.height; ++y) {
    const float* row = rgb.at(0, y);
    uint8_t* out = s.frame.data() + static_cast<size_t>(y) * s.width * 3;
    for (int i = 0; i < 3 * s.width; ++i) out[i] = static_cast<uint8_t>(std::clamp(row[i], 0.0f, 1.0f) * 255.0f + 0.5f);
  }
  for (size_t sent = 0; sent < s.frame.size();) {
    const ssize_t count = ::write(s.pipe, s.frame.data() + sent, s.frame.size() - sent);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw s.failed();
    sent += static_cast<size_t>(count);
  }
}

void VideoWriter::close() {
  State& s = *state_;
  if (!s.finish()) {
    std::error_code ignored;
    fs::remove(s.temporary, ignored);
    throw s.failed();
  }
  fs::rename(s.temporary, s.file);
}

}  // namespace pliant
