#include "gaussians/io/splats/sog.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/zip_archive.h"
#include "gaussians/io/images/webp.h"
#include "gaussians/io/splats/cloud_builder.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr uint64_t kMostMeta = 1 << 20;   // bytes of meta.json
constexpr uint64_t kMostPalette = 65536;  // entries that 16 bits can name
constexpr uint64_t kMostPerByte = 64;     // Gaussians for each byte of the files; real files have less than one
constexpr uint64_t kSmallScene = 4096;    // Gaussians that need no justification
constexpr int kPaletteColumns = 64;       // palette entries side by side in the picture

/// The files of a SOG by name.
struct Source {
  std::string name;         // for messages
  uint64_t file_bytes = 0;  // all files together
  std::function<std::string(const std::string& file, uint64_t most)> read;
};

/// The folder, with its '/', of the only meta.json of an archive, which may have been packed with its folder.
std::string folder_in(ZipArchive& archive) {
  std::string folder;
  for (const std::string& name : archive.names()) {
    if (name == "meta.json") return "";
    if (!name.ends_with("/meta.json")) continue;
    if (!folder.empty()) return "";
    folder = name.substr(0, name.rfind('/') + 1);
  }
  return folder;
}

Source source_in_archive(const fs::path& file) {
  auto archive = std::make_shared<ZipArchive>(file);
  return {file.string(), fs::file_size(file),
          [archive, folder = folder_in(*archive)](const std::string& name, uint64_t most) {
            return archive->read(folder + name, most);
          }};
}

Source source_in_folder(const fs::path& meta, std::vector<fs::path>& files) {
  const fs::path folder = meta.parent_path();
  Source source;
  source.name = meta.string();
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, failed)) {
    if (!entry.is_regular_file(failed)) continue;
    const uint64_t size = entry.file_size(failed);
    if (!failed) source.file_bytes += size;
  }
  source.read = [meta, folder, &files](const std::string& name, uint64_t most) {
    // Names lead nowhere but into the folder.
    if (name.empty() || fs::path(name).filename() != name || name == "..") {
      throw input_error(meta.string(), "files", "names '" + name + "'",
                        "names must be those of files in the same folder");
    }
    const fs::path file = name == "meta.json" ? meta : folder / name;
    std::error_code failed;
    const uint64_t size = fs::file_size(file, failed);
    if (!failed && size > most) {
      throw input_error(file.string(), "",
                        "has " + std::to_string(size) + " bytes, at most " + std::to_string(most) + " are justified",
                        "the file is damaged");
    }
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
    return read_text(file);
  };
  return source;
}

/// One SOG: its meta.json and pictures.
class Sog {
 public:
  explicit Sog(const Source& source)
      : source_(source),
        json_(parse_json(source.read("meta.json", kMostMeta), source.name, "meta.json")),
        meta_(json_, source.name, "", Failure::kInput) {
    if (!meta_.has("version")) {
      throw meta_.complaint("version", "is missing: this is SOG version 1",
                            "convert it, for example with: splat-transform in.sog out.ply");
    }
    if (meta_.number("version") != 2)
      throw meta_.complaint("version", "is " + json_["version"].dump(), "version 2 is read");
    count_ = whole(meta_, "count", source_.file_bytes * kMostPerByte + kSmallScene);
    // The key of the specification, and that of splat-transform.
    antialiased_ = (meta_.has("antialias") && json_["antialias"] == true) ||
                   (meta_.has("model") && json_["model"] == "antialiased");
  }

  GaussianCloud read(ReadReport& report) {
    const JsonObject means = meta_.object("means");
    const std::vector<double> low = means.numbers("mins", 3), high = means.numbers("maxs", 3);
    const ImageU8 lower = picture(means, 0), upper = picture(means, 1);
    const ImageU8 rotations = picture(meta_.object("quats"), 0);
    const JsonObject scale_keys = meta_.object("scales"), colour_keys = meta_.object("sh0");
    const ImageU8 scales = picture(scale_keys, 0), colours = picture(colour_keys, 0);
    const std::vector<double> scale_book = codebook(scale_keys), colour_book = codebook(colour_keys);
    if (meta_.has("shN")) read_palette(meta_.object("shN"));

    CloudBuilder builder(degree_, count_);
    for (size_t i = 0; i < count_; ++i) {
      SplatRow row;
      const uint8_t *l = &lower.data[4 * i], *u = &upper.data[4 * i], *c = &colours.data[4 * i];
      for (int k = 0; k < 3; ++k) {
        const double t = (l[k] + 256 * u[k]) / 65535.0, value = low[k] + (high[k] - low[k]) * t;
        row.position[k] = static_cast<float>(std::copysign(std::expm1(std::abs(value)), value));
        row.log_scale[k] = static_cast<float>(scale_book[scales.data[4 * i + k]]);
        row.sh[k] = static_cast<float>(colour_book[c[k]]);
      }
      row.opacity_logit = logit_of_byte(c[3]);
      row.rotation = unpack_rotation(&rotations.data[4 * i]);
      if (degree_ > 0) add_harmonics(i, row);
      builder.add(row);
    }
    report.format = "SOG version 2, SH degree " + std::to_string(degree_);
    report.antialiased = antialiased_;
    return builder.finish(report);
  }

 private:
  /// A whole number from 0 to `most`.
  static size_t whole(const JsonObject& object, const std::string& key, uint64_t most) {
    const double value = object.number(key);
    if (!(value >= 0 && value <= static_cast<double>(std::min<uint64_t>(most, INT32_MAX)) &&
          value == std::floor(value))) {
      throw object.complaint(
          key, "is " + std::to_string(value),
          "it must be an integer of at most " + std::to_string(most) + ", which the size of the files justifies");
    }
    return static_cast<size_t>(value);
  }

  /// The picture files[index] of a key, large enough for every Gaussian.
  ImageU8 picture(const JsonObject& keys, size_t index) {
    ImageU8 picture = decode(keys, index, 4 * count_ + 65536);
    if (picture.pixels() < count_) {
      throw keys.complaint("files",
                           "names an image of " + std::to_string(picture.pixels()) + " pixels for " +
                               std::to_string(count_) + " Gaussians",
                           "the files do not belong together");
    }
    return picture;
  }

  ImageU8 decode(const JsonObject& keys, size_t index, size_t most_pixels) {
    const nlohmann::json& files = keys.array("files");
    if (files.size() <= index || !files[index].is_string()) {
      throw keys.complaint("files", "has no name at position " + std::to_string(index), "the file is damaged");
    }
    const std::string name = files[index];
    return decode_webp(source_.read(name, 8 * most_pixels + 65536), most_pixels, source_.name + ": " + name);
  }

  /// 256 values; some writers leave the first one out as null, which continues the line of the others.
  static std::vector<double> codebook(const JsonObject& keys) {
    const nlohmann::json& array = keys.array("codebook");
    if (array.size() != 256 || !array[0].is_null()) return keys.numbers("codebook", 256);
    nlohmann::json repaired = {{"codebook", array}};
    if (array[1].is_number() && array[255].is_number()) {
      const double second = array[1], last = array[255];
      repaired["codebook"][0] = second + (second - last) / 255;
    }
    return JsonObject(repaired, keys.file(), "", Failure::kInput).numbers("codebook", 256);
  }

  void read_palette(const JsonObject& keys) {
    degree_ = static_cast<int>(whole(keys, "bands", 3));
    if (degree_ == 0) return;
    palette_count_ = whole(keys, "count", kMostPalette);
    book_ = codebook(keys);
    const size_t rest = static_cast<size_t>((degree_ + 1) * (degree_ + 1) - 1);
    palette_ = decode(keys, 0, kPaletteColumns * rest * (kMostPalette / kPaletteColumns));
    labels_ = picture(keys, 1);
    const size_t rows = (palette_count_ + kPaletteColumns - 1) / kPaletteColumns;
    if (palette_.width != static_cast<int>(kPaletteColumns * rest) || palette_.height < static_cast<int>(rows)) {
      throw keys.complaint(
          "files",
          "names a palette of " + std::to_string(palette_.width) + " x " + std::to_string(palette_.height) + " pixels",
          std::to_string(palette_count_) + " entries of degree " + std::to_string(degree_) + " take " +
              std::to_string(kPaletteColumns * rest) + " x " + std::to_string(rows));
    }
  }

  void add_harmonics(size_t i, SplatRow& row) const {
    const size_t label = labels_.data[4 * i] + 256u * labels_.data[4 * i + 1];
    if (label >= palette_count_) {
      throw input_error(source_.name, "shN.count",
                        "is " + std::to_string(palette_count_) + " but Gaussian " + std::to_string(i) +
                            " has the label " + std::to_string(label),
                        "the files do not belong together");
    }
    const int rest = (degree_ + 1) * (degree_ + 1) - 1;
    const uint8_t* entry =
        palette_.at(static_cast<int>(label % kPaletteColumns) * rest, static_cast<int>(label / kPaletteColumns));
    for (int k = 0; k < rest; ++k) {
      for (int c = 0; c < 3; ++c) row.sh[3 + 3 * k + c] = static_cast<float>(book_[entry[4 * k + c]]);
    }
  }

  /// Quaternion w, x, y, z; the fourth byte names the largest component, which is left out.
  static Vec4f unpack_rotation(const uint8_t* bytes) {
    Vec4f q(1, 0, 0, 0);
    const int largest = bytes[3] - 252;
    if (largest < 0) return q;
    float rest = 1;
    for (int k = 0, byte = 0; k < 4; ++k) {
      if (k == largest) continue;
      q[k] = (static_cast<float>(bytes[byte++]) / 127.5f - 1.0f) * static_cast<float>(M_SQRT1_2);
      rest -= q[k] * q[k];
    }
    q[largest] = std::sqrt(std::max(rest, 0.0f));
    return q;
  }

  Source source_;
  nlohmann::json json_;
  JsonObject meta_;
  size_t count_ = 0, palette_count_ = 0;
  int degree_ = 0;
  bool antialiased_ = false;
  std::vector<double> book_;
  ImageU8 palette_, labels_;
};

}  // namespace

GaussianCloud read_sog(const fs::path& file, ReadReport* report) {
  ReadReport found;
  found.files = {file};
  Sog sog(file.extension() == ".json" ? source_in_folder(file, found.files) : source_in_archive(file));
  GaussianCloud cloud = sog.read(found);
  if (report) *report = std::move(found);
  return cloud;
}

}  // namespace pliant
