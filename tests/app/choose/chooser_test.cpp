// The choice of an object in the browser, and what the stages make of it.

#include "app/choose/chooser.h"

#include <gtest/gtest.h>

#include "app/live/live_view.h"
#include "app/segment/objects_file.h"
#include "app/segment/prepared_scene_file.h"
#include "app/segment/segment_stage.h"
#include "app/simulate/moving_scene.h"
#include "segmentation/select/gesture_prompts.h"
#include "tests/app/choose/choice.h"
#include "tests/app/finished_stage.h"
#include "tests/app/live/site_in_browser.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

TEST(ChoosePage, WhatAFileIsCalledEndsNoElement) {
  const LocalServer::Page page = choose_page({{"title", "</script><!--<script>alert(1)</script>"}});
  EXPECT_EQ(page.body.find("<!--<script>alert"), std::string::npos);
  EXPECT_NE(page.body.find("\\u003c/script>\\u003c!--\\u003cscript>alert(1)"), std::string::npos);
  EXPECT_EQ(page.security_policy.find("default-src 'none'"), 0u);
}

TEST_F(Choice, EveryPixelOfAViewHasItsThing) {
  const json shown = data();
  ASSERT_FALSE(shown["views"].empty());
  for (const json& view : shown["views"]) {
    size_t pixels = 0;
    for (size_t k = 1; k < view["ids"].size(); k += 2) pixels += view["ids"][k].get<size_t>();
    EXPECT_EQ(pixels, view["width"].get<size_t>() * view["height"].get<size_t>());
  }
}

TEST_F(Choice, WhatIsChosenIsMadeReadyAndThenShownToBeMoved) {
  EXPECT_EQ(page().find("pliant-live\""), std::string::npos);
  client_->receive(json({{"make", {{"object", plant()}, {"label", "potted plant"}}}}).dump());
  EXPECT_EQ(await("busy"), "make");
  EXPECT_TRUE(await("progress").is_object());
  EXPECT_EQ(await("reload"), true);
  EXPECT_NE(said_.find("simulate: "), std::string::npos) << said_;
  EXPECT_EQ(said_.find("--duration"), std::string::npos) << "nobody chose how long it is: " << said_;
  EXPECT_NE(page().find("pliant-live\""), std::string::npos);
  EXPECT_TRUE(run_->has("simulate"));
  EXPECT_EQ(run_->manifest()["stages"]["predict"]["options"]["label"], "potted plant");
  const auto inbox = std::make_shared<Inbox>();
  const auto mover = site_.handler().connect(inbox);
  mover->receive(R"({"id": 1, "frames": 1})");
  EXPECT_EQ(inbox->next().substr(0, 4), "PLNT");
  // Behind it the hole closes.
  EXPECT_EQ(await("busy"), "");
  EXPECT_NE(inbox->next().find("repaired"), std::string::npos) << "who moves it is told";
  EXPECT_EQ(moving_scene_files(*run_).at("background"), *run_ / "background_repaired.ply");
  EXPECT_NE(page().find("pliant-live\""), std::string::npos);
}

TEST_F(Choice, AFitOfOtherParticlesOrAnUnfinishedOneKeepsNoObjectFromBeingMoved) {
  json fit = finished_stage(json::object(), json::array({"fit/results.json", object_folder(*run_) + "/material.h5"}));
  fit["inputs"]["particles"] = "hash of others";
  const json begun = {{"replaced", {{"record", fit}, {"moved", json::array()}, {"written", json::array()}}}};
  for (const bool finished : {true, false}) {
    stop();
    json record = json::parse(read_text(*run_ / "run.json"));
    record["stages"].erase("fit");
    if (finished)
      record["stages"]["fit"] = fit;
    else
      record["begun"]["fit"] = begun;
    write_text(*run_ / "run.json", record.dump());
    run_ = std::make_unique<RunDirectory>(RunDirectory::open(folder / "choice"));
    start();
    said_.clear();
    client_->receive(json({{"make", {{"object", plant()}, {"label", "potted plant"}}}}).dump());
    EXPECT_EQ(await("reload"), true);
    EXPECT_NE(said_.find(finished ? "not used: it was made with other particles" : "not used: one that is to replace"),
              std::string::npos)
        << said_;
    EXPECT_EQ(await("busy"), "");
  }
}

// In the browser: a row of the contact sheet shows its object as the view does and darkens what is around it.
TEST_F(Choice, TheContactSheetShowsEveryObject) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json answer = evaluate_in_site("(async () => { const wanted = " + std::to_string(plant()) + R"(;
    const brightness = [0, 0], reference = [0, 0], place = placesOfThings().get(wanted);
    await Promise.all(data.views.map((view) => view.image.decode()));
    const crops = document.querySelectorAll('.thing canvas');
    const crop = document.querySelector(`input[name=thing][value="${wanted}"]`).parentElement.querySelector('canvas');
    drawCrop(crop, wanted, place);
    const whole = new OffscreenCanvas(place.view.width, place.view.height);
    whole.getContext('2d').drawImage(place.view.image, 0, 0);
    const pixels = (of, x, y) => of.getContext('2d').getImageData(x, y, 1, 1).data.slice(0, 3).reduce((a, b) => a + b);
    const {low, high, view} = place, side = 1.2 * Math.max(high[0] - low[0] + 1, high[1] - low[1] + 1);
    for (let y = 2; y < 112; y += 4)
      for (let x = 2; x < 112; x += 4) {
        const u = Math.floor((low[0] + high[0] + 1 - side) / 2 + (x + 0.5) * side / 112);
        const v = Math.floor((low[1] + high[1] + 1 - side) / 2 + (y + 0.5) * side / 112);
        if (u < 0 || v < 0 || u >= view.width || v >= view.height) continue;
        const inside = Number(view.id[v * view.width + u] === wanted);
        brightness[inside] += pixels(crop, x, y);
        reference[inside] += pixels(whole, u, v);
      }
    const unseen = data.views.findIndex((other) => !other.id.includes(wanted));
    if (unseen >= 0) at = unseen;
    document.querySelector(`input[name=thing][value="${wanted}"]`).click();
    return {crops: crops.length, things: data.things.length, most: data.views.every((other) =>
      other.id.reduce((n, id) => n + (id === wanted), 0) <= place.pixels), inside: brightness[1] / reference[1],
      around: brightness[0] / reference[0], chosen, shown: data.views[at].id.includes(wanted)};
  })())",
                                       site_, folder);
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["said"], json::array()) << "errors and violations of the policy";
  const json& value = answer["value"];
  EXPECT_EQ(value["crops"], value["things"]);
  EXPECT_EQ(value["most"], true) << "it is shown where most of it is seen";
  EXPECT_NEAR(value["inside"].get<double>(), 1, 0.1);
  EXPECT_NEAR(value["around"].get<double>(), 105.0 / 255, 0.1);
  EXPECT_EQ(value["chosen"], plant());
  EXPECT_EQ(value["shown"], true);
}

// In the browser: the pointer lights up and takes what it is over, marks are in the pixels of the camera, and what the
// page sends is what is asked for.
TEST_F(Choice, ThePageTakesWhatIsUnderThePointerAndSendsMarks) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json answer = evaluate_in_site("(async () => { const wanted = " + std::to_string(plant()) + R"(;
    await Promise.all(data.views.map((view) => view.image.decode()));
    const view = data.views[0], box = canvas.getBoundingClientRect(), sent = [];
    while (socket.readyState === WebSocket.CONNECTING) await new Promise((done) => setTimeout(done, 20));
    socket.send = (text) => sent.push(text);
    const pixels = [...view.id.keys()].filter((p) => view.id[p] === wanted);
    const pixel = pixels[pixels.length >> 1], at = [pixel % view.width + 0.5, Math.floor(pixel / view.width) + 0.5];
    const scale = Math.min(box.width / view.width, box.height / view.height);
    const point = (type, dx = 0) => canvas.dispatchEvent(new PointerEvent(type, {pointerId: 1, isPrimary: true,
      clientX: box.left + (box.width - scale * view.width) / 2 + scale * (at[0] + dx),
      clientY: box.top + (box.height - scale * view.height) / 2 + scale * at[1]}));
    canvas.setPointerCapture = () => {};
    const before = element('make').disabled;
    point('pointermove');
    const under = over;
    point('pointerdown');
    const picked = chosen;
    element('label').value = 'potted plant';
    element('make').click();
    document.querySelector('[data-tool=click]').click();
    point('pointerdown');
    document.querySelector('[data-tool=bg]').click();
    point('pointerdown');
    point('pointermove', 2);
    point('pointerup', 2);
    element('undo').click();
    element('redo').click();
    document.dispatchEvent(new KeyboardEvent('keydown', {key: '-'}));
    element('grow').click();
    element('grow').click();
    document.querySelector('[data-tool=fg]').click();
    point('pointerdown');
    point('pointerup');
    return {before, under, picked, chosen, sent, camera: view.camera, mark: at.map((x, axis) => x * view.scale[axis]), scale: view.scale[0],
      connected: socket.readyState === WebSocket.OPEN};
  })())",
                                       site_, folder);
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["said"], json::array()) << "errors and violations of the policy";
  const json& value = answer["value"];
  EXPECT_EQ(value["connected"], true);
  EXPECT_EQ(value["before"], true) << "nothing is chosen yet";
  EXPECT_EQ(value["under"], plant());
  EXPECT_EQ(value["picked"], plant());
  EXPECT_EQ(value["chosen"], -1) << "marks say something else";
  ASSERT_EQ(value["sent"].size(), 9u) << "the choice, a click, a stroke, undo, redo, shrink, grow twice, and a dot";
  for (const auto& [k, grow] : {std::pair(4, 0), std::pair(5, -1), std::pair(6, 0), std::pair(7, 1)})
    EXPECT_EQ(segment_by(parse_choose_request(value["sent"][k].get<std::string>()).marks).grow, grow) << k;
  EXPECT_EQ(value["sent"][1], value["sent"][3]) << "without the stroke";
  EXPECT_EQ(value["sent"][2], value["sent"][4]) << "with it";
  const ChooseRequest make = parse_choose_request(value["sent"][0].get<std::string>());
  EXPECT_EQ(make.kind, ChooseRequest::Kind::kMake);
  EXPECT_EQ(make.object, plant());
  EXPECT_EQ(make.label, "potted plant");
  const ChooseRequest select = parse_choose_request(value["sent"][4].get<std::string>());
  EXPECT_EQ(select.kind, ChooseRequest::Kind::kSelect);
  Gesture gesture;
  const SegmentStage marked = segment_by(select.marks);
  ASSERT_EQ(marked.clicks.size(), 1u);
  ASSERT_EQ(marked.strokes.size(), 1u);
  add_click(marked.clicks[0], scene_.cameras, 8, gesture);
  add_stroke(marked.strokes[0], scene_.cameras, 8, gesture);
  EXPECT_EQ(gesture.strokes[0].camera, value["camera"]);
  EXPECT_NEAR(gesture.strokes[0].points[0].x(), value["mark"][0].get<float>(), 0.1);
  EXPECT_NEAR(gesture.strokes[0].points[0].y(), value["mark"][1].get<float>(), 0.1);
  const ChooseRequest dot = parse_choose_request(value["sent"][8].get<std::string>());
  const std::string last = segment_by(dot.marks).strokes.back();
  EXPECT_NO_THROW(add_stroke(last, scene_.cameras, 8, gesture)) << last;
  EXPECT_FALSE(gesture.strokes[1].foreground);
  ASSERT_EQ(gesture.strokes[1].points.size(), 2u);
  EXPECT_NEAR(gesture.strokes[1].points[1].x() - gesture.strokes[1].points[0].x(), 2 * value["scale"].get<float>(),
              0.2);
}

TEST_F(Choice, AMarkIsAnsweredAndWrittenAsTheCommandWritesIt) {
  const auto [click, camera, pixel] = middle_of(plant());
  ASSERT_FALSE(click.empty());
  client_->receive(json({{"select", {{"clicks", {click}}, {"camera", camera}}}}).dump());
  const json selected = await("selected"), mask = await("mask");
  EXPECT_EQ(mask["camera"], camera) << "the view that is looked at comes first";
  size_t end = 0, under = 0;
  for (size_t k = 0; k < mask["runs"].size() && end <= pixel; k += 2) {
    end += mask["runs"][k + 1].get<size_t>();
    under = mask["runs"][k];
  }
  EXPECT_EQ(under, 1u) << "what was clicked is selected";
  const json kept = await("kept");
  ASSERT_EQ(kept["things"].size(), 2u);
  EXPECT_EQ(kept["things"][0]["name"], "object");
  EXPECT_NE(page().find(marks_json({{"click", click}}).dump()), std::string::npos);
  // The same as what the stage writes.
  const std::vector<uint32_t> label = read_objects(*run_, scene_).label;
  EXPECT_EQ(static_cast<size_t>(std::count(label.begin(), label.end(), SelectionShape::kObject)),
            selected["gaussians"].get<size_t>());
  SegmentStage stage;
  stage.clicks = {click};
  const GestureResult again =
      select_by_gesture(gesture_options(context_, scene_), gesture_of(stage, scene_.cameras), {}, scene_.cloud,
                        scene_.cameras, pliant::prepared_scene(context_, *run_, scene_));
  for (size_t p = 0; p < label.size(); ++p)
    ASSERT_EQ(again.selected(p), label[p] == SelectionShape::kObject) << "read from the file, Gaussian " << p;
  client_->receive(R"({"name": {"object": 0, "name": "plant in a pot"}})");
  EXPECT_EQ(await("kept")["things"][0]["name"], "plant in a pot");
}

TEST_F(Choice, WhatIsAskedOfASelectionWaitsForItsAnswer) {
  const Place place = middle_of(plant());
  client_->receive(json({{"select", {{"clicks", {place.click}}}}}).dump());
  client_->receive(R"({"name": {"object": 0, "name": "plant in a pot"}})");
  EXPECT_EQ(await("kept")["things"].size(), 2u) << "the marks are written first";
  const json named = await("kept")["things"];
  EXPECT_EQ(named[0]["name"], "plant in a pot");
}

TEST_F(Choice, MarksThatWereTakenBackAreNotWritten) {
  const uint32_t wanted = plant();
  const size_t things = data()["things"].size();
  client_->receive(json({{"select", {{"clicks", {middle_of(wanted).click}}}}}).dump());
  client_->receive(R"({"select": {}})");
  client_->receive(json({{"name", {{"object", wanted}, {"name", "fern"}}}}).dump());
  EXPECT_EQ(await("kept")["things"].size(), things);
}

// In the browser against the program: a click and a box from the keyboard are answered with a mask.
TEST_F(Choice, ThePageShowsWhatAMarkSelects) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json answer = evaluate_in_site("(async () => { const wanted = " + std::to_string(plant()) + R"(;
    await Promise.all(data.views.map((view) => view.image.decode()));
    const until = async (done) => { for (let k = 0; k < 400 && !done(); ++k) await new Promise((next) => setTimeout(next, 50)); };
    await until(() => socket.readyState === WebSocket.OPEN);
    const view = data.views[0], press = (key, init = {}) => canvas.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true, cancelable: true, ...init}));
    const pixels = [...view.id.keys()].filter((p) => view.id[p] === wanted);
    const pixel = pixels[pixels.length >> 1], at = [pixel % view.width, Math.floor(pixel / view.width)];
    const covered = () => {
      const sheet = new OffscreenCanvas(view.width, view.height).getContext('2d');
      sheet.drawImage(view.mask, 0, 0);
      return sheet.getImageData(0, 0, view.width, view.height).data.filter((v, k) => k % 4 === 3 && v > 0).length;
    };
    press('p');
    for (let k = 0; k < 40 && !view.hint; ++k) {  // it may still be preparing the scene
      hover(at);
      await new Promise((next) => setTimeout(next, 500));
    }
    const hinted = Boolean(view.hint);
    canvas.focus();
    cross = at;
    press('Enter');
    await until(() => view.mask);
    const clicked = covered(), said = element('selection').textContent;
    press('z', {ctrlKey: true});
    const undoneAll = chosen === 0 && marks.length === 0;
    press('b');
    cross = [Math.min(...pixels.map((p) => p % view.width)) - 4, Math.min(...pixels.map((p) => Math.floor(p / view.width))) - 4];
    cross = cross.map((x) => Math.max(x, 0));
    press('Enter');
    cross = [Math.max(...pixels.map((p) => p % view.width)) + 3, Math.max(...pixels.map((p) => Math.floor(p / view.width))) + 3];
    line.push(cross);
    press('Enter');
    await until(() => view.mask);
    return {hinted, clicked, said, undoneAll, boxed: covered(), pixels: pixels.length, marks};
  })())",
                                       site_, folder);
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["said"], json::array()) << "errors and violations of the policy";
  const json& value = answer["value"];
  EXPECT_EQ(value["hinted"], true);
  EXPECT_GT(value["clicked"].get<size_t>(), 0u);
  EXPECT_NE(value["said"].get<std::string>().find("Gaussians selected"), std::string::npos);
  EXPECT_EQ(value["undoneAll"], true);
  EXPECT_GT(value["boxed"].get<size_t>(), value["pixels"].get<size_t>() / 4);
  ASSERT_EQ(value["marks"].size(), 1u);
  EXPECT_EQ(value["marks"][0]["kind"], "box");
}

TEST_F(Choice, WhatFailsOrIsCancelledIsSaidAndTheNextIsCarriedOut) {
  client_->receive(R"({"make": {"object": 123456}})");
  EXPECT_NE(await("failed").get<std::string>().find("123456"), std::string::npos);
  client_->receive(json({{"make", {{"object", plant()}}}}).dump());
  client_->receive(R"({"cancel": true})");
  EXPECT_EQ(await("failed"), "Cancelled.");
  EXPECT_EQ(page().find("pliant-live\""), std::string::npos);
  client_->receive(R"({"select": {"clicks": ["nowhere,1,2"]}})");
  EXPECT_NE(await("failed").get<std::string>().find("nowhere"), std::string::npos);
}

}  // namespace
}  // namespace pliant
