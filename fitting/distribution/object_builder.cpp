#include "fitting/distribution/object_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kUsualSamples = 40000;  // of interior_fill.h
constexpr double kSeenSpacings = 8;      // thickness that it measures, in spacings of its samples

/// A smooth random function of place: a few waves of random direction and phase.
class SmoothNoise {
 public:
  SmoothNoise(Random& random, double amplitude, double length)
      : amplitude_(amplitude / std::sqrt(waves_.size() / 2.0)) {
    for (Wave& w : waves_) {
      for (double& c : w.number.reshaped()) c = random.normal() * 3 / length;
      w.phase = random.uniform(0, 6.283185307179586);
    }
  }
  double at(const Vec3f& x) const {
    double sum = 0;
    for (const Wave& w : waves_) sum += std::sin(w.number.dot(x.cast<double>()) + w.phase);
    return amplitude_ * sum;
  }

 private:
  struct Wave {
    Vec3d number;
    double phase;
  };
  std::array<Wave, 6> waves_;
  double amplitude_;
};

}  // namespace

ObjectBuilder::ObjectBuilder(std::string family, uint64_t seed) : family_(std::move(family)), random_(seed) {
  uint64_t name = 1469598103934665603ull;  // FNV-1a, so that families differ under one seed
  for (const char c : family_) name = (name ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  random_ = Random(seed, name);
}

double ObjectBuilder::log_between(double low, double high) {
  return std::exp(random_.uniform(std::log(low), std::log(high)));
}

int ObjectBuilder::count(int low, int high) { return low + static_cast<int>(random_.below(high - low + 1)); }

Vec3f ObjectBuilder::tint(const Vec3f& colour, double spread) {
  Vec3f out = colour;
  for (float& c : out.reshaped()) c = std::clamp(c + static_cast<float>(spread * random_.normal()), 0.02f, 0.98f);
  return out;
}

Vec3f ObjectBuilder::any_colour() {
  Vec3f out;
  for (float& c : out.reshaped()) c = static_cast<float>(random_.uniform(0.05, 0.95));
  return out;
}

Vec3f ObjectBuilder::outward(double rise) {
  const double angle = between(0, 6.283185307179586), flat = std::sqrt(1 - rise * rise);
  return Vec3d(flat * std::cos(angle), flat * std::sin(angle), rise).cast<float>();
}

double ObjectBuilder::spacing_for(double samples) const {
  double low = 1e-6, high = 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    double sum = 0;
    for (const Piece& piece : pieces_) sum += piece.shape->samples_at(middle);
    (sum > samples ? low : high) = middle;
  }
  return high;
}

MaterialObject ObjectBuilder::build() {
  CHECK(!pieces_.empty());
  const double spacing = spacing_for(between(900, 2000));
  const double seen = kSeenSpacings * spacing_for(kUsualSamples);
  MaterialObject out;
  out.family = family_;
  out.samples.spacing = static_cast<float>(spacing);

  Box box;
  std::vector<int> piece_of;
  std::vector<ShapePoint> places;
  for (size_t k = 0; k < pieces_.size(); ++k) {
    const SolidShape& shape = *pieces_[k].shape;
    const double wanted = shape.samples_at(spacing);
    const int samples = static_cast<int>(wanted + random_.uniform());
    for (int i = 0; i < samples; ++i) {
      const ShapePoint p = shape.sample(random_);
      bool taken = false;
      for (size_t later = k + 1; later < pieces_.size() && !taken; ++later)
        taken = pieces_[later].shape->contains(p.position);
      if (taken) continue;
      piece_of.push_back(static_cast<int>(k));
      places.push_back(p);
      out.samples.volume.push_back(static_cast<float>(shape.volume() / wanted));
      out.samples.thickness.push_back(shape.thickness() < seen ? static_cast<float>(shape.thickness()) : 0.0f);
      box.add(p.position);
    }
  }
  CHECK(!places.empty());

  // Parts as a segmentation would tell them: all, none, or some taken together.
  const double segmentation = random_.uniform();
  std::vector<int> label(std::max(parts_, 1));
  for (size_t i = 0; i < label.size(); ++i) label[i] = segmentation > 0.85 && chance(0.3) ? 0 : static_cast<int>(i);
  const bool known = segmentation > 1.0 / 3;

  const double size = std::max(1e-3, double{box.size().norm()});
  const double amplitude = between(0.03, 0.15), grain = between(0.02, 0.08), light = between(0.7, 1.15);
  const SmoothNoise noise(random_, amplitude, size * between(0.3, 1)), weight(random_, 0.02, size * between(0.3, 1));
  const bool painted = chance(0.25);
  std::vector<Vec3f> paint(pieces_.size() + label.size());
  for (Vec3f& c : paint) c = any_colour();
  const float yaw = static_cast<float>(between(0, 6.283185307179586)), cosine = std::cos(yaw), sine = std::sin(yaw);
  for (size_t i = 0; i < places.size(); ++i) {
    const Piece& piece = pieces_[piece_of[i]];
    const Vec3f x = places[i].position;
    const Substance s = piece.filling(places[i]);
    const double young = s.young * std::pow(10.0, noise.at(x) + grain * random_.normal());
    out.young.push_back(static_cast<float>(std::clamp(young, 1e2, 5e11)));
    out.poisson.push_back(static_cast<float>(std::clamp(s.poisson + 0.01 * random_.normal(), 0.0, 0.49)));
    out.density.push_back(static_cast<float>(std::clamp(s.density * std::pow(10.0, weight.at(x)), 5.0, 2e4)));
    Vec3f colour = painted ? paint[piece.part] : piece.colour(places[i]);
    colour *= static_cast<float>(light);
    for (float& c : colour.reshaped()) c = std::clamp(c + 0.03f * static_cast<float>(random_.normal()), 0.0f, 1.0f);
    out.colour.push_back(colour);
    if (known) out.part.push_back(label[piece.part]);
    out.samples.position.push_back({cosine * x.x() - sine * x.y(), sine * x.x() + cosine * x.y(), x.z()});
  }
  return out;
}

}  // namespace pliant
