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
    out.text("/", "names", names_json(names));
    out.text("/", "provenance", provenance_json);
  });
}

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
