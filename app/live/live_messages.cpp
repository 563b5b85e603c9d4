#include "app/live/live_messages.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "app/live/message_fields.h"
#include "gaussians/base/error.h"
#include "physics/mpm/whole_deformation.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr size_t kMostCommands = 256;
constexpr char kWhere[] = "message";

static_assert(std::endian::native == std::endian::little, "messages are written as they lie in memory");

LiveStart parse_start(const json& value, size_t drivers) {
  LiveStart start{drivers, 0, 0};
  if (!value.is_object()) throw usage_error(kWhere, "start", "is " + value.dump().substr(0, 40), "give an object");
  for (const auto& [key, entry] : value.items()) {
    if (key == "drivers")
      start.drivers = static_cast<size_t>(whole_number(entry, "drivers", 1, 10'000'000));
    else if (key == "clustered_to")
      start.clustered_to = static_cast<int>(whole_number(entry, "clustered_to", 0, 10'000'000));
    else if (key == "frame")
      start.frame = static_cast<size_t>(whole_number(entry, "frame", 0, 1'000'000'000));
    else
      throw usage_error(kWhere, "start", "has the key " + key.substr(0, 40), "give drivers, clustered_to, frame");
  }
  if (start.clustered_to > 0 && !value.contains("drivers")) start.drivers = 0;
  return start;
}

/// Appends values as whole numbers of `Type`, as which `most` stands for the largest one.
template <class Type>
void add_quantised(std::string& out, const float* values, size_t count, float most) {
  constexpr float kLargest = std::numeric_limits<Type>::max();
  const float factor = most > 0 ? kLargest / most : 0;
  const size_t at = out.size();
  out.resize(at + count * sizeof(Type));
  for (size_t i = 0; i < count; ++i) {
    const Type q = static_cast<Type>(std::lround(factor * values[i]));
    std::memcpy(out.data() + at + i * sizeof(Type), &q, sizeof(Type));
  }
}

float largest_of(const std::vector<float>& values) {
  float most = 0;
  for (const float v : values) most = std::max(most, std::abs(v));
  return most;
}

json pairs_of(const std::vector<std::pair<int, Vec3d>>& pairs) {
  json out = json::array();
  for (const auto& [number, v] : pairs) out.push_back({number, v.x(), v.y(), v.z()});
  return out;
}

}  // namespace

LiveRequest parse_request(std::string_view text, const InteractionFrame& frame, size_t drivers) {
  if (text.size() > kMostMessage)
    throw usage_error(kWhere, "", fmt::format("has {} bytes", text.size()),
                      fmt::format("send at most {}", kMostMessage));
  const json all = parse_message(text, "app/live/live_messages.h");
  LiveRequest out;
  for (const auto& [key, value] : all.items()) {
    if (key == "id") {
      out.id = static_cast<int>(whole_number(value, "id", 0, 1'000'000'000));
    } else if (key == "start") {
      out.start = parse_start(value, drivers);
    } else if (key == "commands") {
      if (!value.is_array() || value.size() > kMostCommands)
        throw usage_error(kWhere, "commands", "is not an array of at most 256", "send fewer at a time");
      for (const json& command : value) out.commands.push_back(parse_command(command, frame, "commands"));
    } else if (key == "frames") {
      out.frames = static_cast<int>(whole_number(value, "frames", 1, kMostFramesAsked));
    } else if (key == "run") {
      out.run = truth_value(value, "run");
    } else if (key == "describe") {
      out.describe = truth_value(value, "describe");
    } else {
      throw usage_error(kWhere, key.substr(0, 40), "is unknown", "give id, start, commands, frames, run or describe");
    }
  }
  return out;
}

namespace {

std::string message_of(const SimulationState& state, const LiveSession& session, json meta, double metres_per_unit) {
  const std::vector<Mat3f> F = whole_deformation(state);
  const size_t n = state.size();
  const float units = static_cast<float>(1 / metres_per_unit);
  Vec3f low = Vec3f::Constant(INFINITY), high = Vec3f::Constant(-INFINITY);
  for (const Vec3f& x : state.x) {
    low = low.cwiseMin(units * x);
    high = high.cwiseMax(units * x);
  }
  const Vec3f size = high - low;
  std::vector<float> place(3 * n), velocity(3 * n), gradient(9 * n);
  for (size_t i = 0; i < n; ++i) {
    for (int a = 0; a < 3; ++a) {
      place[3 * i + a] = size[a] > 0 ? std::clamp((units * state.x[i][a] - low[a]) / size[a], 0.0f, 1.0f) : 0;
      velocity[3 * i + a] = state.v[i][a];
    }
    for (int k = 0; k < 9; ++k) gradient[9 * i + k] = F[i](k / 3, k % 3) - (k % 4 == 0 ? 1.0f : 0.0f);
  }
  const float speed = largest_of(velocity), stretch = largest_of(gradient);
  meta["low"] = {low.x(), low.y(), low.z()};
  meta["size"] = {size.x(), size.y(), size.z()};
  meta["speed"] = speed;
  meta["gradient"] = stretch;
  std::string text = meta.dump(-1, ' ', false, json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');

  std::string out;
  const auto add = [&](auto value) { out.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  out += "PLNT";
  add(uint16_t{1});
  add(uint16_t{1});
  add(static_cast<uint32_t>(session.frames()));
  add(static_cast<uint32_t>(n));
  add(session.time());
  add(static_cast<uint32_t>(text.size()));
  add(static_cast<uint32_t>(15 * sizeof(uint16_t)));
  out += text;
  add_quantised<uint16_t>(out, place.data(), place.size(), 1);
  add_quantised<int16_t>(out, velocity.data(), velocity.size(), speed);
  add_quantised<int16_t>(out, gradient.data(), gradient.size(), stretch);
  return out;
}

}  // namespace

std::string state_message(const LiveSession& session, const LiveAnswer& answer, std::optional<int> id,
                          double metres_per_unit) {
  json meta = {{"substeps", answer.substeps},
               {"ms", answer.ms},
               {"forces", pairs_of(answer.forces)},
               {"holds", pairs_of(answer.holds)},
               {"refused", answer.refused},
               {"failed", answer.failed.empty() ? json() : json(answer.failed)},
               {"within", false}};
  if (id) meta["id"] = *id;
  return message_of(session.state(), session, std::move(meta), metres_per_unit);
}

std::string message_within(const LiveSession& session, double metres_per_unit) {
  const std::optional<SimulationState> state = session.state_within();
  if (!state) return {};
  const json none = json::array();
  json meta = {{"substeps", 0},   {"ms", 0},      {"forces", none}, {"holds", none},
               {"refused", none}, {"failed", {}}, {"within", true}};
  return message_of(*state, session, std::move(meta), metres_per_unit);
}

std::string error_message(std::optional<int> id, const std::string& text) {
  json out = {{"error", text}};
  if (id) out["id"] = *id;
  return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace pliant
