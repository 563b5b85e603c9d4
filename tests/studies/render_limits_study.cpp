// Memory and time of the rasteriser where it is strained: two million Gaussians at 1080p, and absurd scenes, each in a
// process of its own so that peak memory is its own.
//
//   render_limits_study OUT

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "gaussians/io/files/json_file.h"
#include "gaussians/render/render.h"
#include "tests/benchmarks/random_cloud.h"

namespace pliant {
namespace {

double resident_mb() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024.0;
}

struct Figures {
  double seconds, adjoint_seconds, cloud_mb, forward_mb, adjoint_mb;  // peaks above what the cloud takes
  bool finite;
};

Figures measure(const std::function<GaussianCloud()>& make, int width, int height) {
  const GaussianCloud cloud = make();
  const Camera camera = look_at({0, -4, 0}, {0, 0, 0}, {0, 0, 1}, width, height, 1.1 * width);
  Figures f{};
  f.cloud_mb = resident_mb();
  const auto now = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  const double start = now();
  RenderTape<float> tape;
  const RenderResult picture = render(cloud, camera, {}, {}, 0, &tape);
  f.seconds = now() - start;
  f.forward_mb = resident_mb() - f.cloud_mb;
  RenderResult adj;
  adj.color = ImageF(width, height, 3, 0.1f);
  const double before = now();
  const RenderGradient<float> g = render_adjoint(cloud, camera, {}, {}, 0, picture, adj, &tape);
  f.adjoint_seconds = now() - before;
  f.adjoint_mb = resident_mb() - f.cloud_mb;
  f.finite = true;
  for (const float value : picture.color.data) f.finite &= std::isfinite(value);
  for (const auto& x : g.cloud.position) f.finite &= x.allFinite();
  for (const auto& x : g.cloud.log_scale) f.finite &= x.allFinite();
  return f;
}

Figures in_own_process(const std::function<GaussianCloud()>& make, int width, int height) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    const Figures f = measure(make, width, height);
    _exit(write(ends[1], &f, sizeof f) == sizeof f ? 0 : 1);
  }
  close(ends[1]);
  Figures f{};
  const bool whole = read(ends[0], &f, sizeof f) == sizeof f;
  int status = 0;
  waitpid(child, &status, 0);
  close(ends[0]);
  if (!whole || status != 0) {
    std::printf("  process ended with status %d\n", status);
    f = {};
  }
  return f;
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  if (argc != 2) return std::fprintf(stderr, "usage: render_limits_study OUT\n"), 2;
  struct Case {
    const char* name;
    int width, height;
    std::function<GaussianCloud()> make;
  };
  const auto poisoned = [] {
    GaussianCloud cloud = random_cloud({});
    const float nan = NAN, infinite = INFINITY;
    for (size_t i = 0; i < cloud.size(); i += 3) {
      const int kind = static_cast<int>(i / 3 % 6);
      if (kind == 0) cloud.position[i][1] = nan;
      if (kind == 1) cloud.log_scale[i][0] = 69.0f;  // e^69 = 1e30
      if (kind == 2) cloud.rotation[i].setConstant(nan);
      if (kind == 3) cloud.opacity_logit[i] = infinite;
      if (kind == 4) cloud.sh_of(i)[2] = -infinite;
      if (kind == 5) cloud.position[i] *= 1e30f;
    }
    return cloud;
  };
  const Case cases[] = {
      {"two million at 1080p", 1920, 1080,
       [] {
         return random_cloud({2'000'000, 0.001, 0.005});
       }},
      {"100k that cover everything", 800, 800,
       [] {
         return random_cloud({100'000, 40, 50});
       }},
      {"100k faint ones that cover everything", 800, 800,
       [] {
         return random_cloud({100'000, 40, 50, 2.6, 0.004, 0.00401});
       }},
      {"100k at one point", 800, 800,
       [] {
         return random_cloud({100'000, 0.02, 0.05, 0});
       }},
      {"scales of 1e30, NaN, infinity", 800, 800, poisoned},
  };
  nlohmann::json out = nlohmann::json::array();
  for (const Case& c : cases) {
    const Figures f = in_own_process(c.make, c.width, c.height);
    std::printf("%-40s forward %7.2f s, +%5.0f MB; with derivatives %7.2f s, +%5.0f MB; %s\n", c.name, f.seconds,
                f.forward_mb, f.seconds + f.adjoint_seconds, f.adjoint_mb, f.finite ? "finite" : "NOT FINITE");
    std::fflush(stdout);
    out.push_back({{"case", c.name},
                   {"forward_s", f.seconds},
                   {"adjoint_s", f.adjoint_seconds},
                   {"cloud_mb", f.cloud_mb},
                   {"forward_mb", f.forward_mb},
                   {"adjoint_mb", f.adjoint_mb},
                   {"finite", f.finite}});
  }
  write_json(argv[1], out);
}
