// Damaged messages of clients: whatever comes, `pliant view` reads it or refuses it.  Build it with PLIANT_SANITIZE.
// Prints JSON: how many messages of each kind were read and refused; exit code 1 where anything else happened.
// Usage: messages_study [COUNT [SEED]]   (1000000 of either kind)

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/choose/choose_request.h"
#include "app/live/live_messages.h"
#include "gaussians/base/error.h"
#include "tests/app/live/damaged_text.h"

namespace pliant {
namespace {

using nlohmann::json;

const std::vector<std::string> kLive = {
    R"({"id":1,"commands":[["begin",3,{"type":"grab","region":{"sphere":[0,0,0.1,0.02]},"max_force":4}],)"
    R"(["drag",3,0.1,0.2,-0.3],["set",2.5,0.5,0,0,-9.81],["end",3]],"frames":2})",
    R"({"id":7,"start":{"drivers":800,"clustered_to":200,"frame":3},"run":true,"describe":false})",
    R"({"commands":[["begin",1,{"type":"wind","region":{"box":[-1,-1,-1,1,1,1]},"velocity":[3,0,0]}],)"
    R"(["begin",2,{"type":"pin","region":{"plane":[0,0,0.1,0,0,1]}}],["move",2,0,1,2]],"frames":600})",
};
const std::vector<std::string> kChoose = {
    R"({"select":{"clicks":["0,10,20"],"strokes":["bg,1,2,3,4,5"],"boxes":["0,1,2,3,4"],"camera":5,"grow":-3}})",
    R"({"hover":[3,10.5,20]})",
    R"({"make":{"object":70000,"label":"potted plant"}})",
    R"({"name":{"object":2,"name":"vase"}})",
};

/// `read` takes a text or throws Error; damage adds up over a few texts.
json try_out(int count, uint64_t seed, const std::vector<std::string>& good,
             const std::function<void(const std::string&)>& read, bool& sound) {
  constexpr double kAgain = 0.3;  // share of texts that are damaged once more
  Random random(seed);
  long taken = 0, refused = 0;
  std::string text;
  for (int k = 0; k < count; ++k) {
    if (text.empty() || random.uniform() > kAgain) text = good[static_cast<size_t>(k) % good.size()];
    text = damaged(text, random);
    try {
      read(text);
      ++taken;
    } catch (const Error&) {
      ++refused;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", error.what(), text.c_str());
      sound = false;
    }
  }
  return {{"read", taken}, {"refused", refused}};
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  const int count = argc > 1 ? std::atoi(argv[1]) : 1'000'000;
  const uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (argc > 3 || count <= 0) return std::fprintf(stderr, "usage: messages_study [COUNT [SEED]]\n"), 2;
  const InteractionFrame frame{0.5, {0, 0, 1}};
  bool sound = true;
  const json out = {
      {"live", try_out(
                   count, seed, kLive, [&](const auto& text) { parse_request(text, frame, 800); }, sound)},
      {"choose", try_out(
                     count, seed, kChoose, [](const auto& text) { parse_choose_request(text); }, sound)}};
  std::printf("%s\n", out.dump().c_str());
  return sound ? 0 : 1;
}
