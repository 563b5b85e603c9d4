#include "fitting/modal/modal_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

constexpr double kFall = 0.95;    // less than this share of what was unexplained one frame before: still pushed
constexpr double kNothing = 0.9;  // unexplained from which on a search has found nothing
constexpr double kGrowth = 1;     // decades, by which the range grows at a time

/// Normal equations of one frame, by the modes.
struct Frame {
  Eigen::MatrixXd products;  // [m, m] sum of weight * response_j . response_k
  Eigen::VectorXd moments;   // [m] sum of weight * response_k . displacement
  double square = 0;         // sum of weight * |displacement|^2
};

std::vector<Frame> compress(const VibrationModes& modes, const Particles& particles, const TrackLoss<float>& tracks) {
  const size_t m = modes.size(), points = tracks.tracks().rest.size();
  const SimulationState rest = initial_state(particles);
  const std::vector<Vec3f> still = tracks.expected(rest);
  std::vector<std::vector<Vec3d>> response(m, std::vector<Vec3d>(points));
  for (size_t k = 0; k < m; ++k) {
    double largest = 0;
    for (const Vec3d& u : modes.shape[k]) largest = std::max(largest, u.norm());
    const double small = 0.05 * particles.cell_size / largest;
    std::vector<double> displacement(m, 0.0);
    displacement[k] = small;
    const std::vector<Vec3f> moved =
        tracks.expected(modal_state(modes, particles, displacement, std::vector<double>(m, 0.0)));
    for (size_t p = 0; p < points; ++p) response[k][p] = (moved[p] - still[p]).cast<double>() / small;
  }
  const PointTracks& seen = tracks.tracks();
  std::vector<Frame> frames(seen.place.size());
  for (size_t f = 0; f < frames.size(); ++f) {
    frames[f].products = Eigen::MatrixXd::Zero(m, m);
    frames[f].moments = Eigen::VectorXd::Zero(m);
    for (size_t p = 0; p < seen.place[f].size(); ++p) {
      const double w = seen.weight[f][p];
      if (!(w > 0)) continue;
      const Vec3d d = seen.place[f][p] - still[p].cast<double>();
      frames[f].square += w * d.squaredNorm();
      for (size_t j = 0; j < m; ++j) {
        frames[f].moments[j] += w * response[j][p].dot(d);
        for (size_t k = 0; k < m; ++k) frames[f].products(j, k) += w * response[j][p].dot(response[k][p]);
      }
    }
  }
  return frames;
}

class Searcher {
 public:
  Searcher(const ModalSearchOptions& options, const VibrationModes& modes, std::vector<Frame> frames, double fps)
      : options_(options),
        modes_(modes),
        frames_(std::move(frames)),
        fps_(fps),
        low_(options.low),
        high_(options.high) {}

  /// Best amplitudes of one candidate for the frames from `first` on.
  ModalMotion solve(double log10_factor, double damping_rate, int first) const {
    const double root = std::pow(10.0, 0.5 * log10_factor);
    const int m = static_cast<int>(modes_.size());
    ModalMotion motion;
    motion.log10_factor = log10_factor;
    motion.damping_rate = damping_rate;
    motion.time = first / fps_;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(2 * m, 2 * m);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(2 * m);
    double total = 0;
    std::vector<bool> slow(m);  // slow enough for the frame rate
    for (int k = 0; k < m; ++k) {
      motion.omega.push_back(modes_.omega[k] * root);
      motion.rate.push_back(damping_rate + modes_.decay[k] * root);
      slow[k] = motion.omega[k] < 0.8 * std::numbers::pi * fps_;
    }
    if (!slow[0]) return motion.cosine.assign(m, 0.0), motion.sine.assign(m, 0.0), motion;
    Eigen::VectorXd time(2 * m);
    for (size_t f = first; f < frames_.size(); ++f) {
      const double s = static_cast<double>(f) / fps_ - motion.time;
      for (int k = 0; k < m; ++k) {
        const double fall = slow[k] ? std::exp(-motion.rate[k] * s) : 0;
        time[k] = fall * std::cos(motion.omega[k] * s);
        time[m + k] = fall * std::sin(motion.omega[k] * s);
      }
      for (int k = 0; k < m; ++k) {
        right[k] += time[k] * frames_[f].moments[k];
        right[m + k] += time[m + k] * frames_[f].moments[k];
        // The lower triangle of the cosines, of the sines, and all of the sines by the cosines.
        for (int l = 0; l < m; ++l) {
          const double product = frames_[f].products(k, l);
          if (l <= k) {
            normal(k, l) += time[k] * time[l] * product;
            normal(m + k, m + l) += time[m + k] * time[m + l] * product;
          }
          normal(m + k, l) += time[m + k] * time[l] * product;
        }
      }
      total += frames_[f].square;
    }
    normal = Eigen::MatrixXd(normal.selfadjointView<Eigen::Lower>());
    const double strongest = normal.diagonal().maxCoeff();
    for (int a = 0; a < 2 * m; ++a) {
      const double ratio = modes_.omega[a % m] / modes_.omega[0];
      normal(a, a) += options_.ridge * strongest * ratio * ratio;
    }
    const Eigen::VectorXd x = solve_symmetric(normal, right);
    motion.cosine.assign(x.data(), x.data() + m);
    motion.sine.assign(x.data() + m, x.data() + 2 * m);
    // |d|^2 - 2 x.r + x.N x with the prior in N is |d|^2 - x.r.
    motion.unexplained = total > 0 ? std::clamp((total - x.dot(right)) / total, 0.0, 1.0) : 1;
    return motion;
  }

  ModalMotion best_damping(double log10_factor, int first) const {
    ModalMotion best;
    best.unexplained = 2;
    for (const double rate : options_.damping_rates) {
      ModalMotion motion = solve(log10_factor, rate, first);
      if (motion.unexplained < best.unexplained) best = std::move(motion);
    }
    return best;
  }

  std::vector<ModalMotion> curve(int first, double step) const {
    const int count = static_cast<int>(std::lround((high_ - low_) / step)) + 1;
    std::vector<ModalMotion> motions(count);
    parallel_for(
        count, [&](std::ptrdiff_t i) { motions[i] = best_damping(low_ + i * step, first); }, 1);
    return motions;
  }

  /// More of the range at its low (-1) or high (1) end; false where it does not grow any more.
  bool grow(int end) {
    double& limit = end < 0 ? low_ : high_;
    const double grown = std::clamp(limit + end * kGrowth, -options_.farthest, options_.farthest);
    if (end == 0 || !(std::abs(grown - limit) > 0.5 * options_.step) || (grown > limit) != (end > 0)) return false;
    limit = grown;
    return true;
  }

  int last_start() const { return static_cast<int>(frames_.size()) / 2; }

  /// The first frame after which a free vibration explains nearly as much as it ever does.  The end of a push, when
  /// little of it is left to come, nearly passes for free motion: while later starts still explain more, the push goes
  /// on.
  int first_free_frame() const {
    const int last = last_start();
    std::vector<double> unexplained;
    for (int first = 0; first <= last; ++first) {
      double best = 1;
      for (const ModalMotion& motion : curve(first, std::max(options_.step, 0.05)))
        best = std::min(best, motion.unexplained);
      unexplained.push_back(best);
    }
    const double least = *std::min_element(unexplained.begin(), unexplained.end());
    for (int first = 0; first <= last; ++first)
      if (unexplained[first] <= 1.3 * least + 0.003) return first == 0 ? 0 : end_of_push(unexplained, first);
    return last;
  }

 private:
  /// One frame beyond the last of the falls that begin at `first`; `first` where there is none.
  static int end_of_push(const std::vector<double>& unexplained, int first) {
    const int last = static_cast<int>(unexplained.size()) - 1;
    int f = first;
    while (f < last && unexplained[f + 1] < kFall * unexplained[f]) ++f;
    return f == first ? first : std::min(f + 1, last);
  }

  const ModalSearchOptions& options_;
  const VibrationModes& modes_;
  std::vector<Frame> frames_;
  double fps_, low_, high_;
};

/// Curve and minima, from `first` or where that is negative from the frame that is found on.
ModalSearch search_range(const Searcher& searcher, const ModalSearchOptions& options, int first) {
  ModalSearch result;
  result.first_frame = first >= 0 ? first : searcher.first_free_frame();
  result.late = first < 0 && result.first_frame == searcher.last_start();
  const std::vector<ModalMotion> curve = searcher.curve(result.first_frame, options.step);
  for (size_t i = 0; i < curve.size(); ++i) {
    result.log10_factor.push_back(curve[i].log10_factor);
    result.unexplained.push_back(curve[i].unexplained);
    const double here = curve[i].unexplained;
    const bool low =
        (i == 0 || here <= curve[i - 1].unexplained) && (i + 1 == curve.size() || here < curve[i + 1].unexplained);
    if (low && here < 1) result.minima.push_back(curve[i]);
  }
  std::stable_sort(result.minima.begin(), result.minima.end(),
                   [](const ModalMotion& a, const ModalMotion& b) { return a.unexplained < b.unexplained; });
  if (static_cast<int>(result.minima.size()) > options.most_minima) result.minima.resize(options.most_minima);
  return result;
}

/// The frame in which the tracks are farthest from rest, root mean square.
size_t farthest_frame(const std::vector<Frame>& frames, const PointTracks& tracks) {
  size_t farthest = 0;
  double most = 0;
  for (size_t f = 0; f < frames.size(); ++f) {
    double weight = 0;
    for (const double w : tracks.weight[f]) weight += w;
    if (weight > 0 && frames[f].square / weight > most) {
      most = frames[f].square / weight;
      farthest = f;
    }
  }
  return farthest;
}

size_t strongest_mode(const ModalMotion& motion) {
  size_t best = 0;
  for (size_t k = 1; k < motion.omega.size(); ++k)
    if (std::hypot(motion.cosine[k], motion.sine[k]) > std::hypot(motion.cosine[best], motion.sine[best])) best = k;
  return best;
}

}  // namespace

double ModalMotion::displacement(size_t k, double t) const {
  const double s = t - time;
  return std::exp(-rate[k] * s) * (cosine[k] * std::cos(omega[k] * s) + sine[k] * std::sin(omega[k] * s));
}

double ModalMotion::velocity(size_t k, double t) const {
  const double s = t - time, c = std::cos(omega[k] * s), d = std::sin(omega[k] * s);
  return std::exp(-rate[k] * s) *
         ((sine[k] * omega[k] - rate[k] * cosine[k]) * c - (cosine[k] * omega[k] + rate[k] * sine[k]) * d);
}

int ModalSearch::end_of(const ModalMotion& minimum) const {
  return minimum.log10_factor == log10_factor.front() ? -1 : minimum.log10_factor == log10_factor.back() ? 1 : 0;
}

ModalSearch modal_search(const ModalSearchOptions& options, const VibrationModes& modes, const Particles& particles,
                         const TrackLoss<float>& tracks, double fps) {
  CHECK(modes.size() > 0 && tracks.tracks().place.size() > 1);
  std::vector<Frame> frames = compress(modes, particles, tracks);
  double moved = 0, weight = 0;
  for (size_t f = 0; f < frames.size(); ++f) {
    moved += frames[f].square;
    for (const double w : tracks.tracks().weight[f]) weight += w;
  }
  if (!(weight > 0) || !(moved > 0))
    throw input_error("reference", "motion", "is missing: no point of the object moves",
                      "give a reference in which the object moves");
  const int count = static_cast<int>(frames.size());
  const bool away = farthest_frame(frames, tracks.tracks()) == frames.size() - 1;
  Searcher searcher(options, modes, std::move(frames), fps);
  const int told =
      options.first >= 0 ? std::clamp(static_cast<int>(std::lround(options.first * fps)), 0, count - 2) : -1;
  // Vibrations too fast for the frame rate explain nothing: softer ones may.
  const auto side = [](const ModalSearch& found) {
    return found.minima.empty() || found.minima[0].unexplained > kNothing ? -1 : found.end_of(found.minima[0]);
  };
  const ModalSearch given = search_range(searcher, options, told);
  ModalSearch result = given;
  while (searcher.grow(side(result))) result = search_range(searcher, options, told);
  if (side(result) != 0) result = given;
  if (result.minima.empty())
    throw input_error("reference", "motion", "is not explained by vibrations at any stiffness",
                      "check camera and frame rate, and that the object is pinned");
  result.end = result.end_of(result.minima[0]);
  result.away = result.late && away;
  const double seconds = (count - 1 - result.first_frame) / fps;
  for (ModalMotion& minimum : result.minima)
    minimum.periods = seconds * minimum.omega[strongest_mode(minimum)] / (2 * std::numbers::pi);
  result.periods = result.minima[0].periods;
  return result;
}

SimulationState modal_state(const VibrationModes& modes, const Particles& particles,
                            const std::vector<double>& displacement, const std::vector<double>& velocity) {
  SimulationState state = initial_state(particles);
  for (size_t i = 0; i < state.size(); ++i) {
    Vec3d u = Vec3d::Zero(), v = Vec3d::Zero();
    Mat3d G = Mat3d::Zero(), C = Mat3d::Zero();
    for (size_t k = 0; k < modes.size(); ++k) {
      u += displacement[k] * modes.shape[k][i];
      v += velocity[k] * modes.shape[k][i];
      G += displacement[k] * modes.gradient[k][i];
      C += velocity[k] * modes.gradient[k][i];
    }
    state.x[i] += u.cast<float>();
    state.v[i] = v.cast<float>();
    state.F[i] += G.cast<float>();
    state.C[i] = C.cast<float>();
  }
  return state;
}

double time_near_rest(const ModalMotion& motion, double time, double step) {
  const double half_period = std::numbers::pi / motion.omega[strongest_mode(motion)];
  double best = time, least = INFINITY;
  for (int i = 0; i * step <= std::min(half_period, time) + 1e-9; ++i) {
    double square = 0;
    for (size_t k = 0; k < motion.omega.size(); ++k) square += std::pow(motion.displacement(k, time - i * step), 2);
    if (square < least) {
      least = square;
      best = time - i * step;
    }
  }
  return best;
}

}  // namespace pliant
