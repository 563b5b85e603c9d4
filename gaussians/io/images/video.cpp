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
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

/// Starts ffmpeg, which reads `input` (a pipe; -1 = nothing).  It finishes its file even when the terminal interrupts
/// the program.
pid_t start_ffmpeg(std::vector<std::string> words, int input) {
  words.insert(words.begin(), {"ffmpeg", "-v", "error", "-y"});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t process = fork();
  if (process != 0) return process;
  setpgid(0, 0);
  if (input < 0) input = ::open("/dev/null", O_RDONLY);
  dup2(input, STDIN_FILENO);
  execvp(argv[0], argv.data());
  _exit(127);
}

bool succeeded(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

Error could_not_encode(const fs::path& file) {
  return input_error(
      file.string(), "", "could not be encoded by ffmpeg",
      "install ffmpeg with libx264, libvpx and libwebp (Debian: ffmpeg), and check that the folder can be "
      "written");
}

/// What ffmpeg makes of RGB, in pictures of any size: the matrix of BT.601 in limited range, of colors in sRGB.
constexpr const char* kColorTags[] = {"-colorspace", "smpte170m",    "-color_primaries", "bt709",
                                      "-color_trc",  "iec61966-2-1", "-color_range",     "tv"};

std::vector<std::string> words_of(VideoCoding coding) {
  switch (coding) {
    case VideoCoding::kWithAlpha:
      return {"-c:v",      "libvpx-vp9", "-crf",     "20",       "-b:v",          "0", "-deadline", "good",
              "-cpu-used", "4",          "-pix_fmt", "yuva420p", "-auto-alt-ref", "0"};
    case VideoCoding::kFaithful:
      return {"-c:v", "libx264", "-preset", "medium", "-crf", "12", "-pix_fmt", "yuv444p", "-movflags", "+faststart"};
    case VideoCoding::kForBrowsers:
      break;
  }
  return {"-c:v", "libx264", "-preset", "medium", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart"};
}

}  // namespace

struct VideoWriter::State {
  fs::path file, temporary;
  int width, height, channels;
  pid_t encoder = -1;
  int pipe = -1;
  std::vector<uint8_t> frame;

  /// Ends the encoder; true when it wrote a whole file.
  bool finish() {
    if (pipe >= 0) {
      ::close(pipe);
      pipe = -1;
    }
    if (encoder < 0) return false;
    const pid_t ended = encoder;
    encoder = -1;
    return succeeded(ended);
  }
};

VideoWriter::VideoWriter(const fs::path& file, double fps, int width, int height, VideoCoding coding)
    : state_(std::make_unique<State>()) {
  if (width < 2 || height < 2)
    throw usage_error(file.string(), "",
                      "would have frames of " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
                      "a video needs at least 2 x 2: give a larger camera or size");
  State& s = *state_;
  s.file = file;
  s.temporary = temporary_name(file);
  s.width = width & ~1;
  s.height = height & ~1;
  s.channels = coding == VideoCoding::kWithAlpha ? 4 : 3;
  s.frame.resize(static_cast<size_t>(s.width) * s.height * s.channels);
  std::vector<std::string> words = {"-f",       "rawvideo",
                                    "-pix_fmt", s.channels == 4 ? "rgba" : "rgb24",
                                    "-s",       std::to_string(s.width) + "x" + std::to_string(s.height),
                                    "-r",       std::to_string(fps),
                                    "-i",       "pipe:0",
                                    "-an"};
  for (const std::string& word : words_of(coding)) words.push_back(word);
  for (const char* word : kColorTags) words.emplace_back(word);
  for (const std::string& word : {std::string("-threads"), std::string("1"), std::string("-fflags"),
                                  std::string("+bitexact"), "file:" + s.temporary.string()})
    words.push_back(word);

  // An encoder that dies must show as a failed write, not as a signal that ends the program.
  signal(SIGPIPE, SIG_IGN);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw could_not_encode(file);
  s.encoder = start_ffmpeg(std::move(words), ends[0]);
  ::close(ends[0]);
  s.pipe = ends[1];
  if (s.encoder < 0) throw could_not_encode(file);
}

VideoWriter::~VideoWriter() {
  if (state_->encoder < 0 && state_->pipe < 0) return;
  state_->finish();
  std::error_code ignored;
  fs::remove(state_->temporary, ignored);
}

void VideoWriter::write(const ImageF& picture) {
  State& s = *state_;
  CHECK(picture.channels == s.channels && picture.width >= s.width && picture.height >= s.height);
  const int row_size = s.channels * s.width;
  for (int y = 0; y < s.height; ++y) {
    const float* row = picture.at(0, y);
    uint8_t* out = s.frame.data() + static_cast<size_t>(y) * row_size;
    for (int i = 0; i < row_size; ++i) out[i] = static_cast<uint8_t>(std::clamp(row[i], 0.0f, 1.0f) * 255.0f + 0.5f);
  }
  for (size_t sent = 0; sent < s.frame.size();) {
    const ssize_t count = ::write(s.pipe, s.frame.data() + sent, s.frame.size() - sent);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw could_not_encode(s.file);
    sent += static_cast<size_t>(count);
  }
}

void VideoWriter::close() {
  State& s = *state_;
  if (!s.finish()) {
    std::error_code ignored;
    fs::remove(s.temporary, ignored);
    throw could_not_encode(s.file);
  }
  fs::rename(s.temporary, s.file);
}

void convert_video(const fs::path& from, const fs::path& to) {
  CHECK(to.extension() == ".gif" || to.extension() == ".webp");
  const fs::path temporary = temporary_name(to);
  std::vector<std::string> words = {"-i", "file:" + from.string(), "-an", "-threads", "1", "-loop", "0"};
  const std::vector<std::string> coding =
      to.extension() == ".gif"
          ? std::vector<std::string>{"-vf",
                                     "fps=min(source_fps\\,50),split[a][b];[a]palettegen=stats_mode=diff[p];"
                                     "[b][p]paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle"}
          : std::vector<std::string>{"-c:v", "libwebp_anim", "-quality", "80"};
  words.insert(words.end(), coding.begin(), coding.end());
  for (const std::string& word : {std::string("-fflags"), std::string("+bitexact"), "file:" + temporary.string()})
    words.push_back(word);
  const pid_t process = start_ffmpeg(std::move(words), -1);
  if (process < 0 || !succeeded(process)) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw could_not_encode(to);
  }
  fs::rename(temporary, to);
}

}  // namespace pliant
