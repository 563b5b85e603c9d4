#pragma once

// The silicone beam 30 x 30 x 100 mm of shared/data/physics_beam, clamped at one end and let go, with or without a
// weight on the lower edge of its tip: its model, and its recordings in the model's frame.

#include <string>
#include <vector>

#include "fitting/observe/markers.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant::fixture {

constexpr double kPublishedYoung = 263824, kPublishedDensity = 1070;  // Pa, kg/m^3
constexpr double kBeamHeight = 0.03, kBeamLength = 0.1, kGravity = 9.81;

/// The beam along z, clamped at z = 0 by a foot of three cells; up is x.  Eight particles to a cell.
struct Beam {
  Particles particles;
  std::vector<Interaction> interactions;
  double dx = 0;
};

/// `weight` [N] hangs on the lower edge of the tip, on the outermost half of a cell.
inline Beam silicone_beam(int cells, double young, double poisson, double density = kPublishedDensity,
                          double weight = 0) {
  Beam out;
  out.dx = kBeamHeight / cells;
  out.particles =
      fixture::block<float>({kBeamHeight, kBeamHeight, kBeamLength + 3 * out.dx}, out.dx, 0.0, young, poisson, density);
  for (Vec3f& x : out.particles.position) x.z() -= static_cast<float>(3 * out.dx);
  Interaction pin, fall;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d::Zero(), Vec3d(0, 0, 1));
  fall.type = InteractionType::kGust;
  fall.vector = Vec3d(-kGravity, 0, 0);
  out.interactions = {pin, fall};
  if (weight > 0) {
    Interaction hung;
    hung.type = InteractionType::kWeight;
    hung.mass = weight / kGravity;
    hung.region = Region::box(Vec3d(-1, -1, kBeamLength - 0.5 * out.dx), Vec3d(0.5 * out.dx, 1, kBeamLength + out.dx));
    out.interactions.push_back(hung);
  }
  return out;
}

/// Three markers near the tip, in the beam's frame.  Where the beam lies in the frame of the cameras is not documented:
/// the outermost marker of `gravity`, a recording without weight, at rest in [from, until] s, is taken to be at the
/// tip; of the two across, the beam's axis is midway between the markers on its sides, and at the height at which the
/// final tilt of the section leaves only the shortening that bending causes.  Other recordings are laid on this one by
/// the three markers on the clamp.
inline MarkerTracks beam_recording(const std::string& file, const std::string& gravity, double from, double until) {
  const MarkerTracks reference = read_markers(gravity);
  const std::vector<Vec3d> rest = mean_position(reference, 0.2, 0.6),
                           last = mean_position(reference, reference.time.back() - 0.5, reference.time.back());
  const Vec3d top = last[0] - rest[0], low = last[2] - rest[2];
  const double tilt = (top.z() - low.z()) / (rest[0].x() - rest[2].x());
  const double shortening = 0.5 * tilt * tilt * kBeamLength * 0.643;  // integral of the slope squared, uniform load
  const double axis = rest[0].x() - (top.z() + shortening) / tilt;
  Vec3d origin(axis - 0.5 * kBeamHeight, 0.5 * (rest[1].y() + rest[2].y()) - 0.5 * kBeamHeight,
               rest[1].z() - kBeamLength);
  MarkerTracks tracks = read_markers(file);
  const std::vector<Vec3d> own = mean_position(tracks, from, until);
  origin += (own[3] + own[4] + own[5] - rest[3] - rest[4] - rest[5]) / 3;
  tracks.name.resize(3);
  for (auto& frame : tracks.position) {
    frame.resize(3);
    for (Vec3d& x : frame) x -= origin;
  }
  for (auto& frame : tracks.weight) frame.resize(3);
  return tracks;
}

/// Mean fall of the markers, m, over the samples in [begin, end], from where they were in [from, until].
inline double mean_sag(const MarkerTracks& tracks, double from, double until, double begin, double end) {
  const auto rest = mean_position(tracks, from, until), now = mean_position(tracks, begin, end);
  return (rest[0] - now[0] + rest[1] - now[1] + rest[2] - now[2]).x() / 3;
}

}  // namespace pliant::fixture
