// The silicone beam 30 x 30 x 100 mm (E 263,824 Pa, rho 1070 kg/m^3) that is clamped at one end and let go under
// gravity.
//   beam_study fem CELLS NU [swing]      static sag of the tip face and first frequency against finite elements
//   beam_study slender CELLS OFFSET_X OFFSET_Y OFFSET_Z   beam of L = 10 h: how the answer depends on where the grid
//   lies beam_study damping CELLS FLIP_TIME COURANT DAMPING_RATIO   decay of the first mode beam_study capture CSV
//   CELLS NU DAMPING_TIME FLIP_TIME OUT.png   against motion capture; overlay plot
// One JSON object per case.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>

#include "gaussians/io/images/codecs.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr double kPi = 3.14159265358979324;
constexpr double kYoung = 263824, kDensity = 1070, kHeight = 0.03, kLength = 0.1, kGravity = 9.81;

/// Tip face over time under a load that sets in at once.
struct Swing {
  double fps = 0;
  std::vector<double> tip;  ///< m, along the load
  size_t particles = 0;
  double seconds = 0, dx = 0;
};

struct BeamCase {
  int cells = 6;
  double poisson = 0.45, young = kYoung, length = kLength, height = kHeight, gravity = kGravity;
  double duration = 0.4, fps = 2000;
  double viscosity_time = 0, damping_time = 0, flip_time = 0, courant = 0.4;
  Vec3d offset = Vec3d::Zero();  ///< of the beam against the grid, in cells
  double from = 1;               ///< mean over particles beyond this share of the length; 1 = half a cell at the tip
};

/// Beam along x, clamped at x = 0 by a foot of three cells, stratified particles, eight to a cell.
Swing swing(const BeamCase& c) {
  const double dx = c.height / c.cells, foot = 3 * dx;
  Particles p = fixture::block<float>({c.length + foot, c.height, c.height}, dx, 0.0, c.young, c.poisson, kDensity);
  const Vec3f shift = (c.offset * dx).cast<float>();
  for (Vec3f& x : p.position) x += shift;
  SimulateOptions options;
  options.gravity.setZero();
  options.fps = c.fps;
  options.duration = c.duration;
  options.viscosity_time = c.viscosity_time;
  options.damping_time = c.damping_time;
  options.flip_time = c.flip_time;
  options.courant = c.courant;
  Interaction pin, load;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(foot + c.offset.x() * dx, 0, 0), Vec3d(1, 0, 0));
  load.type = InteractionType::kGust;
  load.vector = Vec3d(0, 0, -c.gravity);
  const double begin_of_tip = c.offset.x() * dx + foot + (c.from < 1 ? c.from * c.length : c.length - dx);
  Swing out;
  out.fps = c.fps;
  out.particles = p.size();
  out.dx = dx;
  const auto begin = std::chrono::steady_clock::now();
  simulate<float>(options, p, {pin, load}, initial_state(p), [&](const SimulationState& s) {
    double sum = 0, slope = 0;
    int count = 0;
    for (size_t i = 0; i < s.size(); ++i) {
      if (p.position[i].x() < begin_of_tip) continue;
      sum += p.position[i].z() - s.x[i].z();
      slope += s.F[i](2, 0);
      ++count;
    }
    // From the mean of the outermost cell to the face, by the slope there.
    out.tip.push_back(sum / count + (c.from < 1 ? 0 : -0.5 * dx * slope / count));
    return true;
  });
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

/// Extremes of a swing: times and values by parabolas through three samples.
struct Extreme {
  double time, value;
};
std::vector<Extreme> extremes(const std::vector<double>& tip, double fps) {
  std::vector<Extreme> found;
  for (size_t k = 1; k + 1 < tip.size(); ++k) {
    const double a = tip[k - 1], b = tip[k], c = tip[k + 1];
    if (!((b >= a && b > c) || (b <= a && b < c))) continue;
    const double bend = a - 2 * b + c;
    const Extreme e{(static_cast<double>(k) + 0.5 * (a - c) / bend) / fps, b - 0.125 * (a - c) * (a - c) / bend};
    // Ripples of higher modes are smaller than a tenth of the swing.
    if (!found.empty() && std::abs(e.value - found.back().value) < 0.1 * std::abs(found.front().value)) continue;
    found.push_back(e);
  }
  return found;
}

struct Fit {
  double frequency = 0, sag = 0, decrement = 0;
};
/// Frequency from returns to the low point, sag and decrement from successive half swings s (1 +- q^n).
Fit fit(const Swing& s) {
  const std::vector<Extreme> e = extremes(s.tip, s.fps);
  if (e.size() < 3) return {};
  const size_t last = e.size() - 1;
  const double ratio = std::pow(std::abs((e[last].value - e[last - 1].value) / (e[1].value - e[0].value)),
                                1.0 / static_cast<double>(last - 1));
  Fit f;
  f.frequency = 0.5 * static_cast<double>(last) / (e[last].time - e[0].time);
  f.sag = e[0].value / (1 + ratio);
  f.decrement = -2 * std::log(ratio);
  return f;
}

double fem_sag(double poisson) {
  return poisson < 0.42 ? 6.92e-3 : poisson < 0.47 ? 6.83e-3 : poisson < 0.495 ? 6.68e-3 : 6.64e-3;
}
double fem_frequency(double poisson) {
  return poisson < 0.42 ? 7.29 : poisson < 0.47 ? 7.34 : poisson < 0.495 ? 7.42 : 7.44;
}

void fem(int cells, double poisson, bool at_rest) {
  BeamCase c;
  c.cells = cells;
  c.poisson = poisson;
  const Swing s = swing(c);
  const Fit f = fit(s);
  // At rest: strongly damped motion.
  BeamCase rest = c;
  rest.damping_time = 0.06;
  rest.duration = 0.6;
  rest.fps = 50;
  const double sag = at_rest ? swing(rest).tip.back() : f.sag;
  std::printf(
      "{\"study\": \"fem\", \"cells\": %d, \"poisson\": %g, \"particles\": %zu, \"sag_mm\": %.4f, \"sag_error\": %.4f, "
      "\"frequency\": %.4f, \"frequency_error\": %.4f, \"sag_of_swing_mm\": %.4f, \"log_decrement\": %.4f, "
      "\"seconds\": %.1f}\n",
      cells, poisson, s.particles, 1e3 * sag, sag / fem_sag(poisson) - 1, f.frequency,
      f.frequency / fem_frequency(poisson) - 1, 1e3 * f.sag, f.decrement, s.seconds);
}

void slender(int cells, const Vec3d& offset) {
  BeamCase c;
  c.cells = cells;
  c.poisson = 0.3;
  c.height = 0.02;
  c.length = 0.2;
  c.young = 1e6;
  c.offset = offset;
  const double inertia = std::pow(c.height, 4) / 12, area = c.height * c.height;
  const double stiffness = c.young * inertia / (kDensity * area * std::pow(c.length, 4));
  const double frequency = 1.8751 * 1.8751 / (2 * kPi) * std::sqrt(stiffness), sag = 0.01 * c.length;
  c.gravity = sag * 8 * stiffness;
  c.fps = 80 * frequency;
  c.duration = 2.2 / frequency;
  const Swing s = swing(c);
  const Fit f = fit(s);
  std::printf(
      "{\"study\": \"slender\", \"cells\": %d, \"offset\": [%g, %g, %g], \"frequency_error\": %.4f, \"sag_error\": "
      "%.4f, "
      "\"log_decrement\": %.4f, \"seconds\": %.1f}\n",
      cells, offset[0], offset[1], offset[2], f.frequency / frequency - 1, f.sag / sag - 1, f.decrement, s.seconds);
}

void damping(int cells, double flip_time, double courant, double ratio) {
  constexpr double kFirstMode = 2 * kPi * 7.3;  // rad/s
  BeamCase c;
  c.flip_time = flip_time;
  c.courant = courant;
  c.damping_time = ratio > 0 ? 1 / (ratio * kFirstMode) : 0;
  c.cells = cells;
  c.duration = 6 / 7.3;
  const Swing s = swing(c);
  const Fit f = fit(s);
  std::printf(
      "{\"study\": \"damping\", \"cells\": %d, \"flip_time\": %g, \"courant\": %g, \"damping_ratio\": %g, "
      "\"log_decrement\": %.4f, \"left_after_5_periods\": %.4f, \"seconds\": %.1f}\n",
      cells, flip_time, courant, ratio, f.decrement, std::exp(-5 * f.decrement), s.seconds);
}

/// Mean sag of the tip's markers against those of the clamp, m, from the release on; 100 Hz.
std::vector<double> read_capture(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::vector<double> tip;
  while (std::getline(in, line)) {
    std::stringstream row(line);
    std::vector<double> v;
    for (std::string word; std::getline(row, word, ',');) v.push_back(std::atof(word.c_str()));
    if (v.size() < 19) continue;
    tip.push_back((v[1] + v[4] + v[7]) / 3 - (v[10] + v[13] + v[16]) / 3);
  }
  // The release is where the motion sets in; the level before it is zero.
  double level = 0;
  for (int k = 20; k < 60; ++k) level += tip[k] / 40;
  size_t release = 60;
  while (release + 1 < tip.size() && level - tip[release] < 2e-4) ++release;
  std::vector<double> sag;
  for (size_t k = release - 1; k < tip.size(); ++k) sag.push_back(level - tip[k]);
  return sag;
}

void plot(const std::string& file, const std::vector<double>& capture, const Swing& model, double shift) {
  const int width = 1400, height = 600, left = 70, bottom = 50;
  cv::Mat image(height, width, CV_8UC3, cv::Scalar(255, 255, 255));
  const double seconds = 2.0, top = 14e-3;
  const auto at = [&](double t, double y) {
    return cv::Point(left + static_cast<int>(t / seconds * (width - left - 20)),
                     20 + static_cast<int>(y / top * (height - bottom - 20)));
  };
  for (int mm = 0; mm <= 14; mm += 2) {
    cv::line(image, at(0, mm * 1e-3), at(seconds, mm * 1e-3), cv::Scalar(225, 225, 225));
    cv::putText(image, std::to_string(mm) + " mm", at(0, mm * 1e-3) - cv::Point(60, -5), cv::FONT_HERSHEY_SIMPLEX, 0.45,
                cv::Scalar(0, 0, 0));
  }
  for (int k = 0; k <= 4; ++k)
    cv::putText(image, cv::format("%.1f s", 0.5 * k), at(0.5 * k, top) + cv::Point(-10, 25), cv::FONT_HERSHEY_SIMPLEX,
                0.45, cv::Scalar(0, 0, 0));
  const auto curve = [&](const std::vector<double>& y, double fps, double begin, const cv::Scalar& colour, int thick) {
    for (size_t k = 0; k + 1 < y.size() && (k + 1) / fps + begin < seconds; ++k) {
      if (k / fps + begin < 0) continue;
      cv::line(image, at(k / fps + begin, y[k]), at((k + 1) / fps + begin, y[k + 1]), colour, thick, cv::LINE_AA);
    }
  };
  curve(capture, 100, 0, cv::Scalar(40, 40, 40), 2);
  curve(model.tip, model.fps, shift, cv::Scalar(30, 90, 230), 2);
  cv::putText(image, "motion capture (black), MPM (orange): sag of the tip's markers",
              cv::Point(left + 200, height - 12), cv::FONT_HERSHEY_SIMPLEX, 0.55, cv::Scalar(0, 0, 0));
  pliant::codecs::imwrite(file, image);
}

void capture(const std::string& csv, int cells, double poisson, double damping_time, double flip_time,
             const std::string& picture) {
  const std::vector<double> measured = read_capture(csv);
  Swing real;
  real.tip = measured;
  real.fps = 100;
  real.tip.resize(std::min<size_t>(real.tip.size(), 120));
  const Fit f_real = fit(real);
  double sag = 0;
  for (size_t k = measured.size() - 40; k < measured.size(); ++k) sag += measured[k] / 40;
  BeamCase c;
  c.cells = cells;
  c.poisson = poisson;
  c.damping_time = damping_time;
  c.flip_time = flip_time;
  c.duration = 1.6;
  c.fps = 1000;
  c.from = 0.95;
  const Swing s = swing(c);
  Swing first = s;
  first.tip.resize(1200);
  const Fit f = fit(first);
  double still = 0;
  for (size_t k = s.tip.size() - 200; k < s.tip.size(); ++k) still += s.tip[k] / 200;
  // The first low points of both lie on each other.
  const double shift = extremes(real.tip, real.fps)[0].time - extremes(s.tip, s.fps)[0].time;
  double squares = 0, energy = 0;
  for (size_t k = 0; k < 150; ++k) {
    const double t = (k / 100.0 - shift) * s.fps;
    if (t < 0 || t + 1 >= static_cast<double>(s.tip.size())) continue;
    const size_t i = static_cast<size_t>(t);
    const double model = s.tip[i] + (t - i) * (s.tip[i + 1] - s.tip[i]);
    squares += (model - measured[k]) * (model - measured[k]);
    energy += (measured[k] - sag) * (measured[k] - sag);
  }
  std::printf(
      "{\"study\": \"capture\", \"cells\": %d, \"poisson\": %g, \"damping_time\": %g, \"flip_time\": %g, \"sag_mm\": "
      "%.4f, \"captured_sag_mm\": %.4f, "
      "\"sag_error\": %.4f, \"frequency\": %.4f, \"captured_frequency\": %.4f, \"frequency_error\": %.4f, "
      "\"log_decrement\": %.4f, "
      "\"captured_log_decrement\": %.4f, \"residual_over_motion\": %.4f, \"seconds\": %.1f}\n",
      cells, poisson, damping_time, flip_time, 1e3 * still, 1e3 * sag, still / sag - 1, f.frequency, f_real.frequency,
      f.frequency / f_real.frequency - 1, f.decrement, f_real.decrement, std::sqrt(squares / energy), s.seconds);
  plot(picture, measured, s, shift);
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  const std::string study = argc > 1 ? argv[1] : "";
  if (study == "fem" && (argc == 4 || argc == 5)) {
    fem(std::atoi(argv[2]), std::atof(argv[3]), argc == 4);
  } else if (study == "slender" && argc == 6) {
    slender(std::atoi(argv[2]), {std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5])});
  } else if (study == "damping" && argc == 6) {
    damping(std::atoi(argv[2]), std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5]));
  } else if (study == "capture" && argc == 8) {
    capture(argv[2], std::atoi(argv[3]), std::atof(argv[4]), std::atof(argv[5]), std::atof(argv[6]), argv[7]);
  } else {
    std::fprintf(stderr,
                 "usage: beam_study fem CELLS NU | slender CELLS OX OY OZ | damping CELLS FLIP_TIME COURANT "
                 "DAMPING_RATIO | capture CSV CELLS NU DAMPING_TIME FLIP_TIME OUT.png\n");
    return 2;
  }
  return 0;
}
