#include "gaussians/io/splats/splat_file.h"

#include <algorithm>

#include "gaussians/io/files/byte_reader.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/cloud_builder.h"

namespace pliant {
namespace {

/// One row as it lies in the file.
struct Record {
  float position[3], scale[3];
  uint8_t colour[3], alpha, rotation[4];
};
static_assert(sizeof(Record) == 32);

}  // namespace

GaussianCloud read_splat(const std::filesystem::path& file, ReadReport* report) {
  const std::string bytes = read_text(file);
  if (bytes.empty()) throw input_error(file.string(), "", "is empty", "the file is truncated or not a .splat file");
  if (bytes.size() % sizeof(Record) != 0) {
    throw input_error(file.string(), "", "has " + std::to_string(bytes.size()) + " bytes, not a multiple of 32",
                      "the file is truncated or not a .splat file");
  }
  ByteReader in(bytes, file.string());
  CloudBuilder builder(0, bytes.size() / sizeof(Record));
  while (in.left() > 0) {
    const auto record = in.take<Record>("row");
    SplatRow row;
    for (int k = 0; k < 3; ++k) {
      row.position[k] = record.position[k];
      row.log_scale[k] = std::log(record.scale[k]);
      row.sh[k] = sh_of_color(static_cast<float>(record.colour[k]) / 255.0f);
    }
    row.opacity_logit = logit_of_byte(record.alpha);
    for (int k = 0; k < 4; ++k) row.rotation[k] = (static_cast<float>(record.rotation[k]) - 128.0f) / 128.0f;
    builder.add(row);
  }
  ReadReport found;
  found.format = ".splat";
  found.files = {file};
  GaussianCloud cloud = builder.finish(found);
  if (report) *report = std::move(found);
  return cloud;
}

void write_splat(const std::filesystem::path& file, const GaussianCloud& cloud) {
  std::string bytes;
  bytes.reserve(cloud.size() * sizeof(Record));
  for (size_t i = 0; i < cloud.size(); ++i) {
    Record record;
    for (int k = 0; k < 3; ++k) {
      record.position[k] = cloud.position[i][k];
      record.scale[k] = std::exp(cloud.log_scale[i][k]);
      record.colour[k] = byte_of(dc_color(cloud.sh_of(i)[k]));
    }
    record.alpha = byte_of(sigmoid(cloud.opacity_logit[i]));
    // The byte 255 is 127/128, so the quaternion is turned to have its largest component negative, where 0 is -1.
    Vec4f q = cloud.rotation[i].normalized();
    Eigen::Index largest;
    q.cwiseAbs().maxCoeff(&largest);
    if (q[largest] > 0) q = -q;
    for (int k = 0; k < 4; ++k) {
      record.rotation[k] = static_cast<uint8_t>(std::clamp(std::lround(q[k] * 128.0f + 128.0f), 0l, 255l));
    }
    bytes.append(reinterpret_cast<const char*>(&record), sizeof record);
  }
  write_text(file, bytes);
}

}  // namespace pliant
