#include "app/store/segmentation.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/store/hdf5_file.h"
#include "gaussians/base/error.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

std::map<uint32_t, std::string> read_names(const Hdf5Reader& in) {
  const json names = json::parse(in.text("/", "names"), nullptr, false);
  if (!names.is_object()) throw in.complaint("/@names", "is not a JSON object id -> name");
  std::map<uint32_t, std::string> out;
  for (const auto& [id, name] : names.items()) {
    if (!name.is_string() || id.empty() || id.size() > 10 || id.find_first_not_of("0123456789") != std::string::npos ||
        std::stoull(id) > UINT32_MAX) {
      throw in.complaint("/@names", "has the entry '" + id + "'");
    }
    out[static_cast<uint32_t>(std::stoull(id))] = name.get<std::string>();
  }
  return out;
}

std::string names_json(const std::map<uint32_t, std::string>& names) {
  json out = json::object();
  for (const auto& [id, name] : names) out[std::to_string(id)] = name;
  return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

void write_segmentation(const fs::path& file, const Segmentation& s, const std::string& provenance_json) {
  const size_t n = s.label.size(), classes = s.class_id.size();
  CHECK(s.attribute.size() == n * kSemanticChannels && s.confidence.size() == n && s.seen.size() == n);
  CHECK(s.classifier.size() == classes * kSemanticChannels && s.classifier_bias.size() == classes);
  CHECK(s.class_name.size() == classes);
  std::map<uint32_t, std::string> names;
  for (size_t c = 0; c < classes; ++c) names[s.class_id[c]] = s.class_name[c];
  write_hdf5(file, [&](Hdf5Writer& out) {
    out.dataset("/attribute", s.attribute.data(), {n, kSemanticChannels});
    out.dataset("/classifier", s.classifier.data(), {classes, kSemanticChannels});
    out.dataset("/classifier_bias", s.classifier_bias.data(), {classes});
    out.dataset("/class_id", s.class_id.data(), {classes});
    out.dataset("/label", s.label.data(), {n});
    out.dataset("/confidence", s.confidence.data(), {n});
    out.dataset("/seen", s.seen.data(), {n});
    std::vector<int32_t> cameras, ends;
    for (const std::vector<int>& list : s.class_cameras) {
      cameras.insert(cameras.end(), list.begin(), list.end());
      ends.push_back(static_cast<int32_t>(cameras.size()));
    }
    if (!cameras.empty()) {
      out.dataset("/class_cameras", cameras.data(), {cameras.size()});
      out.dataset("/class_cameras_end", ends.data(), {ends.size()});
    }
    out.text("/", "names", names_json(names));
    if (!s.class_origin.empty())
      out.text("/", "origins", json(s.class_origin).dump(-1, ' ', false, json::error_handler_t::replace));
    out.number("/", "next_id", unused_id(s));
    out.number("/", "screen_variance", s.screen_variance);
    out.text("/", "provenance", provenance_json);
  });
}

namespace {

/// class_cameras of a file that has them: a list of cameras, and where the part of every class ends.
void read_class_cameras(const Hdf5Reader& in, Segmentation& s) {
  if (!in.has("/class_cameras")) return;
  const std::vector<int32_t> cameras = in.dataset<int32_t>("/class_cameras", {kAny});
  const std::vector<int32_t> ends = in.dataset<int32_t>("/class_cameras_end", {s.class_id.size()});
  size_t begin = 0;
  for (int32_t end : ends) {
    if (end < 0 || static_cast<size_t>(end) < begin || static_cast<size_t>(end) > cameras.size())
      throw in.complaint("/class_cameras_end", "holds " + std::to_string(end) + ", which is not the end of a list");
    s.class_cameras.emplace_back(cameras.begin() + static_cast<std::ptrdiff_t>(begin), cameras.begin() + end);
    begin = static_cast<size_t>(end);
  }
}

}  // namespace

Segmentation read_segmentation(const fs::path& file) {
  const Hdf5Reader in(file);
  Segmentation s;
  s.label = in.dataset<uint32_t>("/label", {kAny});
  s.class_id = in.dataset<uint32_t>("/class_id", {kAny});
  const size_t n = s.label.size(), classes = s.class_id.size();
  s.attribute = in.dataset<float>("/attribute", {n, kSemanticChannels});
  s.classifier = in.dataset<float>("/classifier", {classes, kSemanticChannels});
  s.classifier_bias = in.dataset<float>("/classifier_bias", {classes});
  s.confidence = in.dataset<float>("/confidence", {n});
  s.seen = in.dataset<uint8_t>("/seen", {n});
  if (!std::is_sorted(s.class_id.begin(), s.class_id.end(), std::less_equal<>())) {
    throw in.complaint("/class_id", "is not strictly ascending");
  }
  const std::map<uint32_t, std::string> names = read_names(in);
  for (uint32_t id : s.class_id) {
    const auto found = names.find(id);
    if (found == names.end()) throw in.complaint("/@names", "lacks id " + std::to_string(id));
    s.class_name.push_back(found->second);
  }
  read_class_cameras(in, s);
  if (in.has_attribute("/", "origins")) {
    const json origins = json::parse(in.text("/", "origins"), nullptr, false);
    if (!origins.is_array() || origins.size() != classes)
      throw in.complaint("/@origins", "is not one text for each id");
    for (const json& origin : origins) {
      if (!origin.is_string()) throw in.complaint("/@origins", "contains a value that is not text");
      s.class_origin.push_back(origin.get<std::string>());
    }
  }
  if (in.has_attribute("/", "screen_variance")) {
    s.screen_variance = in.number("/", "screen_variance");
    if (!(s.screen_variance > 0 && s.screen_variance < 100))
      throw in.complaint("/@screen_variance",
                         "is " + std::to_string(s.screen_variance) + ", which is not a filter variance");
  }
  if (in.has_attribute("/", "next_id")) {
    const double next = in.number("/", "next_id");
    if (!(next >= 0 && next <= UINT32_MAX))
      throw in.complaint("/@next_id", "is " + std::to_string(next) + ", which is not an id");
    s.next_id = static_cast<uint32_t>(next);
  }
  return s;
}

void write_labels(const fs::path& file, const LabelFile& labels, const std::string& provenance_json) {
  write_hdf5(file, [&](Hdf5Writer& out) {
    out.dataset("/label", labels.label.data(), {labels.label.size()});
    out.text("/", "names", names_json(labels.names));
    out.text("/", "provenance", provenance_json);
  });
}

LabelFile read_labels(const fs::path& file) {
  const Hdf5Reader in(file);
  return {in.dataset<uint32_t>("/label", {kAny}), read_names(in)};
}

}  // namespace pliant
