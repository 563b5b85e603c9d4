#include "app/live/live_command.h"

#include <fmt/format.h>

#include <cmath>

#include "app/page/interaction_numbers.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr double kMostNumber = 1e6;                 // of interactions
constexpr double kFarthest = 1e9;                   // of any length, force or acceleration
constexpr double kSoftest = 1e-6, kStiffest = 1e6;  // factor of Young's modulus
constexpr size_t kMostPath = 10'000;

double number_at(const json& value, size_t at, double low, double high, const std::string& where) {
  const json& n = value[at];
  if (!n.is_number() || !(n.get<double>() >= low && n.get<double>() <= high))
    throw usage_error(where, fmt::format("[{}]", at), "is " + n.dump().substr(0, 40),
                      fmt::format("give a number from {:g} to {:g}", low, high));
  return n;
}

Vec3d vector_from(const json& value, size_t at, const std::string& where) {
  Vec3d out;
  for (size_t a = 0; a < 3; ++a) out[static_cast<int>(a)] = number_at(value, at + a, -kFarthest, kFarthest, where);
  return out;
}

void expect_size(const json& value, size_t size, const std::string& where) {
  if (value.size() != size)
    throw usage_error(where, "", fmt::format("has {} entries", value.size()), fmt::format("give {}", size));
}

Interaction from_numbers(const json& numbers, const std::string& where) {
  expect_size(numbers, kInteractionNumbers, where);
  std::vector<double> n;
  for (size_t k = 0; k < numbers.size(); ++k) n.push_back(number_at(numbers, k, -kFarthest, kFarthest, where));
  // Enumerations are whole numbers within their ends.
  constexpr size_t kType = 0, kKind = 2, kContact = 20;
  const auto whole = [&](size_t at, int most) {
    if (!(n[at] >= 0 && n[at] <= most && n[at] == std::floor(n[at])))
      throw usage_error(where, fmt::format("[{}]", at), fmt::format("is {:g}", n[at]),
                        fmt::format("give a whole number from 0 to {}", most));
  };
  whole(kType, static_cast<int>(InteractionType::kWeight));
  whole(kKind, static_cast<int>(Region::Kind::kCylinder));
  whole(kContact, static_cast<int>(ContactKind::kSeparating));
  return interaction_of(n);
}

Interaction from_row(json row, const InteractionFrame& frame, const std::string& where) {
  const bool takes_hold = row.value("type", json()) == "grab" && !row.contains("path");
  if (takes_hold) row["path"] = {{0, 0, 0, 0}};
  if (row.contains("path") && row["path"].is_array() && row["path"].size() > kMostPath)
    throw usage_error(where, "path", fmt::format("has {} points", row["path"].size()),
                      fmt::format("give at most {}", kMostPath));
  Interaction out = parse_interactions(json::array({row}).dump(), frame, where).front();
  if (takes_hold) out.path.clear();
  return out;
}

}  // namespace

LiveCommand parse_command(const json& value, const InteractionFrame& frame, const std::string& where) {
  const std::string name = value.is_array() && !value.empty() && value[0].is_string() ? value[0] : "";
  const auto number = [&] {
    const double n = number_at(value, 1, 0, kMostNumber, where);
    if (n != std::floor(n)) throw usage_error(where, "[1]", fmt::format("is {:g}", n), "give a whole number");
    return static_cast<int>(n);
  };
  LiveCommand out;
  out.text = value;
  if (name == "begin") {
    expect_size(value, 3, where);
    out.kind = LiveCommand::Kind::kBegin;
    out.number = number();
    if (value[2].is_array())
      out.interaction = from_numbers(value[2], where);
    else if (value[2].is_object())
      out.interaction = from_row(value[2], frame, where);
    else
      throw usage_error(where, "[2]", "is " + value[2].dump().substr(0, 40),
                        "give a row of interactions.json, or its numbers");
    Interaction whole = out.interaction;
    if (whole.type == InteractionType::kGrab && whole.path.empty()) whole.path = {{0, Vec3d::Zero()}};
    validate_interaction(whole, 0);
  } else if (name == "move" || name == "drag") {
    expect_size(value, 5, where);
    out.kind = name == "move" ? LiveCommand::Kind::kMove : LiveCommand::Kind::kDrag;
    out.number = number();
    out.place = vector_from(value, 2, where);
  } else if (name == "end") {
    expect_size(value, 2, where);
    out.kind = LiveCommand::Kind::kEnd;
    out.number = number();
  } else if (name == "set") {
    expect_size(value, 6, where);
    out.settings.young_scale = number_at(value, 1, kSoftest, kStiffest, where);
    out.settings.damping_time = number_at(value, 2, 0, kFarthest, where);
    out.settings.gravity = vector_from(value, 3, where);
  } else {
    throw usage_error(where, "", "is " + value.dump().substr(0, 40), "give begin, move, drag, end or set");
  }
  return out;
}

}  // namespace pliant
