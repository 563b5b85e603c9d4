// Gestures in pixels of selection.png are gestures in the pictures that it shows, and the sides stay while they count.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

/// --box around the mask `id` in a picture of the demo.
std::string box_around(const std::filesystem::path& mask, uint32_t id) {
  const IdImage ids = read_ids(mask);
  int x0 = ids.width, y0 = ids.height, x1 = 0, y1 = 0;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x)
      if (ids(x, y) == id) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x + 1);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y + 1);
      }
  std::string text = mask.stem().string();
  for (int v : {std::max(0, x0 - 2), std::max(0, y0 - 2), std::min(ids.width, x1 + 2), std::min(ids.height, y1 + 2)})
    text += "," + std::to_string(v);
  return text;
}

size_t object_gaussians(const std::filesystem::path& run) {
  for (const json& object : read_json(run / "objects.json"))
    if (object["name"] != "rest") return object["gaussians"];
  return 0;
}

TEST(SelectionSheet, StrokesOnItTakeAwayWhatTheyCoverAndMeanTheSameWhenRepeatedOrAddedTo) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "6000", "--photos", "8", "--width", "160", "--height",
                         "120", "--no-video"}),
            0);
  EXPECT_EQ(run_quietly({"segment", scene, "--out", out, "--click", "selection,5,5"}), 2);  // nothing was selected yet
  uint32_t flower = 0;
  const json labels = read_json(folder / "scene/labels.json");
  for (const auto& [id, name] : labels.items())
    if (name == "flower") flower = static_cast<uint32_t>(std::stoul(id));
  std::vector<std::filesystem::path> masks;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "scene/masks")) masks.push_back(entry.path());
  std::sort(masks.begin(), masks.end());
  std::vector<std::string> command = {"segment", scene, "--out", out, "--box", box_around(masks.front(), flower)};
  ASSERT_EQ(run_quietly(command), 0);
  const size_t selected = object_gaussians(folder / "run");
  ASSERT_GT(selected, 100u);

  // A pixel of the third side that is tinted as the object, with such pixels around it.
  const json cells = read_json(folder / "run/selection_sheet.json");
  ASSERT_EQ(cells.size(), 8u);
  const ImageF sheet = read_image(folder / "run/selection.png");
  const json& cell = cells[2];
  const auto tinted = [&](int x, int y) {
    return sheet(x, y, 1) > 0.4f && sheet(x, y, 1) > 1.3f * sheet(x, y, 2) && sheet(x, y, 1) > 1.15f * sheet(x, y, 0);
  };
  int at_x = -1, at_y = -1, best = 0;
  for (int y = cell["y"].get<int>() + 10; y < cell["y"].get<int>() + 310; ++y)
    for (int x = cell["x"].get<int>() + 10; x < cell["x"].get<int>() + 390; ++x) {
      int near = 0;
      for (int j = -6; j <= 6; j += 2)
        for (int i = -6; i <= 6; i += 2) near += tinted(x + i, y + j);
      if (near > best) {
        best = near;
        at_x = x;
        at_y = y;
      }
    }
  ASSERT_GT(best, 10);
  const auto stroke = [](int x, int y) {
    return "bg,selection," + std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(x + 4) + "," +
           std::to_string(y);
  };
  command.insert(command.end(), {"--stroke", stroke(at_x, at_y)});
  ASSERT_EQ(run_quietly(command), 0);
  EXPECT_LT(object_gaussians(folder / "run"), selected);
  const json options = read_json(folder / "run/run.json")["stages"]["segment"]["options"];
  const std::string text = options["stroke"][0];
  EXPECT_EQ(text.substr(0, 19), "bg,selection.png:2,") << text;
  EXPECT_NEAR(std::stod(text.substr(19)), at_x - cell["x"].get<int>(), 0.01) << text;

  // The sides stay, so a command repeated does nothing and a stroke more leaves the first one what it was.
  EXPECT_EQ(read_json(folder / "run/selection_sheet.json"), cells);
  const std::string before = sha256_of_file(folder / "run/segmentation.h5");
  ASSERT_EQ(run_quietly(command), 0);
  EXPECT_EQ(sha256_of_file(folder / "run/segmentation.h5"), before);
  command.insert(command.end(), {"--stroke", stroke(at_x, at_y + 3)});
  ASSERT_EQ(run_quietly(command), 0);
  const json after = read_json(folder / "run/run.json")["stages"]["segment"]["options"]["stroke"];
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0], text);
  EXPECT_EQ(read_json(folder / "run/selection_sheet.json"), cells);
  EXPECT_EQ(run_quietly({"segment", scene, "--out", out, "--click", "selection,2,700"}),
            2);  // the legend
}

}  // namespace
}  // namespace pliant
