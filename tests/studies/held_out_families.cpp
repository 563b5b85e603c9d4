#include "tests/studies/held_out_families.h"

#include "gaussians/base/error.h"
#include "tests/studies/held_out_parasol.h"
#include "tests/studies/held_out_sunflower.h"

namespace pliant::study {

const std::vector<std::string>& held_out_families() {
  static const std::vector<std::string> families{"sunflower", "parasol"};
  return families;
}

MaterialObject make_held_out(const std::string& family, uint64_t seed) {
  CHECK_MSG(family == "sunflower" || family == "parasol", "no held-out family: " + family);
  return family == "sunflower" ? make_sunflower(seed) : make_parasol(seed);
}

}  // namespace pliant::study
