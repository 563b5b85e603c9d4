#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pliant {

/// The value that a `share` in [0, 1] of the values lie below: the one at place floor(share n) in ascending order, or
/// the largest; share 0.5 is the median, the upper one of an even number. 0 where there are no values.
template <class T>
T quantile(std::vector<T> values, double share) {
  if (values.empty()) return T{};
  const auto place = std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace pliant
