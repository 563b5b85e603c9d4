#pragma once

#include "app/demo/make_demo.h"

namespace pliant {

/// A demo scene with a reference video, small enough for a test.
inline DemoOptions small_demo(const std::filesystem::path& out) {
  DemoOptions demo;
  demo.training = 50;
  demo.out = out;
  demo.gaussians = 9000;
  demo.photos = 8;
  demo.width = 240;
  demo.height = 180;
  demo.video_particles = 2500;
  demo.video_seconds = 1.25;
  return demo;
}

}  // namespace pliant
