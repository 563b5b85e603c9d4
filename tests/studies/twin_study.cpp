// Twin experiments through the command line: twin_study PLIANT OUT [KEY=VALUE...]
//   kind=uniform|parts|smooth|velocity   what is unknown beside damping and v0 (uniform: E over 1.5 decades)
//   field=uniform|parts|smooth|triplanes how it is fitted (default: kind)
//   grid=same|other                      the reference has other particles on the same grid, or a finer grid
//   cases=10 first=1 noise=2 (of 255) particles=2000 frames=24
//   codec=h264|none                      the reference is rendered into a video of 0.4 Mbit/s at 400 x 300, or into
//   frames
// A bar is simulated and rendered by PLIANT, noise is added to every other frame, and a fit reads nothing else.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/store/particles.h"
#include "fitting/fields/smooth_field.h"
#include "fitting/observe/frame_source.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "tests/energy_decay.h"
#include "tests/studies/twin_scene.h"

using namespace pliant;
using namespace pliant::study;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::map<std::string, std::string> keys = {{"kind", "uniform"}, {"field", ""},  {"grid", "same"},      {"cases", "10"},
                                           {"first", "1"},      {"noise", "2"}, {"particles", "2000"}, {"frames", "24"},
                                           {"codec", "h264"},   {"fit", ""}};
std::string pliant_program;
constexpr double kFps = 24;

double number(const std::string& key) { return std::atof(keys.at(key).c_str()); }

bool call(const std::string& arguments, const fs::path& log) {
  const std::string line = pliant_program + " " + arguments + " > " + log.string() + " 2>&1";
  if (std::system(line.c_str()) == 0) return true;
  std::fprintf(stderr, "failed: %s\n", line.c_str());
  return false;
}

/// Cut out and seeded, once for every number of particles and seed.
fs::path seeded(const fs::path& out, int particles, int seed) {
  const fs::path run = out / fmt::format("seed_{}_{}", particles, seed);
  if (fs::exists(run / "done")) return run;
  fs::remove_all(run);
  const std::string where = run.string(), log = (out / "seed.log").string();
  const bool good =
      call(fmt::format("segment {} --out {} --aabb -0.01,-0.01,-0.01,0.06,0.06,0.23", (out / "scene").string(), where),
           log) &&
      call("extract " + where + " --object 1", log) && call("repair " + where, log) &&
      call(fmt::format("seed {} --particles {} --seed {}", where, particles, seed), log);
  if (!good) std::exit(1);
  write_text(run / "done", "");
  return run;
}

fs::path object_of(const fs::path& run) {
  for (const auto& entry : fs::directory_iterator(run / "objects")) return entry.path();
  return {};
}

/// Every `every`-th frame of a clip, the first one too, with Gaussian noise of standard deviation `sigma` of 255, as
/// PNG files; `clip` is a folder of frames or a video.
int noisy_frames(const fs::path& clip, const fs::path& folder, double sigma, uint64_t seed, int every) {
  fs::create_directories(folder);
  const std::unique_ptr<FrameSource> source = open_frames(clip, kFps);
  int count = 0;
  for (int read = 0; const std::optional<TimedFrame> frame = source->next(); ++read) {
    if (read % every) continue;
    ImageF image = frame->picture;
    for (size_t i = 0; i < image.data.size(); ++i) {
      Random random(seed, count * image.data.size() + i);
      image.data[i] = static_cast<float>(std::clamp(image.data[i] + sigma / 255 * random.normal(), 0.0, 1.0));
    }
    write_image(folder / fmt::format("{:04d}.png", count++), image);
  }
  return count;
}

/// ln of a factor of E at points, of a random field that is smooth over a third of the bar.
std::function<double(const Vec3f&)> smooth_truth(uint64_t seed) {
  SmoothFieldOptions options;
  options.sigma = 0.8;
  options.length = 0.06;
  options.modes = 12;
  const std::vector<Vec3f> points = bar_points();
  const auto field = std::make_shared<SmoothField>(options, points);
  std::vector<double> p(field->parameters());
  for (size_t i = 0; i < p.size(); ++i) p[i] = Random(seed, 77 + i).normal();
  const auto values = std::make_shared<std::vector<double>>(field->values(p));
  const auto tree = std::make_shared<std::vector<Vec3f>>(points);
  return [values, tree](const Vec3f& x) { return (*values)[k_nearest(*tree, std::vector<Vec3f>{x}, 1)[0]]; };
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s PLIANT OUT [KEY=VALUE...]\n", argv[0]), 2;
  pliant_program = argv[1];
  const fs::path out = argv[2];
  for (int i = 3; i < argc; ++i) {
    const std::string text = argv[i];
    const size_t at = text.find('=');
    if (at == std::string::npos || !keys.count(text.substr(0, at)))
      return std::fprintf(stderr, "no such key: %s\n", argv[i]), 2;
    keys[text.substr(0, at)] = text.substr(at + 1);
  }
  const std::string kind = keys["kind"],
                    field = keys["field"].empty() ? (kind == "velocity" ? "uniform" : kind) : keys["field"];
  if (keys["codec"] != "none" && keys["codec"] != "h264") return std::fprintf(stderr, "codec is none or h264\n"), 2;
  const bool same = keys["grid"] == "same";
  const int particles = static_cast<int>(number("particles")), frames = static_cast<int>(number("frames"));
  if (!fs::exists(out / "scene" / "scene.json")) write_bar_scene(out / "scene");
  const fs::path truth_seed = same ? seeded(out, particles, 2) : seeded(out, 3 * particles, 2),
                 fit_seed = seeded(out, particles, 1);

  json rows = json::array();
  for (int k = 0; k < static_cast<int>(number("cases")); ++k) {
    const uint64_t seed = static_cast<uint64_t>(number("first")) + k;
    Random random(seed, 1);
    // The bar's lowest frequency is about .2237 sqrt(E / 1 kPa) Hz: 1 to 6 periods in a second of 24 frames.
    const double log_low = std::log(2.2e4), log_high = std::log(7.0e5),
                 middle = kind == "uniform" ? random.uniform(log_low, log_high)
                                            : random.uniform(std::log(6e4), std::log(2e5));
    const double damping = random.uniform(0.5, 2.0), angle = random.uniform(-0.5, 0.5),
                 frequency = 0.2237 * std::sqrt(std::exp(middle) / 1000);
    const double speed = random.uniform(0.08, 0.14) * 0.19 * 2 * M_PI * frequency;
    const Vec3d tip = speed * Vec3d(angle < 0 ? -1 : 1, random.uniform(-0.4, 0.4), 0);
    const double wrong = kind == "uniform" ? (k % 2 ? 30.0 : 1 / 30.0) : 3.0;
    std::function<double(const Vec3f&)> factor = [](const Vec3f&) { return 0.0; };
    if (kind == "parts")
      factor = [](const Vec3f& x) {
        return x.z() > 0.5 * (kClamp + kHeight) ? -0.5 * std::log(10.0) : 0.5 * std::log(10.0);
      };
    if (kind == "smooth") factor = smooth_truth(seed);
    const auto young = [&](const Vec3f& x) { return std::exp(middle + factor(x)); };

    const std::string codec = keys["codec"] == "h264" ? "" : "_" + keys["codec"];
    const fs::path truth = out / fmt::format("truth_{}_{}_{}{}", kind, keys["grid"], seed, codec),
                   run = out / fmt::format("fit_{}_{}_{}_{}{}", kind, field, keys["grid"], seed, codec);
    fs::path frames_folder = truth / "frames";
    if (!fs::exists(frames_folder)) {
      fs::remove_all(truth);
      fs::copy(truth_seed, truth, fs::copy_options::recursive);
      write_bar_material(truth / "truth_material.h5", young);
      write_bar_velocity(truth / "truth_velocity.h5", tip, damping);
      // Twice the frame rate gives other time steps.
      if (!call(fmt::format("simulate {} --material {} --velocity {} --fps {} --duration {} --no-floor", truth.string(),
                            (truth / "truth_material.h5").string(), (truth / "truth_velocity.h5").string(), 2 * kFps,
                            (frames - 1) / kFps),
                truth / "log") ||
          !call(fmt::format("render {} --camera view_3 --no-orbit{}", truth.string(), codec.empty() ? "" : " --frames"),
                truth / "log"))
        return 1;
      const int count = noisy_frames(truth / (codec.empty() ? "clip.mp4" : "clip"), truth / "frames.partial",
                                     number("noise"), seed, 2);
      fs::rename(truth / "frames.partial", frames_folder);
      std::printf("case %d: E %.3g Pa, f1 %.2f Hz, damping %.2f s, %d frames\n", static_cast<int>(seed),
                  std::exp(middle), frequency, damping, count);
    }
    fs::remove_all(run);
    fs::copy(fit_seed, run, fs::copy_options::recursive);
    if (!call(
            fmt::format("fit {} --video {} --video-camera view_3 --video-fps {} --start 0 --field {} --young {} {} {}",
                        run.string(), frames_folder.string(), kFps, field, std::exp(middle) * wrong,
                        field == "parts" ? "--parts 2" : "", keys["fit"]),
            run / "log")) {
      rows.push_back({{"case", seed}, {"failed", true}});
      continue;
    }

    // Errors at the solid samples that may move.
    const ParticleFile solid = read_particles(object_of(run) / "particles.h5");
    const MaterialFile found = read_material(object_of(run) / "material.h5");
    const VelocityFile start = read_velocity(object_of(run) / "velocity.h5");
    const json result = read_json(run / "fit" / "results.json");
    std::vector<double> error;
    double bias = 0;
    for (size_t i = 0; i < found.young.size(); ++i) {
      if (solid.solid_position[i].z() < kClamp + 0.01) continue;
      const double e = std::log10(found.young[i] / young(solid.solid_position[i]));
      error.push_back(std::abs(e));
      bias += e;
    }
    bias /= static_cast<double>(error.size());
    // Where the fit says that it knows: error against the stated standard deviation.
    size_t known = 0, within = 0;
    std::vector<double> known_error;
    for (size_t i = 0; i < found.log10_young_sigma.size(); ++i) {
      if (solid.solid_position[i].z() < kClamp + 0.01 || found.log10_young_sigma[i] > 0.25) continue;
      known_error.push_back(std::abs(std::log10(found.young[i] / young(solid.solid_position[i]))));
      ++known;
      within += known_error.back() < found.log10_young_sigma[i];
    }
    std::sort(known_error.begin(), known_error.end());
    std::nth_element(error.begin(), error.begin() + error.size() / 2, error.end());
    const double median = error[error.size() / 2];
    // Of the best constant: the homogeneous fit.
    std::vector<double> constant_error;
    for (size_t i = 0; i < found.young.size(); ++i)
      if (solid.solid_position[i].z() >= kClamp + 0.01)
        constant_error.push_back(
            std::abs(std::log10(result["constant_young_pa"].get<double>() / young(solid.solid_position[i]))));
    std::nth_element(constant_error.begin(), constant_error.begin() + constant_error.size() / 2, constant_error.end());
    Vec3d seen = Vec3d::Zero(), wanted = Vec3d::Zero();
    for (size_t i = 0; i < start.velocity.size(); ++i) {
      if (start.position[i].z() < kClamp) continue;
      seen += start.velocity[i].cast<double>();
      wanted += bar_velocity(tip, start.position[i]);
    }
    // View 3 looks nearly along y: its picture shows x and z.
    const Vec3d depth = (Vec3d(0.025, 0.025, 0.12) - Vec3d(0.025 + 0.55 * std::cos(-0.125 - M_PI / 2),
                                                           0.025 + 0.55 * std::sin(-0.125 - M_PI / 2), 0.16))
                            .normalized();
    const Vec3d seen_flat = seen - depth * depth.dot(seen), wanted_flat = wanted - depth * depth.dot(wanted);
    const double direction =
        std::acos(std::clamp(seen_flat.normalized().dot(wanted_flat.normalized()), -1.0, 1.0)) * 180 / M_PI;
    rows.push_back({{"case", seed},
                    {"young", std::exp(middle)},
                    {"median", median},
                    {"bias", bias},
                    {"constant", constant_error[constant_error.size() / 2]},
                    {"damping", result.value("whole_damping_time_s", 0.0) / damping},
                    {"damping_truth", 1 / (damping * fixture::decay_rate(object_of(truth), young))},
                    {"damping_beside_transfers", result["damping_time_s"].get<double>() / damping},
                    {"direction_deg", direction},
                    {"magnitude", seen_flat.norm() / wanted_flat.norm()},
                    {"depth_found", depth.dot(seen) / wanted_flat.norm()},
                    {"depth_true", depth.dot(wanted) / wanted_flat.norm()},
                    {"rms_px", result["rms_px"]},
                    {"sigma", result["log10_sigma"]},
                    {"known_share", double(known) / error.size()},
                    {"known_median", known ? known_error[known / 2] : 0.0},
                    {"within_1_sigma", known ? double(within) / known : 0.0},
                    {"periods", frequency * (frames - 1) / kFps},
                    {"steps", result["steps"]}});
    const json& r = rows.back();
    std::printf(
        "case %d %s/%s/%s: median |dlog10 E| %.3f bias %+.3f constant %.3f; damping x %.2f (the truth itself x %.2f, "
        "what the fit needs beside its grid x %.2f); v0 %.1f deg, x %.2f, depth %.2f of %.2f; rms %.3f px, periods "
        "%.1f; known %.2f, median there %.3f, in 1 sigma %.2f\n",
        static_cast<int>(seed), kind.c_str(), field.c_str(), keys["grid"].c_str(), median, bias,
        r["constant"].get<double>(), r["damping"].get<double>(), r["damping_truth"].get<double>(),
        r["damping_beside_transfers"].get<double>(), direction, r["magnitude"].get<double>(),
        r["depth_found"].get<double>(), r["depth_true"].get<double>(), r["rms_px"].get<double>(),
        r["periods"].get<double>(), r["known_share"].get<double>(), r["known_median"].get<double>(),
        r["within_1_sigma"].get<double>());
    std::fflush(stdout);
    write_json(out / fmt::format("twin_{}_{}_{}.json", kind, field, keys["grid"]), rows);
  }
  return 0;
}
