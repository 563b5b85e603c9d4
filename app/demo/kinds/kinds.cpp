#include "app/demo/kinds/kinds.h"

#include "app/demo/kinds/flower.h"
#include "gaussians/base/error.h"

namespace pliant {

const std::vector<DemoKind>& demo_kinds() {
  static const std::vector<DemoKind> kinds = {
      {kPottedFlower, "a potted flower with thick stem, leaves and petals",
       [](uint64_t seed) { return make_flower(seed).object; }},
      {"carnation", "a potted carnation: ruffled petals, narrow leaves", make_carnation},
      {"rose", "a potted rose: cupped petals in rings, broad leaves", make_rose},
      {"tulip", "a potted tulip: six petals that close to an egg, two long leaves", make_tulip},
      {"alocasia", "arrow-shaped leaves with light veins on stalks in a pot", make_alocasia},
      {"hat", "a hat on its stand, with a brim of knitted shells", make_hat},
      {"cord", "the coiled cord of a telephone, held at both ends", make_cord},
      {"jelly", "a fluted jelly with a cherry on a plate", make_jelly},
      {"cloth", "a folded plaid that hangs from a rail", make_cloth},
      {"composite", "foam columns that carry a stiff board and a stiff head", make_composite},
  };
  return kinds;
}

std::vector<std::string> demo_kind_names() {
  std::vector<std::string> names;
  for (const DemoKind& kind : demo_kinds()) names.push_back(kind.name);
  return names;
}

const DemoKind& demo_kind(const std::string& name) {
  std::string list;
  for (const DemoKind& kind : demo_kinds()) {
    if (kind.name == name) return kind;
    list += (list.empty() ? "" : ", ") + kind.name;
  }
  throw usage_error("demo", "--kind", "'" + name + "' is unknown", "give one of " + list);
}

}  // namespace pliant
