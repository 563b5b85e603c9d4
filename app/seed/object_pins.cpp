#include "app/seed/object_pins.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"

namespace pliant {
using nlohmann::json;

namespace {

/// What the scene file holds of the object, and --pin-below, in scene units.
std::vector<Region> given_regions(const Context& context, const Scene& scene, const FillStage& stage,
                                  const SolidSamples& samples) {
  std::vector<Region> pins;
  for (size_t k = 0; k < scene.settings.pinned.size(); ++k) {
    const SceneFile::Region& region = scene.settings.pinned[k];
    const Vec3d low = region.low.cast<double>();
    const Region pin =
        region.sphere ? Region::sphere(low, region.high.x()) : Region::box(low, region.high.cast<double>());
    if (std::any_of(samples.position.begin(), samples.position.end(),
                    [&](const Vec3f& x) { return pin.contains(x.cast<double>()); }))
      pins.push_back(pin);
    else
      context.progress.warn(
          fmt::format("{}: pinned[{}] holds nothing of this object and is left out", scene.settings.file.string(), k));
  }
  if (stage.pin_below) pins.push_back(Region::half_space(scene.up * *stage.pin_below, scene.up));
  return pins;
}

/// A half space that holds the object where nobody says what does.
struct FoundHold {
  Region region;
  std::string support;  ///< that touches the object; empty = none, and the region is the object's lowest tenth
};

/// `given`: whether something else holds the object.
std::optional<FoundHold> find_hold(const Scene& scene, const FillStage& stage, const GaussianCloud& object,
                                   const json& extract, bool given) {
  if (!stage.pin_contact || stage.pin_below) return std::nullopt;
  if (extract.contains("contact")) {
    const json& contact = extract["contact"];
    const Vec3d point(contact["point"][0], contact["point"][1], contact["point"][2]);
    const Vec3d normal(contact["normal"][0], contact["normal"][1], contact["normal"][2]);
    return FoundHold{Region::half_space(point + normal * contact["band"].get<double>(), normal), contact["support"]};
  }
  if (given) return std::nullopt;
  const Framing framing = robust_framing(object, scene.up);
  const double height = framing.high.z() - framing.low.z();
  return FoundHold{Region::half_space(scene.up * (framing.low.z() + kHeldShare * height), scene.up), ""};
}

/// The hold, up to half of the height of the solid at most, so that something can move; none of a flat solid, no part
/// of which is lower than the rest.
std::optional<Region> hold_of(const Context& context, const FoundHold& found, const SolidSamples& samples) {
  constexpr double kFlat = 2;  // spacings of samples
  const bool carried = !found.support.empty();
  Region hold = found.region;
  double low = INFINITY, high = -INFINITY;
  for (const Vec3f& x : samples.position) {
    const double height = hold.signed_distance(x.cast<double>());
    low = std::min(low, height);
    high = std::max(high, height);
  }
  if (high - low < kFlat * samples.spacing) {
    context.progress.say(carried
                             ? "seed: not fixed where it touches '" + found.support + "', because the object is flat"
                             : "seed: no support found, and the object is flat, so none of it is fixed");
    return std::nullopt;
  }
  const double middle = 0.5 * (low + high);
  const bool lowered = middle < 0;
  if (lowered) hold.point += middle * hold.vector;
  if (carried)
    context.progress.say(fmt::format("seed: fixed where it touches '{}'{}", found.support,
                                     lowered ? ", up to half of the object's height" : ""));
  else
    context.progress.say(
        fmt::format("seed: no support found, so the object's lowest {} is fixed (--pin-below fixes another part, "
                    "--no-pin-contact none)",
                    lowered ? "half" : "tenth"));
  return hold;
}

/// Regions that the user gave must leave something that moves.
void require_free(const Scene& scene, const FillStage& stage, const std::vector<Region>& pins,
                  const SolidSamples& samples) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec3f& x : samples.position) {
    const Vec3d at = x.cast<double>();
    if (std::none_of(pins.begin(), pins.end(), [&](const Region& pin) { return pin.contains(at); })) return;
    low = std::min(low, scene.up.dot(at));
    high = std::max(high, scene.up.dot(at));
  }
  if (stage.pin_below)
    throw usage_error(
        "--pin-below", fmt::format("{:g}", *stage.pin_below), "fixes the whole object",
        fmt::format("give a lower height: along up, the object lies between {:.4g} and {:.4g}", low, high));
  throw usage_error("scene.json", "pinned", "covers the whole object",
                    "shrink the regions, so that something can move");
}

}  // namespace

std::vector<Region> object_pins(const Context& context, const Scene& scene, const FillStage& stage, const json& extract,
                                const GaussianCloud& object, const SolidSamples& samples) {
  std::vector<Region> pins = given_regions(context, scene, stage, samples);
  if (const std::optional<FoundHold> found = find_hold(scene, stage, object, extract, !pins.empty()))
    if (const std::optional<Region> hold = hold_of(context, *found, samples)) pins.push_back(*hold);
  if (!pins.empty()) require_free(scene, stage, pins, samples);
  return pins;
}

}  // namespace pliant
