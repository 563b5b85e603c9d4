// State dicts of PyTorch are read without running anything: values as written, and everything else refused by name.
// The files are made here byte by byte, as torch.save lays them out.

#include "app/import/state_dict.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/app/torch_files.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

TEST(StateDict, TensorsOfAConvolutionAreReadAsWritten) {
  const TemporaryFolder folder;
  std::vector<float> weight, bias = {0.5f, -1.25f, 3e-5f};
  for (int k = 0; k < 12; ++k) weight.push_back(0.1f * static_cast<float>(k) - 0.3f);
  const auto file =
      folder.file("classifier.pth", torch_archive("classifier", conv_pickle(3, 4), {floats(weight), floats(bias)}));
  const auto tensors = read_state_dict(file);
  ASSERT_EQ(tensors.size(), 2u);
  EXPECT_EQ(tensors.at("weight").shape, (std::vector<int64_t>{3, 4, 1, 1}));
  EXPECT_EQ(tensors.at("weight").data, weight);
  EXPECT_EQ(tensors.at("bias").data, bias);
}

TEST(StateDict, StridesOffsetsAndOtherPrecisionsAreHonoured) {
  const TemporaryFolder folder;
  // A transposed view [2, 3] of a storage of doubles [3, 2] that begins at the second element of the storage.
  std::string doubles;
  for (double value : {9.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) doubles.append(reinterpret_cast<const char*>(&value), 8);
  // 1, -2, 1/1024 (a number) and 2^-24 (the least) in half precision; the same kind of bits as bfloat16 below.
  const uint16_t half[4] = {0x3c00, 0xc000, 0x1400, 0x0001}, brain[2] = {0x3f80, 0xc000};
  const std::string pickle = pickle_of({{"t", tensor_pickle("DoubleStorage", 0, 7, 1, {2, 3}, {1, 2})},
                                        {"h", tensor_pickle("HalfStorage", 1, 4, 0, {4}, {1})},
                                        {"b", tensor_pickle("BFloat16Storage", 2, 2, 0, {2}, {1})},
                                        {"steps", tensor_pickle("LongStorage", 3, 1, 0, {}, {})}});
  const auto tensors = read_state_dict(folder.file(
      "s.pth", torch_archive("archive", pickle,
                             {doubles, std::string(reinterpret_cast<const char*>(half), 8),
                              std::string(reinterpret_cast<const char*>(brain), 4), std::string(8, '\1')})));
  EXPECT_EQ(tensors.at("t").data, (std::vector<float>{1, 3, 5, 2, 4, 6}));
  EXPECT_EQ(tensors.at("h").data, (std::vector<float>{1, -2, 1.0f / 1024, std::ldexp(1.0f, -24)}));
  EXPECT_EQ(tensors.at("b").data, (std::vector<float>{1, -2}));
  EXPECT_FALSE(tensors.count("steps"));
}

TEST(StateDict, APickleThatWouldRunAProgramIsRefusedByName) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& pickle, const std::vector<std::string>& words) {
    expect_error(Failure::kInput, words,
                 [&] { read_state_dict(folder.file("evil.pth", torch_archive("archive", pickle, {}))); });
  };
  const std::string head = "\x80\x02";
  refused(head + "cos\nsystem\nX" + std::string("\x04\0\0\0echo", 8) + "\x85R.", {"os.system", "run a program"});
  refused(head + "cbuiltins\neval\n(X" + std::string("\x01\0\0\0", 4) + "1tR.", {"builtins.eval"});
  refused(head + "c__builtin__\ngetattr\n.", {"__builtin__.getattr"});
  refused(head + "(i__main__\nx\n.", {"operation"});  // INST
  refused(head + "\x93.", {"operation 147"});         // STACK_GLOBAL
  refused(std::string("\x80\x04\x95", 3), {"protocol 4"});
  refused(head + "R.", {"empty stack"});
  refused(head + "}u.", {"mark"});
  refused(head + "h\x05.", {"never memoized"});
  refused(head + "K\x01K\x02s.", {"empty stack"});
  refused(head + "X" + std::string("\xff\xff\xff\x7f", 4), {"ends inside"});
  refused(head + "K\x07.", {"not a dict"});
  refused(head + "ccollections\nOrderedDict\nK\x01\x85R.", {"OrderedDict"});
}

TEST(StateDict, TensorsThatReachBeyondTheirStorageAreRefused) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& tensor, const std::string& word) {
    const std::string pickle = pickle_of({{"weight", tensor}});
    expect_error(Failure::kInput, {"weight", word}, [&] {
      read_state_dict(folder.file("t.pth", torch_archive("archive", pickle, {floats({1, 2, 3, 4})})));
    });
  };
  refused(tensor_pickle("FloatStorage", 0, 4, 0, {5}, {1}), "more elements");
  refused(tensor_pickle("FloatStorage", 0, 4, 2, {3}, {1}), "beyond the end");
  refused(tensor_pickle("FloatStorage", 0, 4, 0, {2, 2}, {3, 1}), "beyond the end");
  refused(tensor_pickle("FloatStorage", 0, 4, 0, {4}, {-1}), "impossible");
  refused(tensor_pickle("FloatStorage", 0, 4, 0, {2}, {1, 1}), "dimensions");
  refused(tensor_pickle("FloatStorage", 0, 5, 0, {4}, {1}), "bytes");
  refused(tensor_pickle("FloatStorage", 0, 1 << 30, 0, {1 << 30}, {1}), "bytes");
}

TEST(StateDict, OtherFormatsAreNamedAndNoTruncationCrashes) {
  const TemporaryFolder folder;
  const std::string old("\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.\x80\x02", 17);
  expect_error(Failure::kInput, {"before version 1.6"}, [&] { read_state_dict(folder.file("old.pth", old)); });
  expect_error(Failure::kInput, {"not a zip archive"}, [&] { read_state_dict(folder.file("text.pth", "hello")); });
  expect_error(Failure::kInput, {"TorchScript"}, [&] {
    read_state_dict(folder.file("script.pt", zip_archive({{"m/data.pkl", "x"}, {"m/constants.pkl", "y"}})));
  });
  expect_error(Failure::kInput, {"data.pkl", "missing"}, [&] {
    read_state_dict(folder.file("empty.pth", zip_archive({{"m/version", "3"}})));
  });
  expect_error(Failure::kInput, {"byteorder"}, [&] {
    read_state_dict(folder.file("big.pth", zip_archive({{"m/data.pkl", conv_pickle(1, 1)}, {"m/byteorder", "big"}})));
  });
  const std::string good = torch_archive("a", conv_pickle(2, 3), {floats({1, 2, 3, 4, 5, 6}), floats({7, 8})});
  for (size_t length = 0; length < good.size(); length += 7)
    EXPECT_THROW(read_state_dict(folder.file("cut.pth", good.substr(0, length))), Error) << length;
  const std::string pickle = conv_pickle(2, 3);
  for (size_t length = 0; length < pickle.size(); ++length)
    EXPECT_THROW(read_state_dict(folder.file("cut.pth", torch_archive("a", pickle.substr(0, length),
                                                                      {floats({1, 2, 3, 4, 5, 6}), floats({7, 8})}))),
                 Error)
        << length;
  // Every byte of the pickle flipped in turn: an error or other values, never a crash.
  for (size_t at = 0; at < pickle.size(); ++at)
    for (int bit : {0, 3, 6}) {
      std::string flipped = pickle;
      flipped[at] = static_cast<char>(flipped[at] ^ 1 << bit);
      try {
        read_state_dict(
            folder.file("flip.pth", torch_archive("a", flipped, {floats({1, 2, 3, 4, 5, 6}), floats({7, 8})})));
      } catch (const Error&) {
      }
    }
}

}  // namespace
}  // namespace pliant
