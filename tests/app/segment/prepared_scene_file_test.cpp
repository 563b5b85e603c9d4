#include "app/segment/prepared_scene_file.h"

#include <gtest/gtest.h>

#include "gaussians/io/files/files.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

class PreparedSceneFile : public ::testing::Test {
 protected:
  PreparedSceneFile() {
    options_.view_pixels = 60;
    prepared_ = prepare_scene(options_, made_.cloud, made_.cameras);
    write_prepared_scene(file_, "key", prepared_);
  }
  std::optional<PreparedScene> read(const std::string& key = "key") const {
    return read_prepared_scene(file_, key, options_, made_.cameras);
  }

  const TemporaryFolder folder_;
  const fs::path file_ = folder_ / "prepared_scene.bin";
  const MadeScene made_ = made_scene({{{0, 0, 0.2f}, 0.3f, 1, {0.8f, 0.1f, 0.1f}}}, 6, 60, 45, 0.1f, 0.1f);
  PrepareOptions options_;
  PreparedScene prepared_;
};

TEST_F(PreparedSceneFile, ReadsWhatWasWritten) {
  const std::optional<PreparedScene> back = read();
  ASSERT_TRUE(back);
  EXPECT_EQ(back->graph.nodes, prepared_.graph.nodes);
  EXPECT_EQ(back->graph.edge_nearness, prepared_.graph.edge_nearness);
  EXPECT_EQ(back->parts.part, prepared_.parts.part);
  EXPECT_EQ(back->shown, prepared_.shown);
  EXPECT_EQ(back->diagonal, prepared_.diagonal);
  ASSERT_EQ(back->views.size(), prepared_.views.size());
  ASSERT_FALSE(back->views.empty());
  for (size_t k = 0; k < back->views.size(); ++k) {
    EXPECT_EQ(back->views[k].window.source, prepared_.views[k].window.source);
    EXPECT_EQ(back->views[k].region, prepared_.views[k].region);
    EXPECT_EQ(back->views[k].weight, prepared_.views[k].weight);
  }
  EXPECT_FALSE(read("another key"));
}

TEST_F(PreparedSceneFile, ADamagedOneIsNotTaken) {
  const std::string whole = read_text(file_);
  const auto expect_refused = [&](const std::string& bytes, const std::string& what) {
    write_text(file_, bytes);
    EXPECT_FALSE(read()) << what;
  };
  for (const size_t size : {size_t{0}, size_t{10}, size_t{40}, size_t{100}, whole.size() / 2, whole.size() - 1})
    expect_refused(whole.substr(0, size), "cut to " + std::to_string(size));
  expect_refused(whole + "x", "one byte too long");
  for (size_t at = 0; at < whole.size(); at += 1 + whole.size() / 200) {
    std::string bytes = whole;
    bytes[at] ^= 0x10;
    expect_refused(bytes, "changed at " + std::to_string(at));
  }
  // A sound digest of what does not fit together: lengths that reach beyond the file.
  const size_t head = whole.find("key\n") + 4, digest = 64;
  std::string body(whole.size() - head - digest, '\xff');
  expect_refused(whole.substr(0, head) + sha256_of_text(body) + body, "absurd lengths");
  write_text(file_, whole);
  EXPECT_TRUE(read());
}

}  // namespace
}  // namespace pliant
