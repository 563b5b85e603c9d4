// Files and pictures: atomic writes, SHA-256 against FIPS 180 vectors, nearest names, pictures there and back.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

int entries(const fs::path& folder) {
  return static_cast<int>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(Sha256, MatchesTheVectorsOfFips180) {
  EXPECT_EQ(sha256_of_text("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of_text(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of_text("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_of_text(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileEqualsThatOfItsText) {
  const TemporaryFolder folder;
  const std::string text(200000, 'x');
  EXPECT_EQ(sha256_of_file(folder.file("a.txt", text)), sha256_of_text(text));
  expect_error(Failure::kInput, {"none.txt", "does not exist"}, [&] { sha256_of_file(folder / "none.txt"); });
  expect_error(Failure::kInput, {"is a folder"}, [&] { sha256_of_file(folder.path()); });
}

TEST(WriteAtomically, LeavesTheOldFileAndNothingElseWhenWritingFails) {
  const TemporaryFolder folder;
  const fs::path file = folder / "deep/inside/a.txt";
  write_text(file, "old");
  EXPECT_THROW(write_atomically(file,
                                [](const fs::path& temporary) {
                                  EXPECT_EQ(temporary.extension(), ".txt");
                                  std::ofstream(temporary) << "half";
                                  throw std::runtime_error("disk full");
                                }),
               std::runtime_error);
  EXPECT_EQ(read_text(file), "old");
  EXPECT_EQ(entries(file.parent_path()), 1);
  write_text(file, "new");
  EXPECT_EQ(read_text(file), "new");
  expect_error(Failure::kInput, {"a folder of that name"}, [&] { write_text(folder / "deep", "x"); });
  expect_error(Failure::kInput, {"cannot be written"}, [&] { write_text(file / "below_a_file", "x"); });
}

TEST(NearestName, HasTheSmallestEditDistance) {
  EXPECT_EQ(nearest_name("camras", {"splats", "cameras", "masks"}), "cameras");
  EXPECT_EQ(nearest_name("yuong", {"density", "poisson", "young"}), "young");
  EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(Pictures, EightBitColoursSurviveAPngExactlyAndKeepRedFirst) {
  const TemporaryFolder folder;
  ImageF image(7, 5, 3);
  Random random(3);
  for (float& value : image.data) value = static_cast<float>(random.below(256)) / 255.0f;
  image(2, 1, 0) = 1.0f;
  image(2, 1, 1) = 0.0f;
  image(2, 1, 2) = 0.0f;
  write_image(folder / "a.png", image);
  const ImageF back = read_image(folder / "a.png");
  ASSERT_EQ(back.width, 7);
  ASSERT_EQ(back.height, 5);
  for (size_t i = 0; i < image.data.size(); ++i) EXPECT_NEAR(back.data[i], image.data[i], 1e-6f);
}

TEST(Pictures, ValuesOutsideTheRangeAreClampedAndGreyIsRead) {
  const TemporaryFolder folder;
  ImageF image(4, 1, 1);
  image.data = {-1.0f, 2.0f, NAN, 0.5f};
  write_image(folder / "grey.png", image);
  const ImageF back = read_image(folder / "grey.png");
  ASSERT_EQ(back.channels, 3);
  EXPECT_EQ(back(0, 0, 1), 0.0f);
  EXPECT_EQ(back(1, 0, 1), 1.0f);
  EXPECT_EQ(back(2, 0, 1), 0.0f);
  EXPECT_NEAR(back(3, 0, 2), 128.0f / 255, 1e-6f);
}

TEST(IdPictures, SurviveAtEveryDepth) {
  const TemporaryFolder folder;
  for (uint32_t largest : {255u, 65535u, 16777215u}) {
    IdImage ids(6, 3, 1);
    Random random(largest);
    for (uint32_t& id : ids.data) id = static_cast<uint32_t>(random.below(largest + 1));
    ids(5, 2) = largest;
    write_ids(folder / "ids.png", ids);
    EXPECT_EQ(read_ids(folder / "ids.png").data, ids.data) << largest;
  }
}

/// Writes a picture where no file may have a byte, as on a full disk, and ends: 7 = with the message.
[[noreturn]] void write_picture_to_a_full_disk(const fs::path& file) {
  signal(SIGXFSZ, SIG_IGN);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_FSIZE, &none);
  try {
    write_image(file, ImageF(8, 8, 3, 0.5f));
  } catch (const Error& error) {
    std::exit(std::string(error.what()).find("free space") != std::string::npos ? 7 : 8);
  }
  std::exit(9);
}

TEST(Pictures, AFullDiskIsSaid) {
  const TemporaryFolder folder;
  EXPECT_EXIT(write_picture_to_a_full_disk(folder / "a.png"), testing::ExitedWithCode(7), "");
  EXPECT_FALSE(fs::exists(folder / "a.png"));
}

TEST(Pictures, BadFilesAreNamed) {
  const TemporaryFolder folder;
  write_image(folder / "good.png", ImageF(64, 64, 3, 0.5f));
  const std::string good = read_text(folder / "good.png");
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"empty.png", ""}, {"text.png", "no picture"}, {"cut.png", good.substr(0, 20)}}) {
    const fs::path file = folder.file(name, bytes);
    expect_error(Failure::kInput, {name, "decoded"}, [&] { read_image(file); });
    expect_error(Failure::kInput, {name}, [&] { read_ids(file); });
  }
  expect_error(Failure::kInput, {"does not exist"}, [&] { read_image(folder / "none.png"); });
  expect_error(Failure::kInput, {"is not a file"}, [&] { read_image(folder.path()); });
  write_image(folder / "ids.jpg", ImageF(8, 8, 3, 0.5f));
  expect_error(Failure::kInput, {"JPEG"}, [&] { read_ids(folder / "ids.jpg"); });
  expect_error(Failure::kInput, {"cannot be written"}, [&] { write_image(folder / "a.nonsense", ImageF(8, 8, 3)); });
}

}  // namespace
}  // namespace pliant
