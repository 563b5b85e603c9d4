#include "segmentation/models/xmem.h"

#include <gtest/gtest.h>

#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

// Keys are the mean colours of squares of 16 pixels, values the shares of the masks in them, so that things are followed
// by their colour.  Every other input adds a little to one thing more than to the others, and cannot change the winner.
const char* const kModule = R"(
def encode_key(self, frame):
    f16 = torch.avg_pool2d(frame, [16, 16])
    one = torch.ones_like(f16)
    return f16, one[:, :1] * 50.0, one, f16, torch.avg_pool2d(frame, [8, 8]), torch.avg_pool2d(frame, [4, 4])

def encode_value(self, frame, f16, hidden, masks):
    share = torch.unsqueeze(torch.avg_pool2d(masks, [16, 16]), 2)
    told = (torch.mean(frame) + torch.mean(f16)) * 0.0001
    return share + told, torch.clamp(hidden + 0.01, 0.0, 1.0)

def segment(self, f16, f8, f4, readout, hidden, last_masks):
    told = (torch.mean(f16) + torch.mean(f8) + torch.mean(f4) + torch.mean(last_masks)) * 0.0001
    small = torch.clamp(torch.mean(readout, [2]) * 0.9 + torch.mean(hidden, [2]) * 0.001 + told, 0.0, 1.0)
    shape = [small.size(2) * 16, small.size(3) * 16]
    things = torch.upsample_nearest2d(small, shape)
    rest = torch.clamp(1.0 - torch.sum(things, [1], True), 0.0, 1.0)
    return torch.clamp(hidden + 0.001, 0.0, 1.0), torch.cat([rest, things], 1)
)";

Xmem made(const TemporaryFolder& folder) {
  write_torch_module(folder / "xmem.pt", kModule, R"({"kind": "xmem", "hidden": 2})");
  ModuleOptions trusted;
  trusted.trust_torchscript = true;
  Xmem::Options options;
  options.every = 2, options.top = 4;
  return Xmem(std::make_unique<NeuralModule>(folder / "xmem.pt", trusted), options);
}

/// Squares of 32 pixels on gray; a position left of the picture means that the thing is not there.
struct Square {
  uint32_t id;
  int x, y;
  float red, green, blue;
};

constexpr int kWidth = 160, kHeight = 96;

ImageF picture_of(const std::vector<Square>& squares, IdImage& ids) {
  ImageF picture(kWidth, kHeight, 3, 0.5f);
  ids = IdImage(kWidth, kHeight, 1);
  for (const Square& square : squares)
    for (int y = square.y; y < square.y + 32; ++y)
      for (int x = std::max(square.x, 0); x < square.x + 32; ++x) {
        picture(x, y, 0) = square.red, picture(x, y, 1) = square.green, picture(x, y, 2) = square.blue;
        ids(x, y) = square.id;
      }
  return picture;
}

constexpr uint32_t kRed = 7, kBlue = 4000000000u;

}  // namespace

TEST(XmemTorch, ThingsKeepTheirIdsWhileTheyMoveLeaveAndComeBack) {
  TemporaryFolder folder;
  Xmem tracker = made(folder);
  IdImage truth;
  ImageF picture = picture_of({{kRed, 0, 0, 1, 0, 0}, {kBlue, 64, 48, 0, 0, 1}}, truth);
  EXPECT_EQ(tracker.start(picture, truth).ids.data, truth.data);
  for (int t = 1; t < 12; ++t) {
    const bool gone = t >= 4 && t < 8;
    picture = picture_of({{kRed, 16 * (t % 6), 0, 1, 0, 0}, {kBlue, gone ? -32 : 64, 48, 0, 0, 1}}, truth);
    const TrackedFrame frame = tracker.step(picture);
    EXPECT_EQ(frame.ids.data, truth.data) << t;
    EXPECT_EQ(frame.lost, gone ? std::vector<uint32_t>{kBlue} : std::vector<uint32_t>{}) << t;
  }
}

TEST(XmemTorch, DetectionsCorrectWhatTheyLieOnAndTheOthersAreFollowedFromThenOn) {
  TemporaryFolder folder;
  Xmem tracker = made(folder);
  IdImage truth;
  ImageF picture = picture_of({{kRed, 0, 0, 1, 0, 0}, {0, 96, 48, 0, 1, 0}, {0, 48, 0, 0, 0, 1}}, truth);
  tracker.start(picture, truth);
  IdImage found;
  picture_of({{90, 0, 0, 1, 0, 0}, {kRed, 96, 48, 0, 1, 0}, {12, 48, 0, 0, 0, 1}}, found);
  const TrackedFrame corrected = tracker.add(found);
  EXPECT_EQ(corrected.ids(4, 4), kRed);    // a detection on a followed thing is that thing
  EXPECT_EQ(corrected.ids(52, 4), 12u);    // another one keeps its id
  const uint32_t green = corrected.ids(100, 52);
  EXPECT_NE(green, kRed);                  // unless that is taken
  EXPECT_NE(green, 12u);
  EXPECT_NE(green, 0u);
  for (int t = 1; t < 5; ++t) {
    picture = picture_of({{kRed, 16 * t, 0, 1, 0, 0}, {green, 96 - 16 * t, 48, 0, 1, 0}, {12, 112, 0, 0, 0, 1}}, truth);
    EXPECT_EQ(tracker.step(picture).ids.data, truth.data) << t;
  }
}

TEST(XmemTorch, AStartWithoutThingsWaitsForDetectionsAndSizesMustAgree) {
  TemporaryFolder folder;
  Xmem tracker = made(folder);
  IdImage truth;
  const ImageF picture = picture_of({{kRed, 32, 16, 1, 0, 0}}, truth);
  tracker.start(picture, IdImage(kWidth, kHeight, 1));
  EXPECT_EQ(tracker.step(picture).ids.data, IdImage(kWidth, kHeight, 1).data);
  tracker.add(truth);
  EXPECT_EQ(tracker.step(picture).ids.data, truth.data);
  expect_error(Failure::kInput, {"160 x 96", "80 x 96"}, [&] { tracker.step(ImageF(80, 96, 3)); });
  expect_error(Failure::kInput, {"detections"}, [&] { tracker.add(IdImage(80, 96, 1)); });
}
