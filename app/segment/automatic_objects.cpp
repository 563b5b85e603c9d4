#include "app/segment/automatic_objects.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

const char* kind_name(FoundThing::Kind kind) {
  switch (kind) {
    case FoundThing::Kind::kObject:
      return "object";
    case FoundThing::Kind::kSupport:
      return "support";
    case FoundThing::Kind::kRest:
      break;
  }
  return "rest";
}

}  // namespace

bool segments_automatically(const SegmentStage& stage, bool selecting, bool has_masks) {
  if (!stage.automatic) return !selecting && !stage.joint && !has_masks;
  const char* other = selecting ? "a selection" : stage.joint ? "--joint" : !stage.masks.empty() ? "--masks" : nullptr;
  if (other)
    throw usage_error("--auto", "", fmt::format("was given together with {}", other),
                      "give one of them: --auto finds the objects without masks and prompts");
  return true;
}

AutomaticResult find_automatically(const Context& context, const Scene& scene, const std::vector<int>& held_out) {
  AutomaticOptions options;
  options.up = scene.up.cast<float>();
  options.held_out = held_out;
  options.support.seed = context.seed + 1;
  options.solid.footprint.render.antialiased = scene.report.antialiased;
  AutomaticResult result = find_objects(options, scene.cloud, scene.cameras);
  context.progress.say("segment: automatic: " + result.summary.describe() +
                       fmt::format(" ({:.1f} s)", result.summary.seconds));
  if (result.summary.objects == 0)
    context.progress.warn("no free-standing object was found; select one with --box, --click, --aabb or --sphere");
  return result;
}

std::map<uint32_t, std::string> names_of(const std::vector<FoundThing>& found) {
  std::map<uint32_t, std::string> names;
  for (const FoundThing& thing : found) names[thing.id] = thing.name;
  return names;
}

void tell_how_found(const std::vector<FoundThing>& found, Segmentation& segmentation) {
  segmentation.class_origin.resize(segmentation.class_id.size());
  for (const FoundThing& thing : found)
    if (const int c = class_of_id(segmentation, thing.id); c >= 0)
      segmentation.class_origin[c] = "automatically: " + thing.how;
}

void tell_kinds(const std::vector<FoundThing>& found, nlohmann::json& objects) {
  for (nlohmann::json& row : objects)
    for (const FoundThing& thing : found)
      if (row.at("id") == thing.id) row["kind"] = kind_name(thing.kind);
}

std::vector<uint32_t> supports_among(const nlohmann::json& objects) {
  std::vector<uint32_t> ids;
  for (const nlohmann::json& row : objects)
    if (row.is_object() && row.contains("kind") && row["kind"] == kind_name(FoundThing::Kind::kSupport))
      ids.push_back(row.at("id"));
  return ids;
}

}  // namespace pliant
