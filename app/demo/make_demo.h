#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/demo/flower.h"

namespace pliant {

/// Scenes that can be made, the default first.
std::vector<std::string> demo_kinds();

struct DemoOptions {
  std::filesystem::path out;      ///< folder of the scene; made if it does not exist
  uint64_t seed = 1;              ///< moves, turns, resizes and recolours things
  int width = 400, height = 300;  ///< of photos, masks and video
  int photos = 40;
  int gaussians = 100000;       ///< about
  int training = 400;           ///< iterations in which they are optimised against the photos
  bool video = true;            ///< simulate the known push and film it
  int video_particles = 14000;  ///< of the reference simulation
  double video_seconds = 3, video_fps = 24;
};

struct DemoSummary {
  size_t gaussians = 0;
  std::map<std::string, size_t> gaussians_of;  ///< per name of an id
  int photos = 0;
  FlowerMechanics mechanics;
  double flower_height = 0;  ///< [m], with the pot
  double push_newtons = 0;   ///< of the reference video
  double peak_pixels = 0;    ///< largest motion of the blossom in the video [pixels]
  double peak_metres = 0;
  double photo_seconds = 0, splat_seconds = 0, simulate_seconds = 0, film_seconds = 0;
};

/// Makes the procedural scene: splats.ply, transforms.json, photos/, masks/, labels.json, reference.mp4, scene.json,
/// and truth/, which only `evaluate` reads.  Deterministic for a seed, for any number of threads.
/// Throws Error{kUsage} for sizes that make no picture.
DemoSummary make_demo(const DemoOptions& options);

}  // namespace pliant
