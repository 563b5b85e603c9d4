#include "app/seed/body_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "gaussians/base/nearest.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/sheets/sides_sheet.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr size_t kShown = 6;          // pieces with a colour or a sentence of their own
const Vec3f kRest(0.6f, 0.6f, 0.6f);  // colour of what is not simulated

}  // namespace

bool BodyPieces::any_loose() const { return std::find(loose.begin(), loose.end(), 1) != loose.end(); }

BodyPieces find_body_pieces(const SolidSamples& samples, const std::vector<Region>& pins, SimulatedPart& part) {
  BodyPieces body;
  body.samples = part.kept;
  const SolidSamples kept = samples.select(part.kept);
  body.pieces = find_pieces(kept.position, kept.volume, kPieceReach * part.cell_size);
  const size_t n = body.pieces.size();
  body.held = held_pieces(body.pieces, kept.position, pins);
  body.centre.assign(n, Vec3f::Zero());
  body.count.assign(n, 0);
  const double whole = kept.total_volume();
  for (size_t i = 0; i < kept.size(); ++i) {
    const int p = body.pieces.piece[i];
    ++body.count[p];
    body.centre[p] += kept.position[i] * static_cast<float>(kept.volume[i] / body.pieces.weight[p]);
  }
  for (size_t p = 0; p < n; ++p)
    body.loose.push_back(!body.held[p] && p > 0 && body.pieces.weight[p] < kOwnBody * whole);
  if (!body.any_loose()) return body;
  part.kept.clear();
  part.volume = 0;
  for (size_t i = 0; i < kept.size(); ++i) {
    if (body.loose[body.pieces.piece[i]]) continue;
    part.kept.push_back(body.samples[i]);
    part.volume += kept.volume[i];
  }
  return body;
}

std::vector<int> followed_samples(const SolidSamples& samples, const SimulatedPart& part, const BodyPieces& body) {
  if (!body.any_loose()) return {};
  const SolidSamples kept = samples.select(part.kept);
  const NearestPoints simulated(kept.position);
  std::vector<NearestPoints::Hit> nearest(body.pieces.size(), {-1, INFINITY}), hits;
  for (size_t i = 0; i < body.samples.size(); ++i) {
    const int p = body.pieces.piece[i];
    if (!body.loose[p]) continue;
    simulated.query(samples.position[body.samples[i]], 1, hits);
    if (hits[0].distance < nearest[p].distance) nearest[p] = hits[0];
  }
  std::vector<int> follows(samples.size(), -1);
  for (size_t i = 0; i < body.samples.size(); ++i)
    if (const int p = body.pieces.piece[i]; body.loose[p]) follows[body.samples[i]] = part.kept[nearest[p].index];
  return follows;
}

void tell_loose(const Context& context, const BodyPieces& body) {
  constexpr int kPercent = 100;
  const bool any_held = std::find(body.held.begin(), body.held.end(), 1) != body.held.end();
  const double whole = std::accumulate(body.pieces.weight.begin(), body.pieces.weight.end(), 0.0);
  for (size_t p = 0; p < body.held.size(); ++p) {
    if (!any_held || body.held[p] || body.loose[p]) continue;
    const Vec3f& c = body.centre[p];
    context.progress.warn(fmt::format(
        "a piece of {:.0f} % of the volume around ({:.3f}, {:.3f}, {:.3f}) is held by nothing and will drift "
        "(pieces.png; \"pinned\" in scene.json holds it)",
        kPercent * body.pieces.weight[p] / whole, c.x(), c.y(), c.z()));
  }
  std::string places;
  size_t loose = 0, samples = 0;
  for (size_t p = 0; p < body.loose.size(); ++p) {
    if (!body.loose[p]) continue;
    samples += body.count[p];
    if (++loose > kShown) continue;
    const Vec3f& c = body.centre[p];
    places += fmt::format("{}{} around ({:.3f}, {:.3f}, {:.3f})", places.empty() ? "" : ", ", body.count[p], c.x(),
                          c.y(), c.z());
  }
  if (loose > 0)
    context.progress.warn(
        fmt::format("{} of {} pieces ({} of {} samples) are disconnected and follow the nearest simulated part: {}{} "
                    "(pieces.png)",
                    loose, body.pieces.size(), samples, body.samples.size(), places, loose > kShown ? ", ..." : ""));
}

json pieces_json(const BodyPieces& body) {
  constexpr size_t kMost = 100;
  json rows = json::array();
  for (size_t p = 0; p < std::min(kMost, body.pieces.size()); ++p)
    rows.push_back({{"samples", body.count[p]},
                    {"volume", body.pieces.weight[p]},
                    {"centre", {body.centre[p].x(), body.centre[p].y(), body.centre[p].z()}},
                    {"simulated", body.loose[p] == 0}});
  return rows;
}

void write_pieces(const RunDirectory& run, const GaussianCloud& object, const Eigen::Vector3d& up,
                  const SolidSamples& samples, const BodyPieces& body) {
  const Vec3f colors[kShown] = {{0.1f, 0.9f, 0.2f}, {0.2f, 0.45f, 1.0f}, {1.0f, 0.6f, 0.0f},
                                {0.7f, 0.4f, 1.0f}, {0.1f, 0.9f, 0.9f},  {0.9f, 0.9f, 0.1f}};
  const int shown = static_cast<int>(std::min(kShown, body.pieces.size())), loose = shown, rest = loose + 1;
  std::vector<SheetKind> kinds;
  for (int p = 0; p < shown; ++p) kinds.push_back({p ? fmt::format("piece {}", p + 1) : "body", colors[p], 0});
  kinds.push_back({"disconnected", Vec3f(1.0f, 0.1f, 0.1f), 0});
  kinds.push_back({"not simulated", kRest, 0});
  // What a sample shows, then what the sample nearest to a Gaussian shows.
  std::vector<int> of_sample(samples.size(), rest);
  for (size_t i = 0; i < body.samples.size(); ++i) {
    const int p = body.pieces.piece[i];
    of_sample[body.samples[i]] = body.loose[p] ? loose : std::min(p, shown - 1);
  }
  const std::vector<int> nearest = k_nearest(samples.position, object.position, 1);
  std::vector<int> kind(object.size());
  for (size_t g = 0; g < object.size(); ++g) ++kinds[kind[g] = of_sample[nearest[g]]].count;
  const std::string title =
      fmt::format("the simulated body: {} piece{}", body.pieces.size(), body.pieces.size() == 1 ? "" : "s");
  write_image(run / "pieces.png", sides_sheet(object, sheet_sides(object, up), kind, kinds, title, {}));
}

}  // namespace pliant
