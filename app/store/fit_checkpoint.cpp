#include "app/store/fit_checkpoint.h"

#include <cstring>

#include "app/store/vectors.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

/// Every array of doubles of a fit, but the modes' shapes.
template <class Fit, class Visit>
void visit_numbers(Fit& fit, Visit&& visit) {
  visit("young_sigma", fit.young_sigma), visit("parameters", fit.field), visit("modes_omega", fit.modes.omega), visit("modes_decay", fit.modes.decay);
  visit("search_log10_factor", fit.search.log10_factor), visit("search_unexplained", fit.search.unexplained);
  visit("gauss_newton_loss", fit.summary.loss);
}

/// Every single number, as a double.
template <class Fit, class Visit>
void visit_scalars(Fit& fit, Visit&& visit) {
  visit(fit.log10_factor), visit(fit.log10_sigma), visit(fit.damping_time), visit(fit.damping_time_low), visit(fit.damping_time_high);
  visit(fit.time), visit(fit.first_frame), visit(fit.last_frame), visit(fit.subframes), visit(fit.substeps);
  visit(fit.rms_search), visit(fit.rms), visit(fit.rms_rest), visit(fit.seconds), visit(fit.seconds_search), visit(fit.summary.converged), visit(fit.search.first_frame), visit(fit.search.periods);
}

template <class State, class Visit>
void visit_gradient(State& state, Visit&& visit) {
  visit("now_material", state.now.material), visit("now_velocity", state.now.velocity);
  visit("now_poisson", state.now.poisson), visit("best_poisson", state.best.poisson);
  visit("best_material", state.best.material), visit("best_velocity", state.best.velocity);
  visit("first_moment", state.first_moment), visit("second_moment", state.second_moment);
}

/// Rows of fixed-size matrices as one array of numbers.
template <class Matrix>
void write_matrices(Hdf5Writer& out, const std::string& name, const std::vector<Matrix>& rows) {
  using Scalar = typename Matrix::Scalar;
  constexpr size_t kSize = Matrix::SizeAtCompileTime;
  std::vector<Scalar> flat(rows.size() * kSize);
  for (size_t i = 0; i < rows.size(); ++i) std::memcpy(flat.data() + i * kSize, rows[i].data(), kSize * sizeof(Scalar));
  out.dataset(name, flat.data(), {rows.size(), kSize});
}

template <class Matrix>
std::vector<Matrix> read_matrices(const Hdf5Reader& in, const std::string& name, size_t count) {
  using Scalar = typename Matrix::Scalar;
  constexpr size_t kSize = Matrix::SizeAtCompileTime;
  const std::vector<Scalar> flat = in.dataset<Scalar>(name, {count, kSize});
  std::vector<Matrix> rows(flat.size() / kSize);
  for (size_t i = 0; i < rows.size(); ++i) std::memcpy(rows[i].data(), flat.data() + i * kSize, kSize * sizeof(Scalar));
  return rows;
}

void write_fit(Hdf5Writer& out, const std::string& group, const VibrationFit& fit) {
  out.group(group);
  out.text(group, "stopped_by", fit.summary.stopped_by);
  std::vector<double> scalars;
  visit_scalars(fit, [&](double value) { scalars.push_back(value); });
  out.dataset(group + "/scalars", scalars.data(), {scalars.size()});
  visit_numbers(fit, [&](const char* name, const std::vector<double>& values) {
    out.dataset(group + "/" + name, values.data(), {values.size()});
  });
  write_matrices(out, group + "/x", fit.start.x), write_matrices(out, group + "/v", fit.start.v);
  write_matrices(out, group + "/C", fit.start.C), write_matrices(out, group + "/F", fit.start.F);
  for (size_t k = 0; k < fit.modes.size(); ++k) {
    write_matrices(out, group + "/shape_" + std::to_string(k), fit.modes.shape[k]);
    write_matrices(out, group + "/gradient_" + std::to_string(k), fit.modes.gradient[k]);
  }
}

VibrationFit read_fit(const Hdf5Reader& in, const std::string& group) {
  VibrationFit fit;
  size_t count = 0;
  visit_scalars(fit, [&](auto&) { ++count; });
  const std::vector<double> scalars = in.dataset<double>(group + "/scalars", {count});
  size_t k = 0;
  visit_scalars(fit, [&](auto& value) { value = static_cast<std::remove_reference_t<decltype(value)>>(scalars[k++]); });
  fit.summary.stopped_by = in.text(group, "stopped_by");
  visit_numbers(fit, [&](const char* name, std::vector<double>& values) {
    values = in.dataset<double>(group + "/" + name, {kAny});
  });
  fit.start.x = read_matrices<Vec3f>(in, group + "/x", kAny);
  const size_t n = fit.start.x.size();
  fit.start.v = read_matrices<Vec3f>(in, group + "/v", n);
  fit.start.C = read_matrices<Mat3f>(in, group + "/C", n), fit.start.F = read_matrices<Mat3f>(in, group + "/F", n);
  for (size_t m = 0; m < fit.modes.omega.size(); ++m) {
    fit.modes.shape.push_back(read_matrices<Vec3d>(in, group + "/shape_" + std::to_string(m), n));
    fit.modes.gradient.push_back(read_matrices<Mat3d>(in, group + "/gradient_" + std::to_string(m), n));
  }
  if (fit.modes.decay.size() != fit.modes.omega.size()) throw in.complaint(group + "/modes_decay", "has another length than modes_omega");
  return fit;
}

constexpr size_t kColumns = 6;  // of a row of iterations

}  // namespace

void write_fit_checkpoint(const fs::path& file, const FitCheckpoint& checkpoint) {
  write_hdf5(file, [&](Hdf5Writer& out) {
    if (checkpoint.homogeneous) write_fit(out, "/homogeneous", *checkpoint.homogeneous);
    if (checkpoint.field) write_fit(out, "/field", *checkpoint.field);
    const GradientFitState& g = checkpoint.gradient;
    out.group("/gradient");
    visit_gradient(g, [&](const char* name, const std::vector<double>& values) {
      out.dataset(std::string("/gradient/") + name, values.data(), {values.size()});
    });
    const double scalars[7] = {g.now.damping, g.best.damping, g.best_loss, double(g.without_better), double(g.finished), double(g.steps), g.rate};
    out.dataset("/gradient/scalars", scalars, {7});
    std::vector<double> rows;
    for (const GradientFitRow& r : g.rows)
      rows.insert(rows.end(), {double(r.frames), r.loss, r.rollout_seconds, r.frames_seconds, r.reverse_seconds, r.field_seconds});
    out.dataset("/gradient/rows", rows.data(), {g.rows.size(), kColumns});
    out.text("/", "provenance", checkpoint.provenance_json);
  });
}

std::string read_fit_checkpoint_provenance(const fs::path& file) { return Hdf5Reader(file).text("/", "provenance"); }

FitCheckpoint read_fit_checkpoint(const fs::path& file) {
  const Hdf5Reader in(file);
  FitCheckpoint checkpoint;
  checkpoint.provenance_json = in.text("/", "provenance");
  if (in.has("/homogeneous")) checkpoint.homogeneous = read_fit(in, "/homogeneous");
  if (in.has("/field")) checkpoint.field = read_fit(in, "/field");
  GradientFitState& g = checkpoint.gradient;
  visit_gradient(g, [&](const char* name, std::vector<double>& values) { values = in.dataset<double>(std::string("/gradient/") + name, {kAny}); });
  const std::vector<double> scalars = in.dataset<double>("/gradient/scalars", {7});
  g.now.damping = scalars[0], g.best.damping = scalars[1], g.best_loss = scalars[2];
  g.without_better = static_cast<int>(scalars[3]), g.finished = scalars[4] != 0;
  g.steps = static_cast<long>(scalars[5]), g.rate = scalars[6];
  const std::vector<double> rows = in.dataset<double>("/gradient/rows", {kAny, kColumns});
  for (size_t i = 0; i < rows.size(); i += kColumns)
    g.rows.push_back({static_cast<int>(rows[i]), rows[i + 1], rows[i + 2], rows[i + 3], rows[i + 4], rows[i + 5]});
  if (g.first_moment.size() != g.second_moment.size()) throw in.complaint("/gradient/second_moment", "has another length than first_moment");
  return checkpoint;
}

}  // namespace pliant
