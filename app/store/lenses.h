#pragma once

#include <filesystem>
#include <optional>

#include "gaussians/reconstruct/training_photos.h"

namespace pliant {

/// The lenses that a training removed from its photos: an object {name of the camera: {width, height, fx, fy, cx, cy,
/// distortion [6]}} beside the cameras without them.
constexpr const char* kLensFile = "lenses.json";

/// Writes the lenses of the photos that had one; without any it removes the file.  Atomic.
void write_lenses(const std::filesystem::path& file, const TrainingPhotos& photos);

/// `pinhole` with the lens, size and intrinsics that its photo had.  None where there is no such file, or none of its
/// lenses has the camera's name.  Throws Error{kInput} naming file and key.
std::optional<Camera> read_lens(const std::filesystem::path& file, const Camera& pinhole);

}  // namespace pliant
