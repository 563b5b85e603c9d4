// Networks of a person in the commands that use them: a segmenter behind gestures, an inpainter behind repair.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/splats/ply.h"
#include "tests/app/painted_demo.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A SAM whose mask is what has the colour in the middle of the foreground points or of the box.
const char* const kSameColour = R"(
def encode(self, image):
    return torch.avg_pool2d(image, [4, 4]).repeat([1, 86, 1, 1])[:, :256]
def decode(self, image_embeddings, point_coords, point_labels, mask_input, has_mask_input, orig_im_size):
    weight = torch.clamp(point_labels, 0.0, 1.0)
    wanted = torch.clamp(torch.sum(point_coords * weight.unsqueeze(2), [1]) / torch.clamp(torch.sum(weight), 1.0), 0.0, 255.0)
    x = int(wanted[0, 0] / 4.0)
    y = int(wanted[0, 1] / 4.0)
    colours = image_embeddings[:, :3]
    far = torch.sum((colours - colours[:, :, y:y + 1, x:x + 1]) ** 2, [1], True)
    mask = torch.upsample_nearest2d(1.0 - far, [256, 256])
    mask = mask + 0.0 * (torch.sum(mask_input) + torch.sum(has_mask_input) + torch.sum(orig_im_size))
    return torch.cat([self.iou, self.iou], 1), torch.cat([mask, mask], 1)
)";

/// Fills holes with magenta.
const char* const kMagenta = R"(
def forward(self, image, mask):
    return image * (1.0 - mask) + self.colour * mask
)";

/// A pixel "x,y" in the middle of `id`.
std::string pixel_of(const fs::path& mask, uint32_t id) {
  const IdImage ids = read_ids(mask);
  size_t count = 0, x = 0, y = 0;
  for (int j = 0; j < ids.height; ++j)
    for (int i = 0; i < ids.width; ++i)
      if (ids(i, j) == id) {
        ++count;
        x += i;
        y += j;
      }
  return std::to_string(x / count) + "," + std::to_string(y / count);
}

TEST(NetworkCommandTorch, AGivenSegmenterTurnsAClickInAPhotoIntoTheObject) {
  const TemporaryFolder folder;
  make_painted_demo(folder / "scene");
  write_torch_module(folder / "sam.pt", kSameColour, R"({"kind": "sam", "size": 256})", {{"iou", {1, 1}, {0.9f}}});
  const fs::path truth = folder / "scene/masks";
  const auto segment = [&](const std::string& out, std::vector<std::string> gestures) {
    std::vector<std::string> command = {"segment",
                                        (folder / "scene").string(),
                                        "--out",
                                        (folder / out).string(),
                                        "--segmenter",
                                        (folder / "sam.pt").string(),
                                        "--trust-torchscript",
                                        "--iterations",
                                        "20",
                                        "--hold-out"};
    command.insert(command.end(), gestures.begin(), gestures.end());
    return run_quietly(command);
  };
  // The photos are painted: only the segmenter, which reads them, can tell the box and the mug in this way.
  ASSERT_EQ(segment("box", {"--click", "view_001," + pixel_of(truth / "view_001.png", kRedThing)}), 0);
  EXPECT_GT(iou_in(folder / "box/held_out", objects_of(folder / "box").find("object")->second, truth, kRedThing),
            0.65);  // one photo does not show its back
  EXPECT_TRUE(fs::exists(folder / "box/prompted/view_001.jpg"));
  ASSERT_EQ(segment("mug", {"--stroke",
                            "fg,view_001," + pixel_of(truth / "view_001.png", kBlueThing) + "," +
                                pixel_of(truth / "view_001.png", kBlueThing),
                            "--click", "view_003," + pixel_of(truth / "view_003.png", kBlueThing)}),
            0);
  EXPECT_GT(iou_in(folder / "mug/held_out", objects_of(folder / "mug").find("object")->second, truth, kBlueThing), 0.6);

  ::testing::internal::CaptureStderr();
  EXPECT_EQ(segment("none", {"--stroke", "bg,view_001,5,5,9,9"}), 2);
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("--stroke"), std::string::npos) << said;
  EXPECT_NE(said.find("view_001"), std::string::npos) << said;
}

/// Gaussians of nearly the colour 1, 0, 1.
size_t magenta_in(const fs::path& splats) {
  const GaussianCloud cloud = read_ply(splats);
  size_t count = 0;
  for (size_t p = 0; p < cloud.size(); ++p) {
    const Vec3f colour = Vec3f(cloud.sh_of(p)[0], cloud.sh_of(p)[1], cloud.sh_of(p)[2]) * kSh0 + Vec3f::Constant(0.5f);
    count += colour.x() > 0.75f && colour.y() < 0.25f && colour.z() > 0.75f;
  }
  return count;
}

TEST(NetworkCommandTorch, RepairFillsTheHoleWithWhatTheGivenInpainterPaints) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), run = (folder / "run").string(),
                    net = (folder / "lama.pt").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "9000", "--photos", "8", "--width", "160", "--height",
                         "120", "--no-video"}),
            0);
  ASSERT_EQ(run_quietly({"segment", scene, "--out", run, "--iterations", "20"}), 0);
  ASSERT_EQ(run_quietly({"extract", run, "--object", "flower"}), 0);
  write_torch_module(net, kMagenta, R"({"kind": "lama"})", {{"colour", {1, 3, 1, 1}, {1, 0, 1}}});
  ASSERT_EQ(run_quietly({"repair", run}), 0);
  const size_t without = magenta_in(folder / "run/background_repaired.ply");
  EXPECT_NE(run_quietly({"repair", run, "--inpainter", net}), 0);  // a program that nobody trusted
  ASSERT_EQ(run_quietly({"repair", run, "--inpainter", net, "--trust-torchscript"}), 0);
  const json summary = json::parse(read_text(folder / "run/run.json"))["stages"]["repair"]["summary"];
  EXPECT_GT(summary["inpainted_views"].get<int>(), 0);
  EXPECT_EQ(without, 0u);
  EXPECT_GT(magenta_in(folder / "run/background_repaired.ply"), 50u);
}

}  // namespace
}  // namespace pliant
