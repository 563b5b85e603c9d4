#include "fitting/fields/hexplane_field.h"

#include <algorithm>

#include "fitting/fields/torch_advice.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/module.h"

namespace pliant {
namespace {

void validate(const HexplaneOptions& o, size_t points, std::span<const double> times) {
  const auto require = [](bool good, const char* field, const char* problem, const char* remedy) {
    if (!good) throw usage_error("hexplane field", field, problem, remedy);
  };
  require(points > 0, "points", "there are none", "give at least one point");
  require(!times.empty(), "times", "there are none", "give at least one time");
  require(std::all_of(times.begin(), times.end(), [](double t) { return t >= 0 && t <= 1; }), "times",
          "one is not in [0, 1]", "divide them by the last one");
  require(o.channels > 0, "channels", "there is none", "use at least 1");
  require(o.features > 0, "features", "there is none", "use at least 1");
  require(o.hidden > 0, "hidden", "there is none", "use at least 1");
  require(o.layers > 0, "layers", "there is none", "use at least 1");
  require(o.space_resolution > 1, "space_resolution", "a plane needs more than one feature along a side",
          "use at least 2");
  require(o.time_resolution > 2, "time_resolution", "a second difference needs three features", "use at least 3");
  require(o.threads > 0, "threads", "there is none", "use at least 1");
}

}  // namespace

std::unique_ptr<HexplaneField> make_hexplane_field(const HexplaneOptions& options, std::span<const Vec3f> points,
                                                   std::span<const double> times) {
  validate(options, points.size(), times);
  using Factory = HexplaneField* (*)(const HexplaneOptions&, std::span<const Vec3f>, std::span<const double>);
  static const auto factory = reinterpret_cast<Factory>(
      module_function("pliant_triplanes.so", "pliant_make_hexplane_field", kTorchAdvice + "fit a material by parts"));
  return std::unique_ptr<HexplaneField>(factory(options, points, times));
}

}  // namespace pliant
