// What clip.html saves of what was done in it.

#include "app/page/page_assets.h"
#include "tests/app/page/clip_page.h"

using nlohmann::json;

namespace pliant {
namespace {

TEST_F(ClipPageTest, ARecordingIsSavedWholeWhileItIsDoneAgainUntilSomethingElseIsDone) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + names_of_top(0.1f) + R"(
    await pliant.ready;
    await pliant.solver.ready;
    pliant.setLevel(pliant.solver.levels.length - 1);
    const status = () => document.getElementById('status').textContent, frames = () => pliant.recording().frames;
    const grab = pliant.grab(place, radius);
    pliant.drag(grab, hand);
    await pliant.advance(20);
    pliant.reset();
    pliant.replay();
    await pliant.advance(5);
    const during = frames();
    pliant.reset();
    const left = frames();
    pliant.replay();
    await pliant.advance(5);
    const before = status();
    pliant.setSettings({stiffness: 2});
    await pliant.advance(1);
    return {during, left, before, broken: frames(), said: status(), errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["errors"], json::array());
  EXPECT_EQ(value["during"], 20);
  EXPECT_EQ(value["left"], 20);
  EXPECT_EQ(value["broken"], 6) << "what was done again, and what is new";
  EXPECT_EQ(value["before"].get<std::string>().find("dropped"), std::string::npos) << value["before"];
  EXPECT_NE(value["said"].get<std::string>().find("dropped"), std::string::npos) << value["said"];
}

TEST_F(ClipPageTest, SavedForcesSayWhatTheyLeaveOut) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + kPress + names_of_top(0.1f) + R"(
    const files = [], save = document.getElementById('save-interactions');
    URL.createObjectURL = (blob) => {
      files.push(blob);
      return '#';
    };
    HTMLAnchorElement.prototype.click = () => {};
    await until(() => frame() > 2 || (press('ArrowRight'), false));
    pliant.begin({type: 'pin', centre: place, radius});
    pliant.setSettings({stiffness: 4});
    await pliant.advance(3);
    await until(() => !save.disabled);
    save.click();
    return {forces: JSON.parse(await files[0].text()), said: document.getElementById('status').textContent,
      recording: pliant.recording(), errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["errors"], json::array());
  ASSERT_EQ(value["forces"].size(), 1u);
  EXPECT_EQ(value["forces"][0]["type"], "pin");
  const std::string said = value["said"];
  const int start = value["recording"]["start_frame"];
  EXPECT_GT(start, 0);
  for (const std::string& part : {std::string("stiffness ×4"), "beginning at frame " + std::to_string(start)})
    EXPECT_NE(said.find(part), std::string::npos) << said;
  const LiveScene live = load_live_scene(*run_, scene_, "view");
  EXPECT_EQ(value["recording"]["held"], live.setup.held.size());
  EXPECT_EQ(value["recording"]["object"], live.object);
  EXPECT_EQ(value["recording"]["simulated"], live.simulated);
}

}  // namespace
}  // namespace pliant
