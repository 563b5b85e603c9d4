// Changing the objects by hand: what a merge joins a split takes apart, a dropped object becomes its surroundings,
// labels that an edit does not name stay, ids are never used twice, and pictures agree with labels.

#include "segmentation/objects/edit.h"

#include <algorithm>
#include <set>

#include "segmentation/field/islands.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/field/vote.h"
#include "segmentation/labels/object_names.h"
#include "segmentation/objects/relabel.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::vector<MadeScene::Ball> three_balls() {
  return {{Vec3f(-0.5f, 0.35f, 0.15f), 0.28f, 300, Vec3f(0.8f, 0.1f, 0.1f)},
          {Vec3f(0.45f, 0.3f, 0.12f), 0.22f, 70000, Vec3f(0.1f, 0.3f, 0.8f)},
          {Vec3f(0.0f, -0.5f, 0.1f), 0.2f, 5, Vec3f(0.2f, 0.7f, 0.2f)}};
}

/// A fitted segmentation, as `segment` makes it.
struct Fitted {
  MadeScene scene = made_scene(three_balls());
  Segmentation segmentation;

  Fitted() {
    SemanticOptions options;
    options.iterations = 40;
    options.seed = 2;
    segmentation = fit_semantic_field(options, scene.cloud, scene.cameras, cast_masks(scene)).segmentation;
    merge_islands({}, scene.cloud, segmentation);
    segmentation.class_name = {"table", "pear", "plum", "berry"};  // ids 3, 5, 300, 70000
  }

  EditOutcome edit(ObjectEdit::Kind kind, const std::string& text) {
    return apply_edit({}, ObjectEdit::parse(kind, text), scene.cloud, scene.cameras, segmentation);
  }
  std::vector<uint32_t> picture(size_t camera) const {
    return render_ids(segmentation, scene.cloud, scene.cameras[camera]).data;
  }
};

using Kind = ObjectEdit::Kind;

const Fitted& fitted() {
  static const Fitted once;
  return once;
}

/// The sets of Gaussians that share a label, whatever the label is.
std::set<std::vector<int>> parts_of(const std::vector<uint32_t>& label) {
  std::map<uint32_t, std::vector<int>> parts;
  for (size_t p = 0; p < label.size(); ++p) parts[label[p]].push_back(static_cast<int>(p));
  std::set<std::vector<int>> out;
  for (auto& [id, part] : parts) out.insert(std::move(part));
  return out;
}

/// Everything that follows from attribute and classifier is up to date, and the lists per class have equal lengths.
void expect_consistent(const Segmentation& s) {
  Segmentation again = s;
  update_labels(again);
  EXPECT_EQ(again.label, s.label);
  EXPECT_EQ(again.confidence, s.confidence);
  EXPECT_TRUE(std::is_sorted(s.class_id.begin(), s.class_id.end(), std::less_equal<>()) || s.class_id.size() < 2);
  for (size_t n :
       {s.class_name.size(), s.classifier_bias.size(), s.classifier.size() / kSemanticChannels, s.class_cameras.size()})
    EXPECT_EQ(n, s.class_id.size());
}

double share_equal(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
  size_t equal = 0;
  for (size_t i = 0; i < a.size(); ++i) equal += a[i] == b[i];
  return static_cast<double>(equal) / static_cast<double>(a.size());
}

TEST(Edit, MergedObjectsAreOneWithTheFirstIdAndNameInLabelsAndPictures) {
  Fitted f = fitted();
  std::vector<uint32_t> expected = f.segmentation.label, picture = f.picture(3);
  for (uint32_t& id : expected) id = id == 70000 || id == 5 ? 300 : id;
  for (uint32_t& id : picture) id = id == 70000 || id == 5 ? 300 : id;
  std::set<int> cameras;
  for (int c : {1, 2, 3})
    cameras.insert(f.segmentation.class_cameras[c].begin(), f.segmentation.class_cameras[c].end());

  const EditOutcome outcome = f.edit(Kind::kMerge, "plum,70000,pear");
  EXPECT_EQ(f.segmentation.label, expected);
  EXPECT_EQ(outcome.ids, std::vector<uint32_t>{300});
  EXPECT_EQ(outcome.merged, (std::vector<std::pair<uint32_t, std::string>>{{70000, "berry"}, {5, "pear"}}));
  EXPECT_EQ(f.segmentation.class_id, (std::vector<uint32_t>{3, 300}));
  EXPECT_EQ(f.segmentation.class_name, (std::vector<std::string>{"table", "plum"}));
  EXPECT_EQ(f.segmentation.class_cameras[1], std::vector<int>(cameras.begin(), cameras.end()));
  EXPECT_GT(share_equal(f.picture(3), picture), 0.995);
  expect_consistent(f.segmentation);
}

TEST(Edit, SplittingWhatWasMergedReturnsTheParts) {
  Fitted f = fitted();
  const auto parts = parts_of(f.segmentation.label);
  const std::vector<uint32_t> picture = f.picture(0);
  f.edit(Kind::kMerge, "300,70000,5");
  const EditOutcome outcome = f.edit(Kind::kSplit, "plum");
  EXPECT_EQ(parts_of(f.segmentation.label), parts);
  expect_consistent(f.segmentation);

  // The largest keeps its id; the others' ids are above every id that ever was.
  EXPECT_EQ(outcome.ids, (std::vector<uint32_t>{300, 70001, 70002}));
  std::vector<uint32_t> again = f.picture(0);
  for (uint32_t& id : again) id = id == 70001 ? 70000 : id == 70002 ? 5 : id;
  EXPECT_GT(share_equal(again, picture), 0.99);
  EXPECT_EQ(f.segmentation.class_cameras[class_of_id(f.segmentation, 70001)], fitted().segmentation.class_cameras[3]);
}

// Classes that a trained classifier keeps apart: each one's logit is negative in the others.
TEST(Edit, SplittingLeavesTheConfidencesOfOtherObjects) {
  constexpr int kY = kSemanticChannels;
  const float corner[3][2] = {{1, 0}, {-0.5f, 0.866f}, {-0.5f, -0.866f}};
  Segmentation s;
  s.class_id = {1, 2, 3};
  s.class_name = {"wall", "box", "ball"};
  s.classifier_bias = {0, 0.1f, -0.1f};
  s.classifier.assign(3 * kY, 0.0f);
  std::vector<uint8_t> part;
  for (size_t c = 0; c < 3; ++c) {
    for (int k = 0; k < 2; ++k) s.classifier[c * kY + k] = 1.5f * corner[c][k];
    for (int i = 0; i < 40; ++i) {
      const float doubt = i % 4 == 0 ? 0.4f : 0.0f;  // towards the next class
      std::vector<float> y(kY, 0.1f);                // no row has the other channels
      for (int k = 0; k < 2; ++k) y[k] = 2 * ((1 - doubt) * corner[c][k] + doubt * corner[(c + 1) % 3][k]);
      s.attribute.insert(s.attribute.end(), y.begin(), y.end());
      part.push_back(c == 0 && i < 20);
    }
  }
  s.seen.assign(part.size(), 1);
  update_labels(s);
  const Segmentation before = s;
  split_class(1, 4, "wall_2", part, s);
  split_class(2, 5, "box_2", std::vector<uint8_t>(part.size(), 0), s);
  for (size_t p = 0; p < part.size(); ++p) {
    EXPECT_EQ(s.label[p], part[p] ? 4u : before.label[p]) << p;
    if (before.label[p] == 3) {
      EXPECT_NEAR(s.confidence[p], before.confidence[p], 1e-3f) << p;
    } else {
      EXPECT_GT(s.confidence[p], before.confidence[p] - 0.01f) << p;
    }
  }
}

TEST(Edit, ADroppedObjectTakesTheLabelOfWhatItStandsOn) {
  Fitted f = fitted();
  std::vector<uint32_t> expected = f.segmentation.label, picture = f.picture(5);
  for (uint32_t& id : expected) id = id == 300 ? MadeScene::kTable : id;
  for (uint32_t& id : picture) id = id == 300 ? MadeScene::kTable : id;
  const EditOutcome outcome = f.edit(Kind::kDrop, "plum");
  EXPECT_EQ(f.segmentation.label, expected);
  EXPECT_NE(outcome.sentence.find(": " + std::to_string(outcome.gaussians) + " that of 3 (table)"), std::string::npos)
      << outcome.sentence;
  EXPECT_GT(share_equal(f.picture(5), picture), 0.995);
  expect_consistent(f.segmentation);
}

TEST(Edit, TheOrderOfMergesDoesNotMatterForTheParts) {
  Fitted a = fitted(), b = fitted();
  a.edit(Kind::kMerge, "300,5");
  a.edit(Kind::kMerge, "3,70000");
  b.edit(Kind::kMerge, "70000,3");
  b.edit(Kind::kMerge, "5,300");
  EXPECT_EQ(parts_of(a.segmentation.label), parts_of(b.segmentation.label));
}

TEST(Edit, IdsAreNeverUsedAgain) {
  Fitted f = fitted();
  f.edit(Kind::kMerge, "300,5");
  EXPECT_EQ(f.edit(Kind::kSplit, "300").ids.back(), 70001u);
  f.edit(Kind::kDrop, "70001");
  f.edit(Kind::kDrop, "70000");
  f.edit(Kind::kMerge, "3,300");
  EXPECT_EQ(f.edit(Kind::kSplit, "3").ids[1], 70002u);
}

TEST(Edit, AConnectedObjectIsCutWhereItsColourChanges) {
  MadeScene scene = made_scene({}, 1);
  GaussianCloud cloud;  // a bar, half red, half blue
  std::vector<uint8_t> member;
  for (float x = -0.5f; x < 0.5f; x += 0.02f)
    for (float y = 0; y < 0.2f; y += 0.02f) {
      add_disc(cloud, Vec3f(x, y, 0), Vec3f::UnitZ(), 0.015f,
               x < 0.13f ? Vec3f(0.8f, 0.1f, 0.1f) : Vec3f(0.1f, 0.1f, 0.8f));
      member.push_back(1);
    }
  const SplitResult result = split_object({}, cloud, member);
  ASSERT_EQ(result.parts, 2);
  EXPECT_TRUE(result.cut);
  EXPECT_LT(result.cut_share, 0.02);
  for (size_t p = 0; p < cloud.size(); ++p) EXPECT_EQ(result.part[p], cloud.position[p].x() >= 0.13f) << p;
}

TEST(Edit, ADumbbellOfMottledColourIsCutAtItsHandle) {
  GaussianCloud cloud;
  std::vector<uint8_t> member;
  Random random(3);
  const auto add = [&](float x, float y) {
    const float grey = static_cast<float>(random.uniform(0.4, 0.6));
    add_disc(cloud, Vec3f(x, y, 0), Vec3f::UnitZ(), 0.015f, Vec3f(grey, 0.5f, 0.5f));
    member.push_back(1);
  };
  for (float x = -0.4f; x < 0.41f; x += 0.02f)
    for (float y = -0.1f; y < 0.11f; y += 0.02f)
      if (std::abs(x) > 0.15f || std::abs(y) < 0.015f) add(x, y);
  const SplitResult result = split_object({}, cloud, member);
  ASSERT_EQ(result.parts, 2);
  EXPECT_TRUE(result.cut);
  EXPECT_LT(result.cut_share, 0.05);
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (std::abs(cloud.position[p].x()) <= 0.17f) continue;
    EXPECT_EQ(result.part[p] == result.part[0], cloud.position[p].x() < 0) << p;
  }
}

TEST(Edit, SeventyObjectsInSixteenChannelsStayApart) {
  // More classes than channels: directions of the new classes can no longer be orthogonal to the others.
  GaussianCloud cloud;
  std::vector<uint32_t> blob;
  for (uint32_t k = 0; k < 70; ++k)
    for (int i = 0; i < 20; ++i) {
      add_disc(cloud,
               Vec3f(static_cast<float>(k), 0.02f * static_cast<float>(i % 5), 0.02f * static_cast<float>(i / 5)),
               Vec3f::UnitZ(), 0.015f, Vec3f::Ones());
      blob.push_back(k);
    }
  Segmentation s;
  s.class_id = {1};
  s.class_name = {"all"};
  s.classifier_bias = {0.0f};
  s.classifier = class_codes(1, 3);
  for (size_t p = 0; p < cloud.size(); ++p)
    s.attribute.insert(s.attribute.end(), s.classifier.begin(), s.classifier.end());
  for (float& w : s.classifier) w *= 8;
  s.seen.assign(cloud.size(), 1);
  s.class_cameras = {{}};
  update_labels(s);
  SplitOptions options;
  options.crumb = 0.001f;
  apply_edit(options, ObjectEdit::parse(Kind::kSplit, "all"), cloud, {}, s);
  EXPECT_EQ(parts_of(s.label), parts_of(blob));
  EXPECT_EQ(s.class_id.size(), 70u);
  expect_consistent(s);
}

TEST(Edit, WithoutAnythingAroundEverythingIsUnlabelled) {
  Fitted f = fitted();
  f.edit(Kind::kMerge, "3,5,300,70000");
  f.edit(Kind::kDrop, "table");
  EXPECT_EQ(f.segmentation.class_id, std::vector<uint32_t>{0});
  EXPECT_EQ(std::count(f.segmentation.label.begin(), f.segmentation.label.end(), 0),
            static_cast<std::ptrdiff_t>(f.scene.cloud.size()));
  expect_consistent(f.segmentation);
}

TEST(Edit, MistakesNameTheNearestObjectAndChangeNothing) {
  Fitted f = fitted();
  expect_error(Failure::kUsage, {"--drop", "plumm", "did you mean 'plum'", "70000 = berry"},
               [&] { f.edit(Kind::kDrop, "plumm"); });
  expect_error(Failure::kUsage, {"--merge", "twice"}, [&] { f.edit(Kind::kMerge, "300,plum"); });
  expect_error(Failure::kUsage, {"--merge", "two or more"}, [&] { f.edit(Kind::kMerge, "300"); });
  expect_error(Failure::kUsage, {"--name", "ID=NAME"}, [&] { f.edit(Kind::kName, "300"); });
  expect_error(Failure::kUsage, {"--name", "could be an ID"}, [&] { f.edit(Kind::kName, "300=17"); });
  expect_error(Failure::kUsage, {"--name", "101 characters"},
               [&] { f.edit(Kind::kName, "300=" + std::string(101, 'v')); });
  std::string hundred;  // characters of three bytes
  for (int k = 0; k < 100; ++k) hundred += "\u690d";
  EXPECT_EQ(ObjectEdit::parse(Kind::kName, "300=" + hundred).name, hundred);
  expect_error(Failure::kUsage, {"UTF-8"}, [&] { f.edit(Kind::kName, "300=" + std::string(101, '\xff')); });
  expect_error(Failure::kUsage, {"--name", "UTF-8"}, [&] { f.edit(Kind::kName, "300=caf\xe9"); });
  expect_error(Failure::kUsage, {"--name", "pear", "object 5"}, [&] { f.edit(Kind::kName, "300=pear"); });
  // So it is for an edit that was not parsed.
  for (const char* name : {"", "17", "a,b", "a\tb", "caf\xe9"})
    expect_error(Failure::kUsage, {"--name", "300="}, [&] {
      apply_edit({}, {Kind::kName, {"300"}, name}, f.scene.cloud, f.scene.cameras, f.segmentation);
    });
  EXPECT_EQ(f.segmentation.label, fitted().segmentation.label);
  EXPECT_EQ(f.segmentation.class_id, fitted().segmentation.class_id);
  EXPECT_EQ(f.segmentation.class_name, fitted().segmentation.class_name);
  f.edit(Kind::kName, "300=" + std::string(98, 'v') + "\xc3\xa9");
  f.edit(Kind::kName, "300=vase");
  f.edit(Kind::kName, "5=big red=vase");
  EXPECT_EQ(f.segmentation.class_name[2], "vase");
  EXPECT_EQ(f.segmentation.class_name[1], "big red=vase");
  EXPECT_EQ(class_of_object(f.segmentation, "--object", "vase"), 2u);
}

}  // namespace
}  // namespace pliant
