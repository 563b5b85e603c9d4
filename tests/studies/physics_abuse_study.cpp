// physics_abuse_study [minutes] [seed]: random bodies under random interactions, one in twenty of which misses.  Every
// frame has to be finite or the run has to end in a typed error; memory must not grow.  Prints one line of JSON; exit
// code 1 when something else happened.

#include <sys/resource.h>

#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

double resident_megabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::atof(line.c_str() + 6) / 1024;
  return 0;
}

double power(Random& random, double low, double high) { return std::pow(10.0, random.uniform(low, high)); }
Vec3d direction(Random& random) { return Vec3d(random.normal(), random.normal(), random.normal()).normalized(); }

/// An interaction that touches a particle of the body, or, if `misses`, none.
Interaction random_interaction(const Particles& body, Random& random, bool misses) {
  Interaction it;
  it.type = static_cast<InteractionType>(random.below(interaction_names().size()));
  it.start = random.uniform(0, 0.2);
  it.duration = random.uniform(0, 0.3);
  Vec3d at = body.position[random.below(body.size())].cast<double>();
  if (misses) at += Vec3d(0.5, 0.5, 0.5);
  const Vec3d half = 0.5 * power(random, -2.5, -1) * direction(random), n = direction(random);
  switch (random.below(misses ? 3 : 4)) {
    case 0:
      it.region = Region::sphere(at, power(random, -2.5, -1));
      break;
    case 1:
      it.region = Region::box(at - half.cwiseAbs(), at + half.cwiseAbs());
      break;
    case 2:
      it.region = Region::cylinder(at - half, at + half, power(random, -2.5, -1));
      break;
    default:
      it.region = Region::half_space(at + 1e-4 * n, n);
  }
  it.vector = power(random, -3, random.below(8) == 0 ? 9 : 1.5) * direction(random);
  it.contact = static_cast<ContactKind>(random.below(3));
  it.container = random.below(4) == 0;
  it.friction = random.below(6) == 0 ? INFINITY : random.uniform(0, 1.5);
  it.angular_velocity = random.below(2) ? Vec3d(Vec3d::Zero()) : Vec3d(power(random, -1, 2) * direction(random));
  it.rate = random.below(2) ? 0 : power(random, -1, 3);
  const bool follows = it.type == InteractionType::kGrab || it.type == InteractionType::kPoke;
  if (it.type == InteractionType::kGround) it.region = Region::half_space(at, direction(random));
  if (it.type == InteractionType::kPoke) it.region = Region::sphere(at, power(random, -2.5, -1.3));
  if (follows || (it.type == InteractionType::kCollider && random.below(3) == 0))
    for (int k = 0; k < 3; ++k) it.path.push_back({0.1 * k, at + power(random, -2, 0) * direction(random)});
  return it;
}

Particles random_body(Random& random) {
  const Vec3d size(0.01 * (1 + random.below(5)), 0.01 * (1 + random.below(5)), 0.01 * (1 + random.below(7)));
  Particles p =
      fixture::block<float>(size, 0.01, 1.0, power(random, 2.5, 6), random.uniform(0, 0.49), power(random, 2, 4));
  Material material;
  material.law = static_cast<Law>(random.below(law_names().size()));
  material.yield_stress = power(random, 1, 4);
  material.branch_shear = material.branch_lambda = power(random, 2, 5);
  material.branch_viscosity = power(random, 0, 3);
  material.plastic_viscosity = power(random, 0, 2);
  p.materials = {material};
  if (random.below(3) == 0)
    for (const Vec3f& x : p.position) p.object.push_back(x.z() > 0.5f * static_cast<float>(size.z()));
  return p;
}

/// A message without its numbers.
std::string anonymous(const std::string& message) {
  std::string result;
  for (const char c : message)
    if (!std::isdigit(static_cast<unsigned char>(c)))
      result += c;
    else if (result.empty() || result.back() != '#')
      result += '#';
  return result;
}

int run(double minutes, uint64_t seed) {
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  constexpr double kLongest = 20;  // s, of one run
  int runs = 0, finished = 0, cut = 0, numerical = 0, usage = 0, bad = 0;
  int64_t frames = 0;
  double early = 0, late = 0;
  std::map<std::string, int> messages;
  for (; seconds() < 60 * minutes; ++runs) {
    Random random(seed, runs);
    const Particles particles = random_body(random);
    std::vector<Interaction> script;
    for (uint64_t k = random.below(4) + 1; k > 0; --k)
      script.push_back(random_interaction(particles, random, random.below(20) == 0));
    SimulateOptions options;
    options.duration = 0.3;
    options.fps = 30;
    options.max_retries = 2;
    options.gravity = random.below(8) == 0 ? Vec3d(0, 0, -1e4) : Vec3d(0, 0, -9.81);
    if (random.below(6) == 0) options.settle_time = 0.3;
    if (random.below(6) == 0) options.flip_time = power(random, -4, 0);
    if (random.below(6) == 0) options.sleep_speed = power(random, -3, -1);
    if (random.below(6) == 0) options.viscosity_time = power(random, -6, -3);
    if (random.below(10) == 0) options.rest_shape = RestShapeMode::kSolve;
    const double start = seconds();
    try {
      const bool stopped =
          simulate<float>(options, particles, script, initial_state(particles), [&](const SimulationState& s) {
            bool good = true;
            for (size_t i = 0; i < s.size(); ++i)
              good &= s.x[i].allFinite() && s.v[i].allFinite() && s.F[i].allFinite();
            if (!good) {
              ++bad;
              std::fprintf(stderr, "run %d frame %d is not finite\n", runs, s.frame);
            }
            return ++frames, good && seconds() - start < kLongest;
          }).stopped;
      (stopped ? cut : finished) += 1;
    } catch (const Error& error) {
      (error.failure == Failure::kNumerical ? numerical : usage) += 1;
      ++messages[anonymous(error.what())];
    } catch (const std::exception& error) {
      ++bad;
      std::fprintf(stderr, "run %d: %s\n", runs, error.what());
    }
    if (runs == 200) early = resident_megabytes();
    late = resident_megabytes();
  }
  for (const auto& [message, count] : messages) std::fprintf(stderr, "%6d  %s\n", count, message.c_str());
  const bool grew = early > 0 && late > 1.2 * early + 20;
  std::printf(
      "{\"runs\": %d, \"frames\": %lld, \"finished\": %d, \"cut_short\": %d, \"numerical_errors\": %d, "
      "\"usage_errors\": %d, "
      "\"not_finite_or_untyped\": %d, \"resident_mb_after_200\": %.1f, \"resident_mb_at_end\": %.1f}\n",
      runs, static_cast<long long>(frames), finished, cut, numerical, usage, bad, early, late);
  return bad > 0 || grew;
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  const double minutes = argc > 1 ? std::atof(argv[1]) : 10;
  return pliant::run(minutes, argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
}
