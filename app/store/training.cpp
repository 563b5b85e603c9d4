#include "app/store/training.h"

#include <cstring>

#include "app/store/hdf5_file.h"
#include "gaussians/base/error.h"
#include "gaussians/reconstruct/exposure.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr int kMostChannels = 16;  // of an AttributeTerm

/// Calls visit(name, array, width) for the arrays that do not belong to single Gaussians.
template <class State, class Visit>
void visit_shared_arrays(State& s, Visit&& visit) {
  visit("/exposure", s.exposure, kExposureSize);
  visit("/exposure_first", s.exposure_moments.first, kExposureSize);
  visit("/exposure_second", s.exposure_moments.second, kExposureSize);
  visit("/shared", s.shared, 1);
  visit("/shared_first", s.shared_moments.first, 1);
  visit("/shared_second", s.shared_moments.second, 1);
}

/// Numbers per Gaussian of an array, `channels` of the attribute.
size_t width_of(std::string name, const GaussianCloud& cloud, size_t channels) {
  for (const std::string moment : {"_first", "_second"}) {
    if (name.size() > moment.size() && name.ends_with(moment)) name.resize(name.size() - moment.size());
  }
  if (name == "position" || name == "log_scale") return 3;
  if (name == "rotation") return 4;
  if (name == "sh") return 3 * static_cast<size_t>(cloud.sh_count());
  return name == "attribute" ? channels : 1;
}

/// A whole number of at least 0 that is stored as an attribute of the root.
double whole_number(const Hdf5Reader& in, const std::string& name, double most) {
  const double value = in.number("/", name);
  if (!(value >= 0 && value <= most && value == std::floor(value)))
    throw in.complaint("/@" + name,
                       "is " + std::to_string(value) + ", not an integer from 0 to " + std::to_string(most));
  return value;
}

void read_curve(const Hdf5Reader& in, TrainingState& state) {
  const std::vector<double> rows = in.dataset<double>("/curve", {kAny, 5});
  for (size_t i = 0; i + 5 <= rows.size(); i += 5) {
    const double* row = &rows[i];
    for (int k : {0, 2}) {
      if (!(row[k] >= 0 && row[k] < 1e9))
        throw in.complaint("/curve", "holds " + std::to_string(row[k]) + " in row " + std::to_string(i / 5));
    }
    state.curve.push_back({static_cast<int>(row[0]), row[1], static_cast<size_t>(row[2]), row[3], row[4]});
  }
}

}  // namespace

void write_training(const fs::path& file, const TrainingCheckpoint& checkpoint) {
  const TrainingState& s = checkpoint.state;
  const size_t n = s.cloud.size();
  write_hdf5(file, [&](Hdf5Writer& out) {
    out.group("/gaussians");
    visit_gaussian_arrays(s, [&](const std::string& name, const auto& array) {
      const auto values = flat(array);
      CHECK(n > 0 && values.size() % n == 0);
      if (!values.empty()) out.dataset("/gaussians/" + name, values.data(), {n, values.size() / n});
    });
    visit_shared_arrays(s, [&](const char* name, const std::vector<float>& values, size_t width) {
      out.dataset(name, values.data(), {values.size() / width, width});
    });
    std::vector<double> curve;
    for (const CurvePoint& p : s.curve)
      curve.insert(curve.end(),
                   {static_cast<double>(p.iteration), p.seconds, static_cast<double>(p.gaussians), p.psnr, p.ssim});
    out.dataset("/curve", curve.data(), {s.curve.size(), 5});
    out.number("/", "sh_degree", s.cloud.sh_degree);
    out.number("/", "iteration", s.iteration);
    out.number("/", "seconds", s.seconds);
    out.number("/", "started_with", static_cast<double>(s.started_with));
    out.text("/", "start", checkpoint.start_json);
    out.text("/", "provenance", checkpoint.provenance_json);
  });
}

std::string read_training_provenance(const fs::path& file) { return Hdf5Reader(file).text("/", "provenance"); }

TrainingCheckpoint read_training(const fs::path& file) {
  const Hdf5Reader in(file);
  TrainingCheckpoint checkpoint;
  TrainingState& s = checkpoint.state;
  s.cloud.sh_degree = static_cast<int>(whole_number(in, "sh_degree", 3));
  s.iteration = static_cast<int>(whole_number(in, "iteration", 1e9));
  s.started_with = static_cast<size_t>(whole_number(in, "started_with", 1e9));
  s.seconds = in.number("/", "seconds");
  if (!(s.seconds >= 0)) throw in.complaint("/@seconds", "is " + std::to_string(s.seconds));

  const Shape positions = in.shape("/gaussians/position");
  const size_t n = positions.empty() ? 0 : positions[0];
  if (n == 0) throw in.complaint("/gaussians/position", "holds no Gaussian");
  size_t channels = 0;
  if (in.has("/gaussians/attribute")) {
    const Shape shape = in.shape("/gaussians/attribute");
    channels = shape.size() == 2 ? shape[1] : 0;
    if (channels < 1 || channels > kMostChannels)
      throw in.complaint("/gaussians/attribute", "has " + std::to_string(channels) + " channels");
  }
  visit_gaussian_arrays(s, [&](const std::string& name, auto& array) {
    const bool optional = name.starts_with("attribute") || name == "screen_gradient" || name == "times_seen";
    if (optional && !in.has("/gaussians/" + name)) return;
    const size_t width = width_of(name, s.cloud, channels);
    const std::vector<float> values = in.dataset<float>("/gaussians/" + name, {n, width});
    using Row = typename std::remove_reference_t<decltype(array)>::value_type;
    array.resize(values.size() * sizeof(float) / sizeof(Row));
    std::memcpy(static_cast<void*>(array.data()), values.data(), values.size() * sizeof(float));
  });
  visit_shared_arrays(s, [&](const char* name, std::vector<float>& values, size_t width) {
    values = in.dataset<float>(name, {kAny, width});
  });
  for (const auto& [name, values, moments] :
       {std::tuple{"/exposure", &s.exposure, &s.exposure_moments}, {"/shared", &s.shared, &s.shared_moments}}) {
    if (moments->first.size() != values->size() || moments->second.size() != values->size())
      throw in.complaint(name, "has moments of another length");
  }
  read_curve(in, s);
  checkpoint.start_json = in.text("/", "start");
  checkpoint.provenance_json = in.text("/", "provenance");
  return checkpoint;
}

}  // namespace pliant
