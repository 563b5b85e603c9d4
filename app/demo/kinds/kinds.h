#pragma once

#include <string>
#include <vector>

#include "app/demo/kinds/object.h"

namespace pliant {

/// A kind of object that `demo` makes.
struct DemoKind {
  std::string name;
  std::string shows;  ///< one line for help and README
  DemoObject (*make)(uint64_t seed);
};

constexpr const char* kPottedFlower = "potted-flower";

/// All kinds; the potted flower is the first.
const std::vector<DemoKind>& demo_kinds();
std::vector<std::string> demo_kind_names();
/// Throws Error{kUsage} with all names for an unknown one.
const DemoKind& demo_kind(const std::string& name);

DemoObject make_carnation(uint64_t seed);
DemoObject make_rose(uint64_t seed);
DemoObject make_tulip(uint64_t seed);
DemoObject make_alocasia(uint64_t seed);
DemoObject make_hat(uint64_t seed);
DemoObject make_cord(uint64_t seed);
DemoObject make_jelly(uint64_t seed);
DemoObject make_cloth(uint64_t seed);
DemoObject make_composite(uint64_t seed);

}  // namespace pliant
