#include "fitting/distribution/object_corpus.h"

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

const std::vector<ObjectFamily>& all_families() {
  static const std::vector<ObjectFamily> all = [] {
    std::vector<ObjectFamily> out;
    for (const auto& group : {plant_families(), vessel_families(), soft_families(), made_families(), mixed_families()})
      out.insert(out.end(), group.begin(), group.end());
    return out;
  }();
  return all;
}

}  // namespace

std::vector<std::string> corpus_families(FamilyRole role) {
  std::vector<std::string> names;
  for (const ObjectFamily& family : all_families())
    if (family.role == role) names.push_back(family.name);
  return names;
}

MaterialObject make_object(const std::string& family, uint64_t seed) {
  std::vector<std::string> names;
  for (const ObjectFamily& f : all_families()) {
    names.push_back(f.name);
    if (f.name != family) continue;
    ObjectBuilder builder(family, seed);
    f.make(builder);
    return builder.build();
  }
  throw usage_error("object corpus", "family", "'" + family + "' is none",
                    "did you mean " + nearest_name(family, names) + "?");
}

}  // namespace pliant
