#pragma once

#include "tests/app/fit_video_scene.h"

namespace pliant {

/// A run of a small demo scene whose object moves for .7 s, with its clip.html.
class MovingRun : public FitVideo {
 protected:
  static void prepare(const Path& out) {
    copy_prepared(prepared_scene(), out);
    const std::string run = (out / "run").string();
    ASSERT_EQ(
        run_quietly({"simulate", run, "--young", "2e4", "--poisson", "0.3", "--density", "400", "--duration", "0.7"}),
        0);
    ASSERT_EQ(run_quietly({"export", run, "--html", (out / "clip.html").string()}), 0);
  }
  static void SetUpTestSuite() { use_copy_of(prepared_once("moving_run", prepare)); }
  static Path page() { return folder / "clip.html"; }
};

}  // namespace pliant
