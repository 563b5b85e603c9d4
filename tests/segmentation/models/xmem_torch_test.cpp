#include <gtest/gtest.h>

#include "segmentation/models/xmem.h"
#include "tests/segmentation/models/torch_modules.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

// Keys are the mean colours of squares of 16 pixels, values the shares of the masks in them, so that things are
// followed by their colour.  Every other input adds a little to one thing more than to the others, and cannot change
// the winner.
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

// Writes what arrives as numbers into the ids: of the squares of 16 pixels in row r, as many as number r says belong to
// a thing, to the first one counted from the left, to the second from the right.  The numbers are means of f16 (red),
// f8 (green), f4 (blue + 3), readout, hidden, and a fifth of the squares in last_masks.  A value is the sum of the
// means of frame (red), f16 and hidden and a tenth of the squares in the mask, a hidden state that tenth more than
// before, and one more after each frame.
const char* const kNumbers = R"(
def encode_key(self, frame):
    f16 = torch.avg_pool2d(frame, [16, 16])
    f8 = torch.avg_pool2d(frame, [8, 8])
    f4 = torch.avg_pool2d(frame, [4, 4])
    one = torch.ones_like(f16)
    return f16, one[:, :1] * 50.0, one, f16[:, :1], f8[:, 1:2], f4[:, 2:] + 3.0

def encode_value(self, frame, f16, hidden, masks):
    squares = torch.floor(torch.sum(masks, [0, 2, 3]) / 2560.0 + 0.01)
    tenths = torch.reshape(squares, [1, masks.size(1), 1, 1, 1])
    told = torch.mean(frame[:, :1]) + torch.mean(f16) + tenths
    state = torch.mean(hidden, [2, 3, 4], True)
    return torch.zeros_like(hidden)[:, :, :1] + told + state, hidden + tenths

def segment(self, f16, f8, f4, readout, hidden, last_masks):
    fifths = torch.floor(torch.sum(last_masks, [0, 2, 3]) / 1280.0 + 0.01)
    one = torch.ones_like(fifths)
    told = [one * torch.mean(f16), one * torch.mean(f8), one * torch.mean(f4)]
    numbers = torch.stack([told[0], told[1], told[2], torch.mean(readout, [0, 2, 3, 4]), torch.mean(hidden, [0, 2, 3, 4]), fifths], 1)
    rows = torch.unsqueeze(numbers, 2)[:, :readout.size(3)] - 0.5
    column = torch.arange(readout.size(4))
    both = torch.stack([torch.lt(column, rows[0]) * 1.0, torch.lt(readout.size(4) - 1 - column, rows[1]) * 1.0], 0)
    things = torch.upsample_nearest2d(torch.unsqueeze(both, 0), [last_masks.size(2), last_masks.size(3)])
    rest = torch.clamp(1.0 - torch.sum(things, [1], True), 0.0, 1.0)
    return hidden + 1.0, torch.cat([rest, torch.clamp(things, 0.0, 1.0)], 1)
)";

Xmem::Options options_of(int every) {
  Xmem::Options options;
  options.every = every;
  options.top = 4;
  return options;
}

Xmem made_xmem(const TemporaryFolder& folder, const std::string& methods = kModule, double load_seconds = 300) {
  write_torch_module(folder / "xmem.pt", methods, R"({"kind": "xmem", "hidden": 2})");
  ModuleOptions options = trusted();
  options.load_seconds = load_seconds;
  return Xmem(std::make_unique<NeuralModule>(folder / "xmem.pt", options), options_of(2));
}

/// The module with one piece of its code replaced.
std::string with(std::string module, const std::string& piece, const std::string& other) {
  return module.replace(module.find(piece), piece.size(), other);
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
        picture(x, y, 0) = square.red;
        picture(x, y, 1) = square.green;
        picture(x, y, 2) = square.blue;
        ids(x, y) = square.id;
      }
  return picture;
}

constexpr uint32_t kRed = 7, kBlue = 4000000000u;

}  // namespace

TEST(XmemTorch, ThingsKeepTheirIdsWhileTheyMoveLeaveAndComeBack) {
  TemporaryFolder folder;
  Xmem tracker = made_xmem(folder);
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
  Xmem tracker = made_xmem(folder);
  IdImage truth;
  ImageF picture = picture_of({{kRed, 0, 0, 1, 0, 0}, {0, 96, 48, 0, 1, 0}, {0, 48, 0, 0, 0, 1}}, truth);
  tracker.start(picture, truth);
  IdImage found;
  picture_of({{90, 0, 0, 1, 0, 0}, {kRed, 96, 48, 0, 1, 0}, {12, 48, 0, 0, 0, 1}}, found);
  const TrackedFrame corrected = tracker.add(found);
  EXPECT_EQ(corrected.ids(4, 4), kRed);  // a detection on a followed thing is that thing
  EXPECT_EQ(corrected.ids(52, 4), 12u);  // another one keeps its id
  const uint32_t green = corrected.ids(100, 52);
  EXPECT_NE(green, kRed);  // unless that is taken
  EXPECT_NE(green, 12u);
  EXPECT_NE(green, 0u);
  for (int t = 1; t < 5; ++t) {
    picture = picture_of({{kRed, 16 * t, 0, 1, 0, 0}, {green, 96 - 16 * t, 48, 0, 1, 0}, {12, 112, 0, 0, 0, 1}}, truth);
    EXPECT_EQ(tracker.step(picture).ids.data, truth.data) << t;
  }
}

TEST(XmemTorch, ADetectionOfAPartOfAThingIsAThingOfItsOwnAndLeavesTheRest) {
  TemporaryFolder folder;
  Xmem tracker = made_xmem(folder);
  IdImage truth, part(kWidth, kHeight, 1);
  tracker.start(picture_of({{kRed, 0, 0, 1, 0, 0}}, truth), truth);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) truth(x, y) = part(x, y) = 12;
  EXPECT_EQ(tracker.add(part).ids.data, truth.data);
}

TEST(XmemTorch, EveryInputOfEveryNetworkReachesTheIds) {
  TemporaryFolder folder;
  Xmem tracker = made_xmem(folder, kNumbers);
  constexpr int kColumns = 20, kRows = 6;                      // squares of 16 pixels
  const auto plain = [](float red, float green, float blue) {  // in deviations of ImageNet from its mean
    ImageF picture(16 * kColumns, 16 * kRows, 3);
    for (size_t i = 0; i < picture.data.size(); i += 3) {
      picture.data[i] = 0.485f + 0.229f * red;
      picture.data[i + 1] = 0.456f + 0.224f * green;
      picture.data[i + 2] = 0.406f + 0.225f * blue;
    }
    return picture;
  };
  using Numbers = std::vector<int>;
  const auto numbers = [](const IdImage& ids, uint32_t id) {
    Numbers count(kRows);
    for (int y = 0; y < ids.height; ++y)
      for (int x = 0; x < ids.width; ++x) count[y / 16] += ids(x, y) == id;
    for (int& pixels : count) pixels /= 256;
    return count;
  };
  IdImage masks(16 * kColumns, 16 * kRows, 1);
  for (int y = 0; y < masks.height; ++y) {
    for (int x = 0; x < 80; ++x) masks(x, y) = kRed;
    for (int x = 160; x < 320; ++x) masks(x, y) = kBlue;
  }
  tracker.start(plain(2, 1, 0), masks);  // 30 and 60 squares: hidden 3 and 6, values 2 + 2 + 0 + 3 and 2 + 2 + 0 + 6
  const auto expect = [&](const Numbers& first, const Numbers& second) {
    const IdImage ids = tracker.step(plain(1, 2, 1)).ids;
    EXPECT_EQ(numbers(ids, kRed), first);
    EXPECT_EQ(numbers(ids, kBlue), second);
  };
  expect({1, 2, 4, 7, 3, 6}, {1, 2, 4, 10, 6, 12});  // 23 and 35 squares
  expect({1, 2, 4, 7, 4, 4},
         {1, 2, 4, 10, 7, 7});  // 22 and 31, remembered: hidden 6 and 10, values 1 + 1 + 4 + 2 and 1 + 1 + 7 + 3
  expect({1, 2, 4, 8, 6, 4}, {1, 2, 4, 12, 10, 6});
}

TEST(XmemTorch, EveryNetworkIsHeldToTheTimeOfTheDryRun) {
  TemporaryFolder folder;
  const std::string endless = "    while bool(torch.ge(torch.mean(f16), -100.0)):\n        f16 = f16 + 0.0\n";
  for (const auto& [method, begin] : {std::pair<std::string, std::string>{"encode_value", "    share ="},
                                      {"segment", "    told = (torch.mean(f16) + torch.mean(f8)"}})
    expect_error(Failure::kInput, {"xmem.pt", method, "gave no answer within 3.0 s"},
                 [&] { made_xmem(folder, with(kModule, begin, endless + begin), 3); });
}

TEST(XmemTorch, AStartWithoutThingsWaitsForDetectionsAndSizesMustAgree) {
  TemporaryFolder folder;
  Xmem tracker = made_xmem(folder);
  IdImage truth;
  const ImageF picture = picture_of({{kRed, 32, 16, 1, 0, 0}}, truth);
  tracker.start(picture, IdImage(kWidth, kHeight, 1));
  EXPECT_EQ(tracker.step(picture).ids.data, IdImage(kWidth, kHeight, 1).data);
  tracker.add(truth);
  EXPECT_EQ(tracker.step(picture).ids.data, truth.data);
  expect_error(Failure::kInput, {"160 x 96", "80 x 96"}, [&] { tracker.step(ImageF(80, 96, 3)); });
  expect_error(Failure::kInput, {"detections"}, [&] { tracker.add(IdImage(80, 96, 1)); });
}
