#include "fitting/fields/triplane_field.h"

#include "fitting/fields/torch_advice.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/module.h"

namespace pliant {
namespace {

void validate(const TriplaneOptions& o, size_t points) {
  const auto require = [](bool good, const char* field, const char* problem, const char* remedy) {
    if (!good) throw usage_error("triplane field", field, problem, remedy);
  };
  require(points > 0, "points", "there are none", "give at least one point");
  require(o.channels > 0 && o.features > 0 && o.hidden > 0, "features", "a size is not positive", "use at least 1");
  require(o.resolution > 1, "resolution", "a plane needs more than one feature along a side", "use at least 2");
  require(o.layers > 0, "layers", "there is none", "use at least 1");
  require(o.threads > 0, "threads", "there is none", "use at least 1");
  require(o.low.size() == o.high.size() && (o.low.empty() || o.low.size() == static_cast<size_t>(o.channels)), "bounds",
          "not one pair per channel", "give one low and one high bound per channel, or none");
  for (size_t c = 0; c < o.low.size(); ++c)
    require(o.low[c] < o.high[c], "bounds", "low is not below high", "swap them");
}

using TriplaneFactory = TriplaneField* (*)(const TriplaneOptions&, std::span<const Vec3f>);

TriplaneFactory triplane_factory() {
  static const auto factory = reinterpret_cast<TriplaneFactory>(
      module_function("pliant_triplanes.so", "pliant_make_triplane_field", kTorchAdvice + "fit by parts"));
  return factory;
}

}  // namespace

#ifdef PLIANT_TORCH
bool has_triplane_fields() { return true; }
#else
bool has_triplane_fields() { return false; }
#endif

void require_triplane_fields() { triplane_factory(); }

std::unique_ptr<TriplaneField> make_triplane_field(const TriplaneOptions& options, std::span<const Vec3f> points) {
  validate(options, points.size());
  return std::unique_ptr<TriplaneField>(triplane_factory()(options, points));
}

}  // namespace pliant
