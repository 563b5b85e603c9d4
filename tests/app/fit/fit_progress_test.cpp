// An interrupted fit goes on where nothing has changed that counts.

#include "app/fit/fit_progress.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/store/fit_checkpoint.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

TEST(FitProgress, GoesOnWhereTheVideoHasMovedAndNotAtAnotherRate) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::create(folder / "run");
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  nlohmann::json provenance = {{"scene", {{"video", {{"camera", "c"}, {"fps", 24}, {"file", "/before/swing.mp4"}}}}}};
  FitCheckpoint checkpoint;
  checkpoint.markers.refinement.loss = {3, 2};
  checkpoint.provenance_json = provenance.dump();
  std::filesystem::create_directories(run / "fit");
  write_fit_checkpoint(run / "fit/checkpoint.h5", checkpoint);

  provenance["scene"]["video"].erase("file");
  EXPECT_EQ(kept_marker_fit(context, run, provenance.dump()).state.refinement.loss.size(), 2u);
  provenance["scene"]["video"]["fps"] = 25;
  EXPECT_EQ(kept_marker_fit(context, run, provenance.dump()).state.refinement.loss.size(), 0u);
}

}  // namespace
}  // namespace pliant
