#include "gaussians/io/images/video_color.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/LU>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kHdRows = 720;

/// Shares of red and blue in the luma of a matrix.
struct Luma {
  double red, blue;
};
constexpr Luma kBt601 = {0.299, 0.114}, kBt709 = {0.2126, 0.0722};

/// Of the matrices in the words of ffprobe; those that are missing are decoded right, or are not YUV.
const std::map<std::string, Luma> kOther = {
    {"bt709", kBt709}, {"smpte240m", {0.212, 0.087}}, {"bt2020nc", {0.2627, 0.0593}}};

/// RGB of Y in 0..1, Cb and Cr in -0.5..0.5 (ITU-R BT.601-7, 2.5).
Eigen::Matrix3d rgb_from_yuv(const Luma& luma) {
  const double red = 2 * (1 - luma.red), blue = 2 * (1 - luma.blue), green = 1 - luma.red - luma.blue;
  Eigen::Matrix3d out;
  out << 1, 0, red, 1, -blue * luma.blue / green, -red * luma.red / green, 1, blue, 0;
  return out;
}

/// What ffprobe says of the first video stream; nothing when it cannot be run.
std::map<std::string, std::string> probe(const std::filesystem::path& video) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {};
  std::vector<std::string> words = {"ffprobe",
                                    "-v",
                                    "quiet",
                                    "-select_streams",
                                    "v:0",
                                    "-show_entries",
                                    "stream=height,pix_fmt,color_space,color_range,color_transfer",
                                    "-of",
                                    "default=noprint_wrappers=1",
                                    "file:" + video.string()};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t process = fork();
  if (process == 0) {
    dup2(::open("/dev/null", O_RDONLY), STDIN_FILENO);
    dup2(ends[1], STDOUT_FILENO);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  ::close(ends[1]);
  std::string text;
  char part[4096];
  for (ssize_t count = 0; (count = ::read(ends[0], part, sizeof(part))) > 0 || (count < 0 && errno == EINTR);)
    if (count > 0) text.append(part, static_cast<size_t>(count));
  ::close(ends[0]);
  while (process > 0 && waitpid(process, nullptr, 0) < 0 && errno == EINTR) {
  }
  std::map<std::string, std::string> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const size_t at = line.find('='); at != std::string::npos) values[line.substr(0, at)] = line.substr(at + 1);
  return values;
}

/// Of what ffprobe says.
std::optional<ColorCorrection> correction_of(std::map<std::string, std::string>& says) {
  const std::string& format = says["pix_fmt"];
  const auto begins = [&](const char* with) { return format.rfind(with, 0) == 0; };
  if (!begins("yuv") && !begins("nv") && !begins("p0")) return {};
  const std::string& space = says["color_space"];
  const bool unknown = space.empty() || space == "unknown";
  ColorCorrection out;
  out.guessed = unknown && std::atoi(says["height"].c_str()) >= kHdRows;
  const auto other = kOther.find(out.guessed ? "bt709" : space);
  const bool full = says["color_range"] == "pc" && !begins("yuvj");
  if (other == kOther.end() && !full) return {};

  const Eigen::Matrix3d meant = rgb_from_yuv(other == kOther.end() ? kBt601 : other->second);
  Eigen::Vector3d scale(1, 1, 1), shift(0, 0, 0);
  if (full) {
    scale = Eigen::Vector3d(219, 224, 224) / 255;
    shift.x() = 16.0 / 255;
  }
  out.matrix = (meant * scale.asDiagonal() * rgb_from_yuv(kBt601).inverse()).cast<float>();
  out.offset = (meant * shift).cast<float>();
  return out;
}

}  // namespace

VideoColor video_color(const std::filesystem::path& video) {
  std::map<std::string, std::string> says = probe(video);
  const std::string& transfer = says["color_transfer"];
  return {correction_of(says), transfer == "arib-std-b67" || transfer == "smpte2084"};
}

void correct_colors(const ColorCorrection& correction, ImageF& picture) {
  CHECK(picture.channels == 3);
  Eigen::Map<Eigen::Matrix3Xf> colors(picture.data.data(), 3, static_cast<Eigen::Index>(picture.pixels()));
  for (Eigen::Index p = 0; p < colors.cols(); ++p) {
    const Eigen::Vector3f color = correction.matrix * colors.col(p) + correction.offset;
    colors.col(p) = color.cwiseMax(0.0f).cwiseMin(1.0f);
  }
}

}  // namespace pliant
