#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "gaussians/base/image.h"

namespace pliant {

/// What makes of a decoded color, RGB in [0, 1], the one that a video means: matrix * color + offset.
struct ColorCorrection {
  Eigen::Matrix3f matrix = Eigen::Matrix3f::Identity();
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();
  bool guessed = false;  ///< the file does not say which matrix it has
};

/// How the colors of a video are coded.
struct VideoColor {
  std::optional<ColorCorrection> correction;  ///< none where the decoded colors need none
  bool hdr = false;  ///< HLG or PQ (ITU-R BT.2100): shown as SDR it is flat, and no correction maps its tones
};

/// codecs::open_video decodes YUV as BT.601, and as of limited range unless the pixel format says otherwise.  The
/// correction is that of a file that ffprobe finds tagged with another matrix (BT.709, SMPTE 240M, BT.2020) or with
/// full range; without a matrix, 720 rows or more are BT.709, as players take them.  Nothing is known where ffprobe is
/// missing.  Colors that decoding clipped stay so.
VideoColor video_color(const std::filesystem::path& video);

/// Applies it to a picture [H, W, 3]; the result is clamped to [0, 1].
void correct_colors(const ColorCorrection& correction, ImageF& picture);

}  // namespace pliant
