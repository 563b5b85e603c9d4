// What the page of the choice may ask for.

#include "app/choose/choose_request.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/utf8.h"

namespace pliant {
using nlohmann::json;

namespace {

TEST(ChooseRequest, IsOneOfSixAndEverythingElseIsRefused) {
  const ChooseRequest select =
      parse_choose_request(R"({"select": {"clicks": ["0,10,20"], "strokes": ["bg,1,2,3,4,5"]}})");
  EXPECT_EQ(select.kind, ChooseRequest::Kind::kSelect);
  EXPECT_EQ(select.marks, (Marks{{"click", "0,10,20"}, {"stroke", "bg,1,2,3,4,5"}}));
  const ChooseRequest box = parse_choose_request(R"({"select": {"boxes": ["0,1,2,3,4"], "camera": 5}})");
  EXPECT_EQ(box.marks, (Marks{{"box", "0,1,2,3,4"}}));
  EXPECT_EQ(box.camera, 5);
  EXPECT_EQ(segment_by(parse_choose_request(R"({"select": {"clicks": ["0,1,2"], "grow": -3}})").marks).grow, -3);
  const Marks ordered = {{"stroke", "bg,0,1,2,3,4"}, {"click", "0,1,2"}, {"grow", "-1"}, {"box", "0,1,2,30,40"}};
  EXPECT_EQ(parse_choose_request(json({{"select", {{"marks", marks_json(ordered)}}}}).dump()).marks, ordered);
  EXPECT_TRUE(parse_choose_request(R"({"select": {"clicks": [], "grow": 0}})").marks.empty()) << "all were taken back";
  const ChooseRequest hover = parse_choose_request(R"({"hover": [3, 10.5, 20]})");
  EXPECT_EQ(hover.kind, ChooseRequest::Kind::kHover);
  EXPECT_EQ(hover.camera, 3);
  EXPECT_EQ(hover.pixel, Vec2f(10.5f, 20));
  const ChooseRequest name = parse_choose_request(R"({"name": {"object": 0, "name": "vase"}})");
  EXPECT_EQ(name.kind, ChooseRequest::Kind::kName);
  EXPECT_EQ(name.label, "vase");
  const ChooseRequest make = parse_choose_request(R"({"make": {"object": 70000, "label": "potted plant"}})");
  EXPECT_EQ(make.kind, ChooseRequest::Kind::kMake);
  EXPECT_EQ(make.object, 70000u);
  EXPECT_EQ(make.label, "potted plant");
  EXPECT_EQ(parse_choose_request(R"({"find": true})").kind, ChooseRequest::Kind::kFind);
  EXPECT_EQ(parse_choose_request(R"({"cancel": true})").kind, ChooseRequest::Kind::kCancel);
  for (const std::string& wrong : {std::string(),
                                   std::string("nonsense"),
                                   std::string("[]"),
                                   std::string("{}"),
                                   std::string(R"({"find": 1})"),
                                   std::string(R"({"find": true, "cancel": true})"),
                                   std::string(R"({"select": 1})"),
                                   std::string(R"({"select": {"clicks": "0,1,2"}})"),
                                   std::string(R"({"select": {"clicks": [1]}})"),
                                   std::string(R"({"select": {"clicks": ["0,1,2"], "camera": -1}})"),
                                   std::string(R"({"select": {"clicks": ["0,1,2"], "grow": 1000}})"),
                                   std::string(R"({"select": {"clicks": ["0,1,2"], "grow": 0.5}})"),
                                   std::string(R"({"select": {"grow": 2}})"),
                                   std::string(R"({"select": {"marks": {}}})"),
                                   std::string(R"({"select": {"marks": [{"kind": "click"}]}})"),
                                   std::string(R"({"select": {"marks": [{"kind": "dot", "text": "0,1,2"}]}})"),
                                   std::string(R"({"select": {"marks": [{"kind": "grow", "text": "1"}]}})"),
                                   std::string(R"({"select": {"clicks": ["0,1,2"], "marks": [
                                       {"kind": "grow", "text": "60"}, {"kind": "grow", "text": "60"}]}})"),
                                   std::string(R"({"select": {"clicks": ["0,1,2"], "marks": [
                                       {"kind": "grow", "text": "1x"}]}})"),
                                   std::string(R"({"hover": [0, 1]})"),
                                   std::string(R"({"hover": [0.5, 1, 2]})"),
                                   std::string(R"({"hover": [0, 1, "2"]})"),
                                   std::string(R"({"hover": [0, 1e300, 2]})"),
                                   std::string(R"({"name": {"object": 1}})"),
                                   std::string(R"({"make": {}})"),
                                   std::string(R"({"make": {"object": -1}})"),
                                   std::string(R"({"make": {"object": 4294967296}})"),
                                   std::string(R"({"make": {"object": 1, "label": 2}})"),
                                   R"({"make": {"object": 1, "label": ")" + std::string(200, 'x') + "\"}}",
                                   std::string(R"({"run": true})")})
    EXPECT_THROW(parse_choose_request(wrong), Error) << wrong;
}

/// `count` characters of three bytes.
std::string long_text(int count) {
  std::string text;
  for (int k = 0; k < count; ++k) text += "\u690d";
  return text;
}

TEST(ChooseRequest, NamesHaveAHundredCharactersOfWhateverLength) {
  const auto parse = [](const std::string& name) {
    return parse_choose_request(json({{"name", {{"object", 1}, {"name", name}}}}).dump());
  };
  EXPECT_EQ(parse(long_text(100)).label, long_text(100));
  EXPECT_THROW(parse(long_text(101)), Error);
  try {
    parse("a" + long_text(500));
    ADD_FAILURE() << "was taken";
  } catch (const Error& error) {
    EXPECT_EQ(as_utf8(error.what()), error.what()) << "the quotation ends with a whole character";
  }
}

}  // namespace
}  // namespace pliant
