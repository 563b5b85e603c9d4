// clip.html in a browser: it shows what `render` shows, and what a person does in it is what `simulate` does natively.

#include "tests/app/page/clip_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/live/live_client.h"
#include "app/live/live_view.h"
#include "app/page/page_assets.h"
#include "app/simulate/clip_camera.h"
#include "app/simulate/driver_level.h"
#include "app/simulate/moving_scene.h"
#include "gaussians/render/render.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

constexpr int kWidth = 320, kHeight = 240;

TEST_F(ClipPageTest, ShowsWhatRenderShowsAtRestAndDeformed) {
  Camera camera = clip_camera(scene_, "", robust_bounds(moving_.object)).resized(kWidth, kHeight);
  const size_t last = moving_.trajectory.frames.size() - 1;
  const json answer = evaluate(R"((async () => {
    await pliant.ready;
    const camera = JSON.parse(document.getElementById('clip-header').textContent).clip.camera;
    const [w, h] = [320, 240], sx = w / camera.width, sy = h / camera.height;
    const small = {...camera, width: w, height: h, fx: camera.fx * sx, cx: camera.cx * sx, fy: camera.fy * sy,
      cy: camera.cy * sy};
    const pictures = [];
    for (const frame of [0, pliant.frames - 1]) {
      await pliant.showFrame(frame, small);
      pictures.push(Array.from(await pliant.readPixels(w, h)));
    }
    return {pictures, frames: pliant.frames, violations: pliant.violations, errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["violations"], json::array()) << "of the content security policy";
  EXPECT_EQ(value["errors"], json::array());
  EXPECT_EQ(answer["said"], json::array());
  ASSERT_EQ(value["frames"], last + 1);
  for (const int k : {0, 1}) {
    const RenderResult expected = render(moving_.all_at(moving_.trajectory.frames[k == 0 ? 0 : last]), camera);
    const std::vector<int> pixels = value["pictures"][k];
    ASSERT_EQ(pixels.size(), 4 * kWidth * kHeight);
    double sum = 0, count = 0;
    for (int p = 0; p < kWidth * kHeight; ++p) {
      if (expected.alpha.data[p] <= 0.05f) continue;
      for (int c = 0; c < 3; ++c)
        sum += std::pow(pixels[4 * p + c] / 255.0 - std::clamp(expected.color.data[3 * p + c], 0.0f, 1.0f), 2);
      count += 3;
    }
    const double psnr = -10 * std::log10(sum / count);
    std::printf("[ frame %s ] %.1f dB over %.0f pixels, drawn into RGBA16F\n", k == 0 ? "0" : "last", psnr, count / 3);
    EXPECT_GE(psnr, 38);
  }
}

TEST_F(ClipPageTest, ADragMovesTheObjectAsTheNativeReplayOfItsRecordingDoes) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const Drag drag = this->drag(page(), folder / "run");
  EXPECT_GT(drag.newtons, 0.001);
  EXPECT_GT(drag.farthest, 0.2 * height());
  EXPECT_LT(drag.worst, 0.02 * height());
}

TEST_F(ClipPageTest, ACoarserBodyBeginsInTheMiddleOfTheClipAsTheNativeOneDoes) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const auto mean_square = [](const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
    return sum / static_cast<double>(a.size());
  };
  const std::vector<TrajectoryFile::Frame>& frames = moving_.trajectory.frames;
  const auto motion = [&](const TrajectoryFile::Frame& frame) {
    return mean_square(frame.position, moving_.particles.driving_position);
  };
  const auto farthest = std::max_element(frames.begin(), frames.end(),
                                         [&](const auto& a, const auto& b) { return motion(a) < motion(b); });
  const auto start = static_cast<size_t>(farthest - frames.begin());
  const json answer = evaluate("(async () => { const start = " + std::to_string(start) + R"(;
    await pliant.ready;
    await pliant.solver.ready;
    const level = pliant.solver.levels.length - 1;
    pliant.setLevel(level);
    await pliant.showFrame(start);
    await pliant.advance(0);
    return {level, drivers: Array.from(pliant.drivers()), recording: pliant.recording(), errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["errors"], json::array());
  EXPECT_EQ(value["recording"]["start_frame"], start);
  if (value["level"] == 0) GTEST_SKIP() << "the page has no coarser body";
  const ParticleFile body = with_drivers(moving_.particles, scene_, value["recording"]["clustered_to"]);
  const std::vector<Vec3f> expected = motion_of(moving_, body)[start].position;
  const std::vector<float> numbers = value["drivers"];
  ASSERT_EQ(numbers.size(), 3 * expected.size());
  std::vector<Vec3f> shown;
  for (size_t i = 0; i < numbers.size(); i += 3) shown.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  const double difference = std::sqrt(mean_square(shown, expected));
  const double moved = std::sqrt(mean_square(expected, body.driving_position));
  std::printf("[ start ] motion %.3g of the height, difference %.2g\n", moved / height(), difference / height());
  EXPECT_LT(difference, 0.05 * moved);
}

TEST_F(ClipPageTest, TheDriversStayThoseOfTheFrameThatIsShown) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const json answer = evaluate("(async () => {" + kPress + R"(
    const shown = async () => {
      for (let k = 0; k < 3; ++k) await new Promise((next) => requestAnimationFrame(next));
      return Array.from(pliant.drivers());
    };
    const colour = document.getElementById('colour-by'), equal = (a, b) => a.every((x, i) => x === b[i]);
    for (let k = 0; k < 14; ++k) press('ArrowRight');  // by the push, from .3 s on
    const next = await shown();
    press('ArrowLeft');
    const before = await shown();
    colour.value = 'speed';
    colour.dispatchEvent(new Event('change'));
    const after = await shown();
    return {frame: frame(), moves: !equal(before, next), stay: equal(before, after), errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["value"], json({{"frame", 13}, {"moves", true}, {"stay", true}, {"errors", json::array()}}));
}

// Plasticine stays where it was pulled to.
TEST_F(ClipPageTest, AMaterialThatYieldsIsPulledFromTheFirstFrameOn) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const fs::path plastic = folder / "plastic", clip = folder / "plastic.html";
  fs::copy(folder / "run", plastic, fs::copy_options::recursive);
  ASSERT_EQ(run_quietly({"simulate", plastic.string(), "--young", "2e4", "--poisson", "0.3", "--density", "400",
                         "--law", "plasticine", "--yield-stress", "600", "--duration", "0.3"}),
            0);
  ASSERT_EQ(run_quietly({"export", plastic.string(), "--html", clip.string()}), 0);
  const Drag drag = this->drag(clip, plastic, R"(
    for (const key of ['Home', ...Array(5).fill('ArrowRight')])  // from the first frame: the clip plays by itself
      document.body.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true}));
  )");
  EXPECT_EQ(drag.recording["start_frame"], 0);
  EXPECT_NE(drag.said.find("where the clip begins"), std::string::npos) << drag.said;
  EXPECT_GT(drag.farthest, 0.2 * height());
  EXPECT_GT(drag.left, 0.1 * height());
  EXPECT_LT(drag.worst, 0.02 * height());
}

TEST_F(ClipPageTest, PushesAreOverAfterTheirFrameHoweverManyThereAre) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const Vec3f place = moving_.particles.driving_position.front();
  const json answer = evaluate("(async () => { const place = " + json({place.x(), place.y(), place.z()}).dump() +
                               ", radius = " + std::to_string(moving_.particles.cell_size) + R"(;
    await pliant.ready;
    await pliant.solver.ready;
    const failed = [];
    for (let k = 0; k < 40; ++k) {
      pliant.begin({type: 'impulse', centre: place, radius, strength: [1e-6, 0, 0]});
      failed.push((await pliant.advance(1)).failed);
    }
    return {failed: failed.filter(Boolean), pushes: pliant.recording().interactions.length, errors: pliant.errors};
  })())");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["value"]["failed"], json::array());
  EXPECT_EQ(answer["value"]["errors"], json::array());
  EXPECT_EQ(answer["value"]["pushes"], 40);
}

// The page of `pliant view` is moved by this program, and the recording that stays gives the same motion.
TEST_F(ClipPageTest, ServedItIsMovedByTheProgramAndLeavesItsRecording) {
  const auto live = std::make_shared<const LiveScene>(load_live_scene(*run_, scene_, "view"));
  const fs::path recordings = folder / "run/recordings";
  fs::remove_all(recordings);
  const std::vector<Vec3f>& rest = moving_.particles.driving_position;
  const Vec3f top = *std::max_element(rest.begin(), rest.end(), [&](const Vec3f& a, const Vec3f& b) {
    return a.dot(scene_.up.cast<float>()) < b.dot(scene_.up.cast<float>());
  });
  const double height = live->setup.height / scene_.metres_per_unit;
  const json answer = evaluate_served("(async () => { const place = " + json({top.x(), top.y(), top.z()}).dump() +
                                          ", height = " + std::to_string(height) + R"(;
    await pliant.ready;
    await pliant.solver.ready;
    pliant.setLevel(0);
    const grab = pliant.grab(place, 0.2 * height);
    for (let k = 1; k <= 15; ++k) {
      pliant.drag(grab, [0.02 * k * height, 0, 0]);
      await pliant.advance(1);
    }
    return {drivers: Array.from(pliant.drivers()), violations: pliant.violations, errors: pliant.errors};
  })())",
                                      live, recordings);
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["value"]["violations"], json::array());
  EXPECT_EQ(answer["value"]["errors"], json::array());
  const fs::path recording = recordings / "live_0001.json";
  ASSERT_TRUE(fs::exists(recording));
  ASSERT_EQ(run_quietly({"simulate", (folder / "run").string(), "--recording", recording.string()}), 0);
  const TrajectoryFile again = read_trajectory(folder / "run" / object_folder(*run_) / "recording.h5");
  const std::vector<float> shown = answer["value"]["drivers"];
  ASSERT_EQ(again.frames.size(), 16u);
  ASSERT_EQ(shown.size(), 3 * rest.size());
  double worst = 0, farthest = 0;
  for (size_t i = 0; i < rest.size(); ++i) {
    const Vec3f x(shown[3 * i], shown[3 * i + 1], shown[3 * i + 2]);
    worst = std::max<double>(worst, (x - again.frames.back().position[i]).norm());
    farthest = std::max<double>(farthest, (x - again.frames.front().position[i]).norm());
  }
  EXPECT_LT(worst, 1e-4 * height) << "as exactly as it is sent";
  EXPECT_GT(farthest, 0.1 * height);
}

// What cannot begin ends alone, and what only the server knows is said.
TEST_F(ClipPageTest, ServedItSaysWhatIsRefusedAndThatNothingIsKept) {
  const auto live = std::make_shared<const LiveScene>(load_live_scene(*run_, scene_, "view"));
  write_text(folder / "blocked", "a file");
  const json answer = evaluate_served(R"((async () => {
    await pliant.ready;
    await pliant.solver.ready;
    pliant.setLevel(0);
    const wind = pliant.begin({type: 'wind', strength: [1, 0, 0]});
    await pliant.advance(1);
    const status = document.getElementById('status');
    for (let k = 0; k < 100 && !status.textContent; ++k) await new Promise((next) => setTimeout(next, 50));
    const kept = status.textContent;
    pliant.grab([9000, 9000, 9000], 0.001);
    const {failed, forces} = await pliant.advance(2);
    const blows = forces.some(([number, ...force]) => number === wind && Math.hypot(...force) > 0);
    return {kept, failed, blows, errors: pliant.errors, live: pliant.live()};
  })())",
                                      live, folder / "blocked/recordings");
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  ASSERT_EQ(value["errors"].size(), 1u) << value;
  EXPECT_NE(value["errors"][0].get<std::string>().find("has no effect"), std::string::npos) << value;
  EXPECT_EQ(value["live"], true);
  EXPECT_EQ(value["blows"], true) << value;
  EXPECT_EQ(value["failed"], json());
  EXPECT_NE(value["kept"].get<std::string>().find("cannot be kept"), std::string::npos) << value;
}

// Where E was predicted the slider goes along its band: 0 = its high end, 0.5 = the typical value, 1 = its low end.
TEST_F(ClipPageTest, OfAPredictedMaterialHasASliderOfSoftness) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const std::string run = (folder / "run").string();
  const fs::path predicted = folder / "predicted.html";
  ASSERT_EQ(run_quietly({"predict", run, "--label", "flower", "--softness", "0.5"}), 0);
  ASSERT_EQ(run_quietly({"simulate", run, "--duration", "0.1"}), 0);
  ASSERT_EQ(run_quietly({"export", run, "--html", predicted.string()}), 0);
  const json band = json::parse(read_text(folder / "run/run.json"))["stages"]["predict"]["summary"]["young_band"];
  const json answer = evaluate(R"((async () => {
    await pliant.ready;
    await pliant.solver.ready;
    const slider = document.getElementById('stiffness'), read = document.getElementById('stiffness-value');
    const start = Number(slider.value), texts = [];
    for (const value of ['0', '0.5', '1']) {
      slider.value = value;
      slider.dispatchEvent(new Event('input'));
      texts.push(read.textContent);
    }
    return {name: slider.labels[0].firstElementChild.textContent, start, texts, errors: pliant.errors,
            about: document.getElementById('details').textContent};
  })())",
                               predicted);
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  const json& value = answer["value"];
  EXPECT_EQ(value["errors"], json::array());
  EXPECT_EQ(value["name"], "Softness");
  EXPECT_NEAR(value["start"], 0.5, 1e-6);
  const auto factor = [&](int k) {
    const std::string text = value["texts"][k];
    return std::stod(text.substr(text.find("×") + std::string("×").size()));
  };
  const double typical = band["typical"];
  EXPECT_NEAR(factor(0), band["high"].get<double>() / typical, 0.06 * factor(0));
  EXPECT_EQ(factor(1), 1);
  EXPECT_NEAR(factor(2), band["low"].get<double>() / typical, 0.06 * factor(2));
  EXPECT_NE(value["about"].get<std::string>().find("predicted"), std::string::npos);
}

TEST_F(ClipPageTest, SaysInWordsWhatIsWrongWithADamagedFile) {
  const std::string whole = read_text(page());
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string out = whole;
    out.replace(out.find(from), from.size(), to);
    return out;
  };
  const size_t object = whole.find("id=\"clip-object\">");
  std::string damaged = whole;
  for (size_t k = object + 1000; k < object + 1400; ++k) damaged[k] = 'A';
  const std::map<std::string, std::string> files = {{"a later version", changed("\"version\":1", "\"version\":99")},
                                                    {"a cut file", whole.substr(0, object + 5000)},
                                                    {"changed bytes", damaged}};
  for (const auto& [name, text] : files) {
    write_text(folder / "damaged.html", text);
    const json answer = evaluate(R"((async () => {
      const failed = await Promise.race([pliant.ready.then(() => false, () => true),
        new Promise((done) => setTimeout(done, 20000, 'hangs'))]);
      return {failed, said: document.getElementById('alert-text').textContent,
        hidden: document.getElementById('alert').hidden};
    })())",
                                 folder / "damaged.html");
    ASSERT_TRUE(answer.contains("value")) << name << ": " << answer.dump().substr(0, 2000);
    EXPECT_EQ(answer["value"]["failed"], true) << name << ": " << answer["value"].dump();
    EXPECT_EQ(answer["value"]["hidden"], false) << name;
    EXPECT_GT(answer["value"]["said"].get<std::string>().size(), 20) << name;
    std::printf("[ %s ] %s\n", name.c_str(), answer["value"]["said"].get<std::string>().c_str());
  }
}

}  // namespace
}  // namespace pliant
