// The export scripts, run on stand-ins with the interface of the official packages (export_check.py), write what the
// loaders accept.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "gaussians/io/files/files.h"
#include "segmentation/models/make_models.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

/// Exports the stand-in `name` into `folder`; false where there is no Python with torch and numpy (exit code 77).
bool exported(const std::string& name, const TemporaryFolder& folder) {
  const std::string source = PLIANT_SOURCE_DIR, log = folder / "log";
  for (const char* python : {"/usr/bin/python3", "python3"}) {
    const int status =
        std::system(("PYTHONDONTWRITEBYTECODE=1 " + std::string(python) + " -W ignore '" + source +
                     "/tests/segmentation/models/export_check.py' '" + source + "/segmentation/models/export' '" +
                     folder.path().string() + "' " + name + " > '" + log + "' 2>&1")
                        .c_str());
    if (WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127) continue;
    EXPECT_EQ(status, 0) << read_text(log);
    return true;
  }
  return false;
}

ModelChoice trusting() {
  ModelChoice choice;
  choice.trust_torchscript = true;
  return choice;
}

ImageF ramp(int width, int height) {
  ImageF picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      picture(x, y, 0) = static_cast<float>(x) / width;
      picture(x, y, 1) = static_cast<float>(y) / height;
      picture(x, y, 2) = 0.5f;
    }
  return picture;
}

}  // namespace

TEST(ExportTorch, Lama) {
  TemporaryFolder folder;
  if (!exported("lama", folder)) GTEST_SKIP() << "needs python3 with torch and numpy";
  ModelChoice choice = trusting();
  choice.inpainter = folder / "lama.pt";
  ImageU8 mask(90, 70, 1);
  for (int y = 20; y < 40; ++y) mask(30, y) = 1;
  const ImageF picture = ramp(90, 70), filled = make_inpainter(choice)->inpaint(picture, mask);
  EXPECT_NE(filled(30, 30), picture(30, 30));
  EXPECT_EQ(filled(29, 30), picture(29, 30));
}

TEST(ExportTorch, RamAndItsPlus) {
  TemporaryFolder folder;
  if (!exported("ram", folder)) GTEST_SKIP() << "needs python3 with torch and numpy";
  ModelChoice choice = trusting();
  EXPECT_EQ(read_text(folder / "ram.txt"), "rose\t0.5000\ngrass\t0.4000\nsky\t0.6000\n");
  EXPECT_EQ(read_text(folder / "ram_plus.txt"), "rose\t0.4500\ngrass\t0.5000\nsky\t0.5500\n");
  for (const char* file : {"ram.pt", "ram_plus.pt"}) {
    choice.tagger = folder / file;
    EXPECT_LE(make_tagger(choice)->tag(ramp(90, 70)).size(), 3u) << file;
  }
}

TEST(ExportTorch, SamAndMobileSam) {
  TemporaryFolder folder;
  if (!exported("sam", folder)) GTEST_SKIP() << "needs python3 with torch and numpy";
  ModelChoice choice = trusting();
  for (const char* file : {"sam.pt", "mobile_sam.pt"}) {
    choice.segmenter = folder / file;
    const auto sam = make_segmenter(choice);
    sam->encode(ramp(90, 70));
    EXPECT_EQ(sam->segment({std::nullopt, {{45, 20, true}, {3, 3, false}}}).size(), 4u) << file;
  }
}

TEST(ExportTorch, Sam2) {
  TemporaryFolder folder;
  if (!exported("sam2", folder)) GTEST_SKIP() << "needs python3 with torch and numpy";
  ModelChoice choice = trusting();
  choice.segmenter = folder / "sam2.pt";
  const auto sam = make_segmenter(choice);
  sam->encode(ramp(90, 70));
  EXPECT_EQ(sam->segment({MaskPrompt::Box{10, 10, 60, 60}, {}})[0].logits.height, 70);
}

TEST(ExportTorch, GroundingDino) {
  TemporaryFolder folder;
  if (!exported("grounding_dino", folder)) GTEST_SKIP() << "needs python3 with torch and numpy";
  ModelChoice choice = trusting();
  choice.detector = folder / "dino.pt";
  const std::vector<Detection> boxes = make_detector(choice)->detect(ramp(90, 70), {"red flower", "dog"});
  EXPECT_FALSE(boxes.empty()) << "the stand-in is sure of every piece";
  for (const Detection& box : boxes) EXPECT_TRUE(box.label == "red flower" || box.label == "dog");
}

TEST(ExportTorch, XmemAndDeva) {
  TemporaryFolder folder;
  if (!exported("xmem deva", folder)) GTEST_SKIP() << "needs python3 with torch and numpy";
  IdImage masks(90, 70, 1);
  for (int y = 10; y < 40; ++y)
    for (int x = 10; x < 50; ++x) masks(x, y) = 5;
  for (const char* file : {"xmem.pt", "deva.pt"}) {
    ModelChoice choice = trusting();
    choice.tracker = folder / file;
    const auto tracker = make_tracker(choice);
    tracker->start(ramp(90, 70), masks);
    EXPECT_EQ(tracker->step(ramp(90, 70)).ids.width, 90) << file;
  }
}
