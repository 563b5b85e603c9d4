// The hand of a person in clip.html: when it lets go.

#include <algorithm>

#include "app/page/page_assets.h"
#include "tests/app/page/clip_page.h"

using nlohmann::json;

namespace pliant {
namespace {

TEST_F(ClipPageTest, AtTheEndOfAReplayTheHandLetsGo) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + names_of_top(0.1f) + R"(
    await pliant.ready;
    await pliant.solver.ready;
    pliant.setLevel(pliant.solver.levels.length - 1);
    const grab = pliant.grab(place, radius);
    pliant.begin({type: 'pin', centre: place, radius});
    pliant.drag(grab, hand);
    await pliant.advance(20);
    const open = pliant.recording().interactions[0].duration ?? null;
    pliant.reset();
    pliant.replay();
    await pliant.advance(21);
    const {forces} = await pliant.advance(1), {solver_fps, interactions} = pliant.recording();
    return {open, fps: solver_fps, interactions, held: forces.some(([number]) => number === grab),
      errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["errors"], json::array());
  EXPECT_EQ(value["open"], nullptr) << "the hand was there when the recording ended";
  ASSERT_EQ(value["interactions"].size(), 2u);
  ASSERT_TRUE(value["interactions"][0].contains("duration")) << value["interactions"];
  EXPECT_NEAR(value["interactions"][0]["duration"], 20 / value["fps"].get<double>(), 1e-9);
  EXPECT_EQ(value["held"], false);
  EXPECT_FALSE(value["interactions"][1].contains("duration")) << "pins stay";
}

TEST_F(ClipPageTest, AClipThatStandsStillFromTheStartCanBeHeld) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate(R"((async () => {
    await pliant.ready;
    const press = (key) => document.body.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true}));
    press(' ');
    await pliant.solver.ready;
    for (let k = 0; k < 60 && !pliant.live(); ++k) {
      press('g');
      await new Promise((next) => setTimeout(next, 50));
    }
    return {live: pliant.live(), errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["value"], json({{"live", true}, {"errors", json::array()}}));
}

TEST_F(ClipPageTest, AKeyThatIsHeldDownTogglesOnceAndStepsOn) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + kPress + R"(
    for (let k = 0; k < 9; ++k) press('ArrowRight', true);
    const stepped = frame();
    await hold();
    for (let k = 0; k < 9; ++k) press('g', true);
    await until(() => pliant.recording()?.interactions.length > 0);
    return {stepped, interactions: pliant.recording().interactions, errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["errors"], json::array());
  EXPECT_EQ(value["stepped"], 9);
  ASSERT_EQ(value["interactions"].size(), 1u) << value["interactions"];
  EXPECT_FALSE(value["interactions"][0].contains("duration"));
}

// The first finger of two that turn the camera may lie on the object.
TEST_F(ClipPageTest, PinsAreMadeByATapAndNotByAPinch) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + kPress + kTouch + R"(
    press('5');
    const pins = () => pliant.recording()?.interactions.filter(({type}) => type === 'pin').length ?? 0;
    const place = await find();
    touch('pointerdown', 2, place[0] + 40, place[1]);
    touch('pointerup', 2, place[0] + 40, place[1]);
    touch('pointerup', 1, ...place);
    await until(() => pliant.recording()?.frames > 5);
    const pinched = pins();
    touch('pointerdown', 1, ...place);
    touch('pointerup', 1, ...place);
    await until(() => pins() > 0);
    return {pinched, tapped: pins(), live: pliant.live(), errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["value"], json({{"pinched", 0}, {"tapped", 1}, {"live", true}, {"errors", json::array()}}));
}

// Between two pictures the hand has no other place than that of the pointer.
TEST_F(ClipPageTest, APushThatIsQuickerThanAPictureGoesWhereItWasAimed) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + kPress + kTouch + R"(
    press('3');
    const place = await find();
    touch('pointermove', 1, place[0] + 60, place[1]);
    touch('pointerup', 1, place[0] + 60, place[1]);
    await until(() => pliant.recording().interactions.length > 0);
    const [{type, impulse}] = pliant.recording().interactions;
    const right = JSON.parse(document.getElementById('clip-header').textContent).clip.camera.cam_from_world.slice(0, 3);
    return {type, length: Math.hypot(...impulse), along: impulse.reduce((sum, x, c) => sum + x * right[c], 0),
      errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["errors"], json::array());
  EXPECT_EQ(value["type"], "impulse");
  EXPECT_GT(value["length"].get<double>(), 0);
  EXPECT_GT(value["along"].get<double>(), 0.99 * value["length"].get<double>()) << "to the right, as the drag";
}

TEST_F(ClipPageTest, AFingerPullsAndKeepsHoldWhileTheTabIsHidden) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + kPress + kTouch + R"(
    const place = await find(), frames = () => pliant.recording().frames;
    const rest = Array.from(pliant.drivers());
    for (let k = 1; k <= 10; ++k) touch('pointermove', 1, place[0] + 6 * k, place[1]);
    await until(() => frames() > 5);
    const moved = Math.max(...pliant.drivers().map((x, i) => Math.abs(x - rest[i])));
    Object.defineProperty(document, 'hidden', {get: () => true, configurable: true});
    await new Promise((next) => setTimeout(next, 200));  // what is under way comes to its end
    const before = frames();
    await new Promise((next) => setTimeout(next, 600));
    const waited = frames() - before;
    delete document.hidden;
    await until(() => frames() > before);
    const open = pliant.recording().interactions[0].duration ?? null, goes = frames() > before;
    touch('pointerup', 1, place[0] + 60, place[1]);
    await until(() => pliant.recording().interactions[0].duration);
    return {moved, waited, goes, open, closed: pliant.recording().interactions[0].duration > 0,
      count: pliant.recording().interactions.length, errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  json value = answer["value"];
  EXPECT_GT(value["moved"].get<double>(), 0.01 * height());
  value.erase("moved");
  EXPECT_EQ(value, json({{"waited", 0},
                         {"goes", true},
                         {"open", nullptr},
                         {"closed", true},
                         {"count", 1},
                         {"errors", json::array()}}));
}

TEST_F(ClipPageTest, APinIsShownWhereItIsThoughOneOfAnEarlierSessionHadItsNumber) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const Vec3f foot = lowest_and_highest().first;
  const json answer = evaluate("(async () => {" + kPress + names_of_top(0.1f) +
                               "const foot = " + json({foot.x(), foot.y(), foot.z()}).dump() + R"(;
    pliant.setLevel(0);
    press('5');
    // The place of the newest ring once it is drawn; `is` says which ring it has to be.
    const ringOf = async (centre, is) => {
      const number = pliant.begin({type: 'pin', centre, radius});
      let at = [];
      for (let tries = 0; tries < 100 && !is(at); ++tries) {
        await new Promise((next) => setTimeout(next, 100));
        const ring = [...document.querySelectorAll('#overlay .pin')].at(-1);
        if (ring) at = ['cx', 'cy'].map((name) => Number(ring.getAttribute(name)));
      }
      return {number, at};
    };
    const first = await ringOf(foot, (at) => at.length > 0);
    pliant.reset();
    const apart = (at) => Math.hypot(...at.map((x, c) => x - first.at[c]));
    const second = await ringOf(place, (at) => apart(at) > 20);
    return {same: first.number === second.number, apart: apart(second.at), errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["value"]["errors"], json::array());
  EXPECT_EQ(answer["value"]["same"], true);
  EXPECT_GT(answer["value"]["apart"].get<double>(), 20) << "px from the foot to the top";
}

// What was done while the failing frame was under way: a held pin that was let go is gone, and the settings are those
// that the page shows.
TEST_F(ClipPageTest, AfterAFailureTheSolverDoesWhatThePageSays) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + kPress + R"(
    const {forces: before} = await pliant.advance(1);
    pliant.setSettings({stiffness: 1e6});
    const failing = pliant.advance(1);
    pliant.setSettings({stiffness: 2});
    const behind = pliant.advance(1);
    pliant.release(0);
    const {failed} = await failing;
    await behind;
    const {forces: after} = await pliant.advance(1);
    return {failed, before, after, recording: pliant.recording()};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json &value = answer["value"], &recording = value["recording"];
  ASSERT_TRUE(value["failed"].is_string());
  const auto acts = [](const json& forces) {
    return std::any_of(forces.begin(), forces.end(), [](const json& force) { return force[0] == 0; });
  };
  EXPECT_TRUE(acts(value["before"]));
  EXPECT_FALSE(acts(value["after"]));
  EXPECT_EQ(recording["unpinned"], json::parse(R"([{"frame": 3, "held": 0}])"));
  EXPECT_EQ(recording["settings"].back()["frame"], 3);
  EXPECT_EQ(recording["settings"].back()["young_scale"], 1);
}

// What the solver does by itself where it fails is in the recording; so is a grab whose session ended with its frame.
TEST_F(ClipPageTest, ARecordingSaysWhatTheSolverGaveUpAndCanBeReplayed) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + names_of_top(0.1f) + R"(
    await pliant.ready;
    await pliant.solver.ready;
    pliant.setLevel(pliant.solver.levels.length - 1);
    pliant.grab(place, radius);
    const under = pliant.advance(1);
    pliant.reset();
    await under;
    const left = pliant.recording();
    const grab = pliant.grab(place, radius);
    pliant.drag(grab, hand);
    await pliant.advance(8);
    pliant.begin({type: 'wind', strength: [1, 0, 0]});
    pliant.setSettings({stiffness: 1e6});
    const {failed} = await pliant.advance(1);
    await pliant.advance(4);
    return {left, failed, recording: pliant.recording()};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json &value = answer["value"], &recording = value["recording"];
  ASSERT_TRUE(value["failed"].is_string());
  EXPECT_EQ(recording["frames"], 13);
  ASSERT_EQ(recording["interactions"].size(), 1u) << "the wind never blew: " << recording["interactions"];
  EXPECT_NEAR(recording["interactions"][0]["duration"], 8 / recording["solver_fps"].get<double>(), 1e-9);
  for (const json& settings : recording["settings"]) {
    EXPECT_GE(settings["frame"].get<int>(), 8);
    EXPECT_TRUE(settings["young_scale"] == 1 || settings == recording["settings"][0]) << settings;
  }
  EXPECT_EQ(recording["settings"][1]["frame"], 8) << "what follows the failure";
  for (const char* name : {"left", "recording"}) {
    write_text(folder / "recording.json", value[name].dump());
    EXPECT_EQ(run_quietly({"simulate", (folder / "run").string(), "--recording", (folder / "recording.json").string()}),
              0)
        << name;
  }
}

TEST_F(ClipPageTest, WhereTheProgramLeavesTheArrowsGoThroughTheRecordingAgain) {
  const auto live = std::make_shared<const LiveScene>(load_live_scene(*run_, scene_, "view"));
  const json answer = evaluate_served("(async () => {" + kPress + R"(
    await hold();
    const start = frame();
    press('ArrowRight');
    const before = frame();
    await fetch(new URL('leave', location.href));
    await until(() => !document.getElementById('alert').hidden);
    press('ArrowRight');
    return {start, before, after: frame(), frames: pliant.frames, live: pliant.live(), said: document.getElementById('alert-text').textContent};
  })())",
                                      live, folder / "run/recordings");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["before"], value["start"]) << "the arrow moved the hand";
  EXPECT_EQ(value["live"], false);
  EXPECT_EQ(value["after"], (value["start"].get<int>() + 1) % value["frames"].get<int>()) << value["said"];
}

TEST_F(ClipPageTest, WhereTheConnectionEndedTheNextHandConnectsAgain) {
  const auto live = std::make_shared<const LiveScene>(load_live_scene(*run_, scene_, "view"));
  const json answer = evaluate_served("(async () => {" + kPress + R"(
    await hold();
    await fetch(new URL('leave', location.href));
    await until(() => !document.getElementById('alert').hidden);
    const said = document.getElementById('alert').textContent, left = pliant.live();
    await hold();
    const {substeps, forces} = await pliant.advance(2);
    return {said, left, substeps, forces: forces.length};
  })())",
                                      live, folder / "run/recordings");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_NE(value["said"].get<std::string>().find("Reload this page"), std::string::npos) << value["said"];
  EXPECT_EQ(value["left"], false);
  EXPECT_GT(value["substeps"].get<int>(), 0);
  EXPECT_EQ(value["forces"], live->setup.held.size() + 1) << "the hand";
}

}  // namespace
}  // namespace pliant
