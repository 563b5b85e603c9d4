#include "fitting/observe/frame_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace pliant {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The runs of digits of a name, and the name with one '0' for each.
struct Name {
  std::vector<std::string> numbers;
  std::string rest;
};

Name parts_of_name(const std::string& name) {
  Name out;
  for (size_t i = 0; i < name.size(); ++i) {
    out.rest += is_digit(name[i]) ? '0' : name[i];
    if (!is_digit(name[i])) continue;
    size_t end = i;
    while (end < name.size() && is_digit(name[end])) ++end;
    out.numbers.push_back(name.substr(i, end - i));
    i = end - 1;
  }
  return out;
}

/// The number in which alike names differ; empty when that is none, or several.
std::vector<long long> differing_numbers(const std::vector<std::filesystem::path>& pictures) {
  constexpr size_t kMostDigits = 18;
  std::vector<Name> names;
  for (const auto& picture : pictures) names.push_back(parts_of_name(picture.filename().string()));
  std::optional<size_t> differing;
  for (const Name& name : names) {
    if (name.rest != names[0].rest) return {};
    for (size_t k = 0; k < name.numbers.size(); ++k) {
      if (name.numbers[k] == names[0].numbers[k]) continue;
      if (differing.value_or(k) != k) return {};
      differing = k;
    }
  }
  if (!differing) return {};
  std::vector<long long> numbers;
  for (const Name& name : names) {
    const std::string& digits = name.numbers[*differing];
    if (digits.size() > kMostDigits) return {};
    numbers.push_back(std::stoll(digits));
    if (numbers.size() > 1 && numbers.back() <= numbers[numbers.size() - 2]) return {};
  }
  return numbers;
}

std::string missing_text(const std::vector<long long>& numbers, long long step) {
  constexpr int kNamed = 3;
  std::string text;
  int gaps = 0;
  for (size_t i = 1; i < numbers.size(); ++i) {
    const long long first = numbers[i - 1] + step, last = numbers[i] - step;
    if (first > last || ++gaps > kNamed) continue;
    text += (text.empty() ? "" : ", ") + (first == last ? std::to_string(first) : fmt::format("{} to {}", first, last));
  }
  return gaps > kNamed ? text + fmt::format(" and {} more gaps", gaps - kNamed) : text;
}

}  // namespace

FrameNumbers frame_numbers(const std::vector<std::filesystem::path>& pictures) {
  FrameNumbers out;
  for (size_t i = 0; i < pictures.size(); ++i) out.frame.push_back(static_cast<long long>(i));
  const std::vector<long long> numbers = differing_numbers(pictures);
  if (numbers.size() < 2) return out;
  long long step = numbers[1] - numbers[0];
  for (size_t i = 1; i < numbers.size(); ++i) step = std::min(step, numbers[i] - numbers[i - 1]);
  const auto count = static_cast<long long>(numbers.size()), span = (numbers.back() - numbers[0]) / step + 1;
  if (span == count && (numbers.back() - numbers[0]) % step == 0) return out;
  const bool even =
      std::all_of(numbers.begin(), numbers.end(), [&](long long n) { return (n - numbers[0]) % step == 0; });
  if (!even) {
    out.doubt = "has pictures whose numbers are no multiples of one step: they are taken as consecutive frames";
  } else if (span > 2 * count) {
    out.doubt = fmt::format("has no pictures numbered {}, more than it has: they are taken as consecutive frames",
                            missing_text(numbers, step));
  } else {
    out.missing = missing_text(numbers, step);
    out.doubt =
        fmt::format("has no pictures numbered {}: the instants of the others follow their numbers", out.missing);
    for (size_t i = 0; i < numbers.size(); ++i) out.frame[i] = (numbers[i] - numbers[0]) / step;
  }
  return out;
}

}  // namespace pliant
