// SOG version 2 and compressed PLY, written here byte by byte as they are specified, and hostile files.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/sog.h"
#include "gaussians/io/splats/splats.h"
#include "tests/gaussians/sog_files.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

std::string& content(Entries& files, const std::string& name) {
  for (auto& [key, bytes] : files) {
    if (key == name) return bytes;
  }
  files.emplace_back(name, "");
  return files.back().second;
}

void expect_within_steps(const GaussianCloud& cloud, const GaussianCloud& back) {
  ASSERT_EQ(back.size(), cloud.size());
  ASSERT_EQ(back.sh_degree, cloud.sh_degree);
  for (size_t i = 0; i < cloud.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      // The logarithm has slope 1 / (1 + |x|).
      EXPECT_NEAR(back.position[i][k], cloud.position[i][k],
                  0.51 * 2.2 / 65535 * (1 + std::abs(cloud.position[i][k])) + 1e-6);
      EXPECT_NEAR(back.log_scale[i][k], cloud.log_scale[i][k], 0.501 * 12 / 255);
    }
    EXPECT_NEAR(sigmoid(back.opacity_logit[i]), sigmoid(cloud.opacity_logit[i]), 0.501 / 255);
    for (int k = 0; k < 3 * cloud.sh_count(); ++k) EXPECT_NEAR(back.sh_of(i)[k], cloud.sh_of(i)[k], 0.501 * 2 / 255);
  }
  EXPECT_LT(largest_angle(cloud, back), 2 * 2 * std::sqrt(3.0) * M_SQRT1_2 / 255);
}

TEST(Sog, OfAnyDegreeIsReadFromArchiveAndFolderWithinItsSteps) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const GaussianCloud cloud = some_gaussians(300, degree);
    const Entries files = sog_files(cloud);
    ReadReport report;
    expect_within_steps(cloud, read_splats(write_zip(folder / "a.sog", files, degree), &report));
    EXPECT_EQ(report.format, "SOG version 2, SH degree " + std::to_string(degree));
    for (const auto& [name, bytes] : files) folder.file("open/" + name, bytes);
    expect_within_steps(cloud, read_splats(folder / "open/meta.json", &report));
    EXPECT_EQ(report.files.size(), files.size());
    expect_within_steps(cloud, read_splats(folder / "open"));
  }
}

TEST(Sog, TheKeyOfTheSpecificationAndThatOfSplatTransformSayThatItIsAntialiased) {
  const TemporaryFolder folder;
  const Entries plain = sog_files(some_gaussians(10, 0));
  const std::vector<std::pair<std::string, bool>> cases = {{R"({})", false},
                                                           {R"({"antialias": true})", true},
                                                           {R"({"antialias": false})", false},
                                                           {R"({"antialias": 1})", false},
                                                           {R"({"model": "antialiased"})", true},
                                                           {R"({"model": "2dgs"})", false},
                                                           {R"({"model": 7})", false},
                                                           {R"({"model": ["antialiased"]})", false},
                                                           {R"({"antialias": false, "model": "antialiased"})", true}};
  for (const auto& [keys, wanted] : cases) {
    Entries files = plain;
    json meta = json::parse(content(files, "meta.json"));
    meta.update(json::parse(keys));
    content(files, "meta.json") = meta.dump();
    ReadReport report;
    EXPECT_EQ(read_splats(write_zip(folder / "a.sog", files), &report).size(), 10u);
    EXPECT_EQ(report.antialiased, wanted) << keys;
  }
}

TEST(Sog, MayBePackedWithItsFolder) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = some_gaussians(50, 1);
  Entries files = sog_files(cloud);
  for (auto& [name, bytes] : files) name.insert(0, "scene/");
  files.emplace_back("__MACOSX/scene/._meta.json", "");
  expect_within_steps(cloud, read_splats(write_zip(folder / "a.sog", files)));
  files.emplace_back("other/meta.json", "{}");
  expect_error(Failure::kInput, {"meta.json", "is missing in the archive"},
               [&] { read_splats(write_zip(folder / "a.sog", files)); });
}

TEST(Sog, ACodebookWithoutItsFirstValueIsContinued) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = some_gaussians(20, 0);
  Entries files = sog_files(cloud);
  json meta = json::parse(content(files, "meta.json"));
  meta["sh0"]["codebook"][0] = nullptr;
  content(files, "meta.json") = meta.dump();
  expect_within_steps(cloud, read_splats(write_zip(folder / "a.sog", files)));
}

TEST(Sog, HostileMetaNamesFileAndKey) {
  const TemporaryFolder folder;
  const Entries good = sog_files(some_gaussians(100, 1));
  const auto refused = [&](const std::string& patch, std::vector<std::string> words) {
    SCOPED_TRACE(patch);
    Entries files = good;
    json meta = json::parse(content(files, "meta.json"));
    meta.merge_patch(json::parse(patch));
    content(files, "meta.json") = meta.dump();
    words.push_back("case.sog");
    expect_error(Failure::kInput, words, [&] { read_splats(write_zip(folder / "case.sog", files)); });
  };
  refused(R"({"version": null})", {"version 1", "splat-transform"});
  refused(R"({"version": 3})", {"version", "3"});
  refused(R"({"count": -1})", {"count", "-1"});
  refused(R"({"count": 1.5})", {"count", "1.5"});
  refused(R"({"count": 1e300})", {"count"});
  refused(R"({"count": 2000000000})", {"count", "2000000000", "justifies"});
  refused(R"({"count": 105})", {"means.files", "105"});
  refused(R"({"count": "many"})", {"count", "many"});
  refused(R"({"means": null})", {"means", "missing"});
  refused(R"({"means": {"mins": [0, 0]}})", {"means.mins", "3 numbers"});
  refused(R"({"means": {"files": ["means_l.webp"]}})", {"means.files", "position 1"});
  refused(R"({"quats": {"files": ["absent.webp"]}})", {"absent.webp", "missing"});
  refused(R"({"quats": {"files": [7]}})", {"quats.files"});
  refused(R"({"scales": {"codebook": [1, 2]}})", {"scales.codebook", "256 numbers"});
  refused(R"({"shN": {"bands": 4}})", {"shN.bands", "4"});
  refused(R"({"shN": {"bands": 2}})", {"shN.files", "palette"});
  refused(R"({"shN": {"count": 99}})", {"shN.count", "label 99"});
  refused(R"({"shN": {"count": 65537}})", {"shN.count"});
  Entries files = good;
  content(files, "meta.json") = "{";
  expect_error(Failure::kInput, {"case.sog", "JSON"}, [&] { read_splats(write_zip(folder / "case.sog", files)); });
  content(files, "meta.json") = std::string(2 << 20, ' ');
  expect_error(Failure::kInput, {"case.sog", "meta.json", "justified"},
               [&] { read_splats(write_zip(folder / "case.sog", files, 9)); });
}

TEST(Sog, HostilePicturesAreRefusedBeforeTheyAreDecoded) {
  const TemporaryFolder folder;
  const Entries good = sog_files(some_gaussians(100, 0));
  const auto refused = [&](const std::string& bytes, const std::vector<std::string>& words) {
    Entries files = good;
    content(files, "quats.webp") = bytes;
    expect_error(Failure::kInput, words, [&] { read_splats(write_zip(folder / "case.sog", files)); });
  };
  refused("", {"quats.webp", "not a WebP image"});
  refused("hello", {"quats.webp", "not a WebP image"});
  Entries copy = good;
  const std::string picture = content(copy, "quats.webp");
  refused(picture.substr(0, picture.size() / 2), {"quats.webp", "cannot be decoded"});
  refused(webp(std::vector<uint8_t>(4 * 8, 7), 8, 1), {"quats.files", "8 pixels for 100"});
  // A picture of one colour is a small file and a large allocation.
  refused(webp(std::vector<uint8_t>(4 * 2048 * 2048, 7), 2048, 2048), {"quats.webp", "2048 x 2048", "justified"});
  std::vector<uint8_t> pixels(3 * 16 * 16, 90);
  uint8_t* lossy = nullptr;
  const size_t size = WebPEncodeRGB(pixels.data(), 16, 16, 3 * 16, 50, &lossy);
  refused(std::string(reinterpret_cast<const char*>(lossy), size), {"quats.webp", "lossy"});
  WebPFree(lossy);
}

TEST(Sog, HostileArchivesAreRefused) {
  const TemporaryFolder folder;
  const Entries good = sog_files(some_gaussians(100, 0));
  write_zip(folder / "good.sog", good);
  const std::string bytes = read_text(folder / "good.sog");
  const auto refused = [&](std::string archive, const std::vector<std::string>& words) {
    expect_error(Failure::kInput, words, [&] { read_sog(folder.file("case.sog", archive)); });
  };
  refused("", {"case.sog", "zip"});
  refused(bytes.substr(0, bytes.size() - 22), {"case.sog", "zip"});  // without the end record
  // The central directory of an entry: sizes at 20 and 24, offset of the data at 42, name at 46.
  const auto directory_of = [&](const std::string& name) {
    for (size_t at = bytes.find("PK\1\2"); at != std::string::npos; at = bytes.find("PK\1\2", at + 1)) {
      if (bytes.compare(at + 46, name.size(), name) == 0) return at;
    }
    return std::string::npos;
  };
  const auto with = [&](size_t at, uint32_t value) {
    std::string changed = bytes;
    std::memcpy(&changed[at], &value, 4);
    return changed;
  };
  const size_t means = directory_of("means_l.webp"), quats = directory_of("quats.webp");
  ASSERT_NE(means, std::string::npos);
  ASSERT_NE(quats, std::string::npos);
  refused(with(quats + 24, 0xfffffff0u), {"quats.webp", "declares", "justified"});
  refused(with(quats + 20, 0x7fffffffu), {"case.sog", "quats.webp"});
  refused(with(quats + 42, 0x7fffffffu), {"case.sog", "quats.webp"});
  // Both names lead to the data of the first entry.
  std::string overlapping = bytes;
  const std::string header = bytes.substr(means, 46);
  for (const auto& [begin, size] : {std::pair<size_t, size_t>{16, 12}, {42, 4}})
    overlapping.replace(quats + begin, size, header.substr(begin, size));
  refused(overlapping, {"case.sog", "quats.webp"});
  std::string damaged = bytes;
  damaged[bytes.find("RIFF", bytes.find("quats.webp")) + 30] ^= 1;
  refused(damaged, {"quats.webp", "checksum"});
  // A deflated bomb of many times its size behind the name of a picture.
  Entries bomb = good;
  content(bomb, "quats.webp") = std::string(64 << 20, '\0');
  write_zip(folder / "bomb.sog", bomb, 9);
  expect_error(Failure::kInput, {"bomb.sog", "quats.webp", "justified"}, [&] { read_sog(folder / "bomb.sog"); });
}

TEST(Sog, NamesOfAFolderLeadNowhereElse) {
  const TemporaryFolder folder;
  Entries files = sog_files(some_gaussians(10, 0));
  json meta = json::parse(content(files, "meta.json"));
  for (const char* name : {"../secret", "/etc/passwd", "..", "a/b.webp", ""}) {
    meta["quats"]["files"][0] = name;
    content(files, "meta.json") = meta.dump();
    for (const auto& [entry, bytes] : files) folder.file("open/" + entry, bytes);
    expect_error(Failure::kInput, {"meta.json", "same folder"}, [&] { read_splats(folder / "open"); });
  }
}

TEST(Sog, AnyDamageGivesAnErrorOrACloud) {
  const TemporaryFolder folder;
  write_zip(folder / "good.sog", sog_files(some_gaussians(9, 0)));
  const std::string good = read_text(folder / "good.sog");
  EXPECT_GT(
      errors_of_damaged(folder, "case.sog", good, good.size() / 150, [](const fs::path& file) { read_sog(file); }),
      100);
}

/// Two levels of detail: the first in two files of 30 and 20 Gaussians, the second in one of 10.
json two_levels(const TemporaryFolder& folder) {
  const char* names[] = {"0_0", "0_1", "1_0"};
  const int counts[] = {30, 20, 10};
  json meta = {{"lodLevels", 2}, {"tree", {{"children", json::array()}}}};
  for (int k = 0; k < 3; ++k) {
    for (const auto& [name, bytes] : sog_files(some_gaussians(counts[k], 1, 10 + k)))
      folder.file(std::string("lod/") + names[k] + "/" + name, bytes);
    meta["filenames"].push_back(std::string(names[k]) + "/meta.json");
    meta["tree"]["children"].push_back(
        {{"lods", {{k < 2 ? "0" : "1", {{"file", k}, {"offset", 0}, {"count", counts[k]}}}}}});
  }
  folder.file("lod/lod-meta.json", meta.dump());
  return meta;
}

TEST(SogLevels, EachLevelIsItsFilesAndTheFinestThatIsThereIsTheDefault) {
  const TemporaryFolder folder;
  two_levels(folder);
  ReadReport report;
  EXPECT_EQ(read_splats(folder / "lod", &report).size(), 50u);
  EXPECT_EQ(report.levels, 2);
  EXPECT_EQ(report.files.size(), 1 + 2 * 8u);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_EQ(read_splats(folder / "lod/lod-meta.json", &report, 1).size(), 10u);
  EXPECT_EQ(read_splats(folder / "lod", &report, kAllLevels).size(), 60u);
  EXPECT_EQ(read_splats(folder / "lod/0_1").size(), 20u);
  fs::remove_all(folder / "lod/0_1");
  EXPECT_EQ(read_splats(folder / "lod", &report).size(), 10u);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("level 1 is read"), std::string::npos);
  expect_error(Failure::kInput, {"0_1", "does not exist"}, [&] { read_splats(folder / "lod", nullptr, 0); });
  expect_error(Failure::kInput, {"lodLevels", "level 2"}, [&] { read_splats(folder / "lod", nullptr, 2); });
}

TEST(SogLevels, OneThatHasAnAntialiasedFileIsAntialiased) {
  const TemporaryFolder folder;
  two_levels(folder);
  json meta = json::parse(read_text(folder / "lod/0_1/meta.json"));
  meta["model"] = "antialiased";
  folder.file("lod/0_1/meta.json", meta.dump());
  for (const int level : {0, 1}) {
    ReadReport report;
    read_splats(folder / "lod", &report, level);
    EXPECT_EQ(report.antialiased, level == 0);
  }
}

TEST(SogLevels, TheirEnvironmentBelongsToEachOfThem) {
  const TemporaryFolder folder;
  json meta = two_levels(folder);
  meta["environment"] = "env/meta.json";
  folder.file("lod/lod-meta.json", meta.dump());
  ReadReport report;
  EXPECT_EQ(read_splats(folder / "lod", &report).size(), 50u);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("env/meta.json does not exist"), std::string::npos);
  const GaussianCloud environment = some_gaussians(7, 0, 20);
  for (const auto& [name, bytes] : sog_files(environment)) folder.file("lod/env/" + name, bytes);
  for (const auto& [level, count] : {std::pair{0, 50u}, {1, 10u}, {kAllLevels, 60u}, {kFinestLevel, 50u}}) {
    const GaussianCloud cloud = read_splats(folder / "lod", &report, level);
    ASSERT_EQ(cloud.size(), count + 7);
    EXPECT_LT((cloud.position[count + 3] - environment.position[3]).norm(), 1e-3f);
    EXPECT_EQ(report.rows, count + 7);
    EXPECT_TRUE(report.warnings.empty());
    EXPECT_NE(std::find(report.files.begin(), report.files.end(), folder / "lod/env/meta.json"), report.files.end());
  }
  meta["environment"] = nullptr;
  folder.file("lod/lod-meta.json", meta.dump());
  EXPECT_EQ(read_splats(folder / "lod", &report).size(), 50u);
  EXPECT_TRUE(report.warnings.empty());
}

TEST(SogLevels, HostileTreesNameTheKey) {
  const TemporaryFolder folder;
  const json good = two_levels(folder);
  const auto refused = [&](const json& pointer_and_value, const std::vector<std::string>& words) {
    json meta = good;
    for (const auto& [pointer, value] : pointer_and_value.items()) meta[json::json_pointer(pointer)] = value;
    folder.file("lod/lod-meta.json", meta.dump());
    expect_error(Failure::kInput, words, [&] { read_splats(folder / "lod"); });
  };
  refused({{"/lodLevels", 0}}, {"lodLevels"});
  refused({{"/lodLevels", 1e9}}, {"lodLevels"});
  refused({{"/version", 2}}, {"version", "2"});
  refused({{"/filenames/0", "../../etc/meta.json"}}, {"filenames", "below"});
  refused({{"/filenames/0", "/etc/meta.json"}}, {"filenames", "below"});
  refused({{"/environment", "../env/meta.json"}}, {"environment", "below"});
  refused({{"/environment", 5}}, {"environment", "5"});
  refused({{"/tree/children/0/lods/0/file", 3}}, {"file", "3"});
  refused({{"/tree/children/0/lods/0/count", -1}}, {"count", "-1"});
  refused({{"/tree/children/0/lods/0/count", 31}}, {"declares 31", "contains 30"});
  refused({{"/tree/children", 5}}, {"tree.children"});
  json deep = json::object(), shallow = deep;
  for (int k = 0; k < 1000; ++k) deep = json{{"children", json::array({deep})}};
  refused({{"/tree", deep}}, {"lod-meta.json", "nested deeper"});
  for (int k = 0; k < 70; ++k) shallow = json{{"children", json::array({shallow})}};
  refused({{"/tree", shallow}}, {"tree", "deeper than 64"});
  folder.file("lod/lod-meta.json", "{");
  expect_error(Failure::kInput, {"lod-meta.json", "JSON"}, [&] { read_splats(folder / "lod/lod-meta.json"); });
}

/// A compressed PLY of the cloud as SuperSplat writes it, every chunk with bounds [-2, 2] for positions, [-9, 2] for
/// log scales and [-0.25, 1.25] for colours.
std::string compressed_ply(const GaussianCloud& cloud, bool coloured) {
  const size_t n = cloud.size(), chunks = (n + 255) / 256;
  const int rest = 3 * (cloud.sh_count() - 1);
  std::string text = "ply\nformat binary_little_endian 1.0\nelement chunk " + std::to_string(chunks) + "\n";
  std::vector<std::pair<std::string, float>> bounds;
  for (const char* axis : {"x", "y", "z"}) {
    bounds.push_back({std::string("min_") + axis, -2.0f});
    bounds.push_back({std::string("max_") + axis, 2.0f});
  }
  for (const char* axis : {"x", "y", "z"}) {
    bounds.push_back({std::string("min_scale_") + axis, -9.0f});
    bounds.push_back({std::string("max_scale_") + axis, 2.0f});
  }
  if (coloured) {
    for (const char* axis : {"r", "g", "b"}) {
      bounds.push_back({std::string("min_") + axis, -0.25f});
      bounds.push_back({std::string("max_") + axis, 1.25f});
    }
  }
  for (const auto& [name, value] : bounds) text += "property float " + name + "\n";
  text += "element vertex " + std::to_string(n) + "\n";
  for (const char* name : {"position", "rotation", "scale", "color"})
    text += std::string("property uint packed_") + name + "\n";
  if (rest > 0) {
    text += "element sh " + std::to_string(n) + "\n";
    for (int k = 0; k < rest; ++k) text += "property uchar f_rest_" + std::to_string(k) + "\n";
  }
  text += "end_header\n";
  for (size_t k = 0; k < chunks; ++k) {
    for (const auto& [name, value] : bounds) put(text, value);
  }
  const auto bits = [](double share, int count) {
    return static_cast<uint32_t>(std::lround(share * ((1 << count) - 1)));
  };
  for (size_t i = 0; i < n; ++i) {
    const Vec3f x = (cloud.position[i].array() + 2) / 4, s = (cloud.log_scale[i].array() + 9) / 11;
    put(text, bits(x[0], 11) << 21 | bits(x[1], 10) << 11 | bits(x[2], 11));
    Vec4f q = cloud.rotation[i].normalized();
    Eigen::Index largest;
    q.cwiseAbs().maxCoeff(&largest);
    if (q[largest] < 0) q = -q;
    auto word = static_cast<uint32_t>(largest);
    for (int k = 0; k < 4; ++k) {
      if (k != largest) word = word << 10 | bits(q[k] * M_SQRT1_2 + 0.5, 10);
    }
    put(text, word);
    put(text, bits(s[0], 11) << 21 | bits(s[1], 10) << 11 | bits(s[2], 11));
    uint32_t colour = bits(sigmoid(cloud.opacity_logit[i]), 8);
    for (int c = 0; c < 3; ++c) {
      const double value = 0.5 + kSh0 * cloud.sh_of(i)[c];
      colour |= bits(coloured ? (value + 0.25) / 1.5 : value, 8) << (24 - 8 * c);
    }
    put(text, colour);
  }
  for (size_t i = 0; i < n && rest > 0; ++i) {
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < rest / 3; ++k)
        text +=
            static_cast<char>(std::clamp(std::lround((cloud.sh_of(i)[3 + 3 * k + c] / 8 + 0.5) * 256 - 0.5), 0l, 255l));
    }
  }
  return text;
}

TEST(CompressedPly, IsReadWithinItsStepsWithAndWithoutChunkColoursAndHarmonics) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    for (const bool coloured : {false, true}) {
      const GaussianCloud cloud = some_gaussians(600, degree);
      ReadReport report;
      const GaussianCloud back = read_splats(folder.file("a.compressed.ply", compressed_ply(cloud, coloured)), &report);
      ASSERT_EQ(back.size(), cloud.size());
      EXPECT_EQ(report.format, "compressed PLY, SH degree " + std::to_string(degree));
      const float steps[] = {2047, 1023, 2047};
      for (size_t i = 0; i < cloud.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(back.position[i][k], cloud.position[i][k], 0.501 * 4 / steps[k]);
          EXPECT_NEAR(back.log_scale[i][k], cloud.log_scale[i][k], 0.501 * 11 / steps[k]);
          EXPECT_NEAR(back.sh_of(i)[k], cloud.sh_of(i)[k], 0.501 * (coloured ? 1.5 : 1.0) / 255 / kSh0);
        }
        for (int k = 3; k < 3 * cloud.sh_count(); ++k)
          EXPECT_NEAR(back.sh_of(i)[k], cloud.sh_of(i)[k], 0.501 * 8 / 256);
        EXPECT_NEAR(sigmoid(back.opacity_logit[i]), sigmoid(cloud.opacity_logit[i]), 0.501 / 255);
      }
      EXPECT_LT(largest_angle(cloud, back), 2 * 2 * std::sqrt(3.0) * 0.5 * M_SQRT2 / 1023);
    }
  }
}

TEST(CompressedPly, ItsCommentsCountAsThoseOfAnyPly) {
  const TemporaryFolder folder;
  const std::string plain = compressed_ply(some_gaussians(300, 0), true);
  const std::string format = "format binary_little_endian 1.0\n";
  const auto read = [&](const std::string& comments) {
    std::string text = plain;
    text.insert(text.find(format) + format.size(), comments);
    ReadReport report;
    EXPECT_EQ(read_splats(folder.file("a.compressed.ply", text), &report).size(), 300u);
    EXPECT_EQ(report.files, std::vector<fs::path>{folder / "a.compressed.ply"});
    return report;
  };
  EXPECT_FALSE(read("").antialiased || read("").z_is_up);
  EXPECT_TRUE(read("comment SplatRenderMode: mip\n").antialiased);
  EXPECT_TRUE(read("comment antialiased 1\n").antialiased);
  const ReadReport z_up = read("comment Vertical Axis: z\n");
  EXPECT_TRUE(z_up.z_is_up && !z_up.antialiased);
}

TEST(CompressedPly, HostileFilesNameFileAndElement) {
  const TemporaryFolder folder;
  const std::string good = compressed_ply(some_gaussians(300, 1), true);
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const auto refused = [&](const std::string& bytes, std::vector<std::string> words) {
    words.push_back("case.ply");
    expect_error(Failure::kInput, words, [&] { read_splats(folder.file("case.ply", bytes)); });
  };
  refused(good.substr(0, good.size() - 1), {"element sh", "300 rows"});
  refused(replaced("vertex 300", "vertex 2000000000"), {"element chunk", "2000000000"});
  refused(replaced("chunk 2", "chunk 1"), {"element chunk", "1 rows"});
  refused(replaced("chunk 2", "chunk 99999999999"), {"element chunk", "declares"});
  refused(replaced("sh 300", "sh 299"), {"element sh", "299"});
  refused(replaced("property uchar f_rest_8\n", ""), {"element sh", "8 properties"});
  refused(replaced("uchar f_rest_8", "uint f_rest_8"), {"element sh"});
  refused(replaced("float max_z", "float max_w"), {"max_z", "missing"});
  refused(replaced("float max_b", "float max_a"), {"max_b", "missing"});
  refused(replaced("uint packed_color", "float packed_color"), {"packed_color", "another type"});
  refused(replaced("binary_little_endian", "ascii"), {"element chunk", "ascii"});
  // Bounds that are not finite take their Gaussians with them.
  std::string nan = good;
  const float value = NAN;
  std::memcpy(&nan[nan.find("end_header\n") + 11], &value, 4);
  ReadReport report;
  EXPECT_EQ(read_splats(folder.file("case.ply", nan), &report).size(), 44u);
  EXPECT_EQ(report.dropped, 256u);
}

TEST(Ply, ObjectFeaturesOfGaussianGroupingAreKept) {
  const TemporaryFolder folder;
  std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "obj_dc_0", "obj_dc_1", "obj_dc_2", "opacity",
                           "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    text += std::string("property float ") + name + "\n";
  }
  text +=
      "end_header\n0 0 0 0 0 0 1 2 3 0 0 0 0 1 0 0 0\n0 0 0 0 0 0 4 nan 6 0 0 0 0 1 0 0 0\n0 0 0 0 0 0 7 8 9 0 0 0 0 1 "
      "0 0 0\n";
  ReadReport report;
  EXPECT_EQ(read_ply(folder.file("a.ply", text), &report).size(), 2u);
  EXPECT_EQ(report.object_channels, 3);
  EXPECT_EQ(report.object_features, (std::vector<float>{1, 2, 3, 7, 8, 9}));
}

}  // namespace
}  // namespace pliant
