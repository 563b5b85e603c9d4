#include "fitting/observe/object_flow.h"

#include <cmath>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr double kTexturedFlow = 8.0 / 255;  // contrast from which flow is taken to be right

}  // namespace

ObjectFlow object_flow(const ImageF& flow, const ImageF& contrast, const ImageU8& object, const ImageU8& surroundings) {
  CHECK(flow.channels == 2 && flow.pixels() == contrast.pixels() && flow.pixels() == object.pixels() &&
        flow.pixels() == surroundings.pixels());
  std::vector<float> still, still_u, still_v, moved;
  for (int y = 0; y < flow.height; ++y)
    for (int x = 0; x < flow.width; ++x)
      if (surroundings(x, y) == 0 && contrast(x, y) > kTexturedFlow) {
        still.push_back(std::hypot(flow(x, y, 0), flow(x, y, 1)));
        still_u.push_back(flow(x, y, 0));
        still_v.push_back(flow(x, y, 1));
      }
  const float u = quantile(still_u, 0.5), v = quantile(still_v, 0.5);
  for (size_t i = 0; i < still.size(); ++i) still_u[i] = std::hypot(still_u[i] - u, still_v[i] - v);
  for (int y = 0; y < flow.height; ++y)
    for (int x = 0; x < flow.width; ++x)
      if (object(x, y) != 0 && contrast(x, y) > kTexturedFlow)
        moved.push_back(std::hypot(flow(x, y, 0) - u, flow(x, y, 1) - v));
  return {quantile(moved, 0.95), quantile(still, 0.5), quantile(still_u, 0.5), still.size()};
}

}  // namespace pliant
