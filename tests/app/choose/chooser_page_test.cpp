// The page of the choice in the browser: who draws, what picking ends, and long lines.

#include "tests/app/choose/choice.h"
#include "tests/app/live/site_in_browser.h"

using nlohmann::json;

namespace pliant {
namespace {

/// What the body of a function gives in the page, which has the id `wanted`, `view`, and `until(condition)`.
json in_page(const std::string& body, uint32_t wanted, LiveSite& site, const std::filesystem::path& folder) {
  const std::string before = "(async () => { const wanted = " + std::to_string(wanted) + R"(, view = data.views[0];
    const until = async (done) => {
      for (let k = 0; k < 400 && !done(); ++k) await new Promise((next) => setTimeout(next, 50));
    };
    await Promise.all(data.views.map((view) => view.image.decode()));
    await until(() => socket.readyState === WebSocket.OPEN);
)";
  json answer = evaluate_in_site(before + body + "})()", site, folder);
  EXPECT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_EQ(answer["said"], json::array()) << "errors and violations of the policy";
  return answer["value"];
}

TEST_F(Choice, OneFingerOrTheMainButtonDrawsALine) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json value = in_page(R"(
    const box = canvas.getBoundingClientRect(), scale = Math.min(box.width / view.width, box.height / view.height);
    const point = (type, pointerId, x, init = {}) => canvas.dispatchEvent(new PointerEvent(type, {pointerId,
      isPrimary: pointerId === 1, clientX: box.left + (box.width - scale * view.width) / 2 + scale * x,
      clientY: box.top + box.height / 2, ...init}));
    canvas.setPointerCapture = () => {};
    socket.send = () => {};
    useTool('fg');
    point('pointerdown', 1, 4);
    point('pointermove', 1, 8);
    point('pointerdown', 2, 40);
    point('pointermove', 2, 44);
    point('pointermove', 1, 12);
    point('pointerup', 2, 48);
    point('pointermove', 1, 16);
    point('pointerup', 1, 20);
    const drawn = marks.map((mark) => pointsIn(mark, view).map(([x]) => Math.round(x)));
    point('pointerdown', 1, 24, {button: 2});
    point('pointermove', 1, 28);
    point('pointerup', 1, 32, {button: 2});
    return {drawn, later: marks.length};
  )",
                             plant(), site_, folder);
  EXPECT_EQ(value["drawn"], json::array({{4, 8, 12, 16, 20}}));
  EXPECT_EQ(value["later"], 1);
}

TEST_F(Choice, PickingAnObjectEndsTheMarksAndAnotherWithItsIdIsNotChosen) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json value = in_page(R"(
    const sent = [];
    socket.send = (text) => sent.push(JSON.parse(text));
    useTool('click');
    begin([10, 10]);
    choose(wanted);
    const after = sent.at(-1), said = element('selection').textContent, things = data.things;
    const kept = (things) => socket.onmessage({data: JSON.stringify({kept: {things, views: []}})});
    kept(things);
    const same = chosen;
    kept(things.map((thing) => ({...thing, gaussians: thing.gaussians + 1})));
    const other = chosen;
    chosen = things[0].id;  // as after a reload
    update();
    const named = !element('naming').hidden;
    element('name').value = 'Vase';
    element('naming').requestSubmit();
    return {after, said, same, other, named, name: sent.at(-1), first: things[0].id};
  )",
                             plant(), site_, folder);
  EXPECT_EQ(value["after"], json({{"select", json::object()}}));
  EXPECT_EQ(value["said"], "");
  EXPECT_EQ(value["same"], plant());
  EXPECT_EQ(value["other"], 0);
  EXPECT_EQ(value["named"], true) << "the selection of marks can be named after a reload";
  EXPECT_EQ(value["name"], json({{"name", {{"object", value["first"]}, {"name", "Vase"}}}}));
}

TEST_F(Choice, WhatIsMarkedBeforeTheConnectionIsThereIsAskedWhenItIs) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json value = in_page(R"(
    const sent = [];
    socket.send = (text) => sent.push(JSON.parse(text));
    Object.defineProperty(socket, 'readyState', {value: WebSocket.CONNECTING, configurable: true});
    useTool('click');
    begin([10, 10]);
    element('find').click();
    const early = sent.length, failed = element('failed').textContent;
    delete socket.readyState;
    socket.dispatchEvent(new Event('open'));
    return {early, failed, sent, marks};
  )",
                             plant(), site_, folder);
  EXPECT_EQ(value["early"], 0);
  EXPECT_EQ(value["failed"], "");
  ASSERT_EQ(value["sent"].size(), 2u);
  EXPECT_EQ(value["sent"][0]["select"]["marks"], value["marks"]);
  EXPECT_EQ(value["sent"][1], json({{"find", true}}));
}

TEST_F(Choice, MarksAreSentAndUndoneInTheirOrderAlsoAfterAReload) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json value = in_page(R"(
    const sent = [], none = marks.length;
    socket.send = (text) => sent.push(JSON.parse(text));
    const before = [{kind: 'stroke', text: 'bg,0,1,1,2,2'}, {kind: 'click', text: '0,1,1'}, {kind: 'grow', text: '1'}];
    socket.onmessage({data: JSON.stringify({marks: before})});
    const taken = chosen;
    undo();
    socket.onmessage({data: JSON.stringify({marks: before})});  // this page knows better
    undo();
    return {none, taken, before, lists: sent.map((message) => message.select.marks)};
  )",
                             plant(), site_, folder);
  EXPECT_EQ(value["none"], 0);
  EXPECT_EQ(value["taken"], -1);
  const json& before = value["before"];
  EXPECT_EQ(value["lists"], json::array({before, json::array({before[0], before[1]}), json::array({before[0]})}));
}

TEST_F(Choice, ABoxThatTheProgramWouldRefuseIsNoMark) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json value = in_page(R"(
    socket.send = () => {};
    useTool('box');
    const counts = [];
    for (const [scale, side] of [[1, 3.5], [1, 4], [2, 3.5]]) {
      view.scale = [scale, scale];
      line = [[10, 10], [10 + side, 20]];
      finish();
      counts.push(marks.length);
    }
    return counts;
  )",
                             plant(), site_, folder);
  EXPECT_EQ(value, json::array({0, 1, 2}));
}

TEST_F(Choice, MarksInTheLastRowOfAPictureAreInThePhoto) {
  Scene scene = scene_;
  scene.cameras = {scene_.cameras[0].resized(1000, 667)};  // shown with 800 x 534
  const json shown = choose_data(*run_, scene, {})["views"][0];
  EXPECT_EQ(shown["height"], 534);
  EXPECT_DOUBLE_EQ(shown["width"].get<double>() * shown["scale"][0].get<double>(), 1000);
  EXPECT_DOUBLE_EQ(shown["height"].get<double>() * shown["scale"][1].get<double>(), 667);
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json value = in_page("view.scale = " + shown["scale"].dump() + R"(;
    const text = textOf([799.99, 533.99]);
    return {text, back: pointsIn({kind: 'click', text: `${view.camera},${text}`}, view)[0]};
  )",
                             plant(), site_, folder);
  EXPECT_EQ(value["text"], "1000.0,667.0");
  EXPECT_NEAR(value["back"][0].get<double>(), 800, 1e-9);
  EXPECT_NEAR(value["back"][1].get<double>(), 534, 1e-9);
}

TEST_F(Choice, LongLinesAreAnsweredAndALostConnectionIsSaid) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  const json value = in_page(R"(
    const pixels = [...view.id.keys()].filter((p) => view.id[p] === wanted);
    const place = (k) => [pixels[k % pixels.length] % view.width, Math.floor(pixels[k % pixels.length] / view.width)];
    const answered = () => element('selection').textContent.includes('selected in') || !element('failed').hidden;
    const draw = async () => {
      line = Array.from({length: 5000}, (_, k) => place(k));
      finish();
      await until(answered);
      return element('failed').textContent;
    };
    useTool('fg');
    const failed = [await draw(), await draw()], strokes = marks.map((mark) => pointsIn(mark, view));
    const joined = strokes.slice(1, 5).every((points, k) => String(points[0]) === String(strokes[k].at(-1)));
    const open = socket.readyState === WebSocket.OPEN, sent = marks.reduce((sum, {text}) => sum + text.length, 0);
    socket.close();
    await until(() => socket.readyState === WebSocket.CLOSED && !element('failed').hidden);
    useTool('click');
    begin(place(0));
    const first = strokes.slice(0, strokes.length / 2), points = first.reduce((sum, p) => sum + p.length, 0);
    return {failed, joined, open, sent, points, pieces: first.length,
      said: element('failed').textContent, shown: !element('failed').hidden,
      selection: element('selection').textContent};
  )",
                             plant(), site_, folder);
  EXPECT_EQ(value["failed"], json::array({"", ""}));
  EXPECT_EQ(value["open"], true);
  EXPECT_GT(value["sent"].get<size_t>(), 65536u);
  EXPECT_EQ(value["joined"], true) << "a piece begins where the one before ends";
  EXPECT_EQ(value["points"].get<int>(), 5000 + value["pieces"].get<int>() - 1);
  EXPECT_EQ(value["shown"], true);
  EXPECT_NE(value["said"].get<std::string>().find("has ended"), std::string::npos);
  EXPECT_EQ(value["selection"], "");
}

}  // namespace
}  // namespace pliant
