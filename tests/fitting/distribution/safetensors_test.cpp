#include "fitting/distribution/safetensors.h"

#include <gtest/gtest.h>

#include "gaussians/io/files/files.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::string with_header(const std::string& header, size_t data) {
  const uint64_t length = header.size();
  return std::string(reinterpret_cast<const char*>(&length), 8) + header + std::string(data, '\0');
}
std::string entry(const std::string& name, const std::string& type, const std::string& shape,
                  const std::string& offsets) {
  return "\"" + name + "\":{\"dtype\":\"" + type + "\",\"shape\":" + shape + ",\"data_offsets\":" + offsets + "}";
}
void refuse(const std::vector<std::string>& words, const std::string& bytes) {
  SCOPED_TRACE(words[0]);
  std::vector<std::string> all = words;
  all.push_back("weights.safetensors");
  expect_error(Failure::kInput, all, [&] { parse_safetensors(bytes, "weights.safetensors"); });
}

TEST(SafeTensorsFile, IsReadAsItWasWritten) {
  TemporaryFolder folder;
  SafeTensors content;
  content.arrays["a"] = {{2, 3}, {1, 2, 3, 4, 5, 6}};
  content.arrays["none"] = {{0}, {}};
  content.arrays["one"] = {{}, {-0.5f}};
  content.metadata["recipe"] = "{\"seed\": 1}";
  write_safetensors(folder / "w.safetensors", content);
  const SafeTensors read = read_safetensors(folder / "w.safetensors");
  ASSERT_EQ(read.arrays.size(), 3u);
  EXPECT_EQ(read.arrays.at("a").shape, (std::vector<int64_t>{2, 3}));
  EXPECT_EQ(read.arrays.at("a").values, content.arrays["a"].values);
  EXPECT_TRUE(read.arrays.at("none").values.empty());
  EXPECT_EQ(read.arrays.at("one").values, std::vector<float>{-0.5f});
  EXPECT_EQ(read.metadata, content.metadata);
  EXPECT_EQ(read_text(folder / "w.safetensors").size() % 4, 0u);
}

// The bytes of a file that another program wrote: the format is Hugging Face's.
TEST(SafeTensorsFile, IsTheFormatOfOthers) {
  const float values[2] = {1.5f, -2};
  std::string bytes = with_header("{" + entry("x", "F32", "[1,2]", "[0,8]") + "}", 0);
  bytes.append(reinterpret_cast<const char*>(values), 8);
  const SafeTensors read = parse_safetensors(bytes, "x");
  EXPECT_EQ(read.values("x", {1, 2}, "x"), (std::vector<float>{1.5f, -2}));
  expect_error(Failure::kInput, {"y", "missing"}, [&] { read.values("y", {2}, "x"); });
  expect_error(Failure::kInput, {"[1, 2]", "[2]"}, [&] { read.values("x", {2}, "x"); });
  expect_error(Failure::kInput, {"recipe", "missing"}, [&] { read.text("recipe", "x"); });
}

TEST(SafeTensorsFile, DamageIsNamed) {
  refuse({"header length", "truncated"}, "");
  refuse({"header length"}, "abc");
  refuse({"header length"}, std::string(8, '\xff') + "{}");
  refuse({"header"}, with_header("{}", 0).substr(0, 9));
  refuse({"header"}, with_header("[1]", 0));
  refuse({"header"}, with_header("{\"x\": ", 0));
  refuse({"truncated"}, with_header("{" + entry("x", "F32", "[4]", "[0,16]") + "}", 12));
  refuse({"F16", "not F32"}, with_header("{" + entry("x", "F16", "[4]", "[0,8]") + "}", 8));
  refuse({"8 bytes", "[4]"}, with_header("{" + entry("x", "F32", "[4]", "[0,8]") + "}", 8));
  refuse({"offsets"}, with_header("{" + entry("x", "F32", "[1]", "[-4,0]") + "}", 8));
  refuse({"beyond"}, with_header("{" + entry("x", "F32", "[1]", "[8,4]") + "}", 8));
  refuse({"impossible shape"}, with_header("{" + entry("x", "F32", "[-1]", "[0,4]") + "}", 8));
  refuse({"shape"}, with_header("{" + entry("x", "F32", "[4294967296,4294967296]", "[0,0]") + "}", 8));
  refuse({"shares bytes"},
         with_header("{" + entry("x", "F32", "[2]", "[0,8]") + "," + entry("y", "F32", "[2]", "[4,12]") + "}", 12));
  refuse({"has no dtype"}, with_header("{\"x\": 3}", 8));
  refuse({"__metadata__"}, with_header("{\"__metadata__\": 3}", 8));
  refuse({"__metadata__.k"}, with_header("{\"__metadata__\": {\"k\": 3}}", 8));
}

TEST(SafeTensorsFile, EveryTruncationIsRefused) {
  TemporaryFolder folder;
  SafeTensors content;
  content.arrays["a"] = {{3}, {1, 2, 3}};
  content.metadata["kind"] = "k";
  write_safetensors(folder / "w", content);
  const std::string bytes = read_text(folder / "w");
  for (size_t n = 0; n < bytes.size(); ++n)
    expect_error(Failure::kInput, {"w"}, [&] { parse_safetensors(bytes.substr(0, n), "w"); });
}

}  // namespace
}  // namespace pliant
