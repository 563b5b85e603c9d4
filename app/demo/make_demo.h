#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "app/demo/demo_interruption.h"

namespace pliant {

struct DemoOptions {
  std::string kind = "potted-flower";  ///< see kinds.h
  std::filesystem::path out;           ///< folder of the scene; made if it does not exist
  std::filesystem::path cache;         ///< folder that keeps simulated motions of other kinds; empty = none
  uint64_t seed = 1;                   ///< moves, turns, resizes and recolours things
  int width = 400, height = 300;       ///< of photos, masks and video
  int photos = 40;
  int gaussians = 100000;    ///< about
  int training = 400;        ///< iterations in which they are optimised against the photos
  bool video = true;         ///< simulate the known push and film it
  int video_particles = 0;   ///< of the reference simulation; 0 = 14000 for the flower, 16000 for other kinds
  double video_seconds = 0;  ///< 0 = 3 for the flower, 2.5 for other kinds
  double video_fps = 24;
  Interrupted interrupted{};  ///< asked per photo, step of the training, simulated and filmed frame
};

struct DemoSummary {
  size_t gaussians = 0;
  int photos = 0;
};

/// Makes the procedural scene: splats.ply, transforms.json, photos/, masks/, labels.json, scene.json, the reference
/// videos (of the flower reference.mp4, else videos/{poke,pull,wind,jolt}.mp4), and truth/, which only `evaluate`
/// reads.  Deterministic for a seed, for any number of threads. Throws Error{kUsage} for an unknown kind and for sizes
/// that make no picture, Error{kInterrupted}.
DemoSummary make_demo(const DemoOptions& options);

}  // namespace pliant
