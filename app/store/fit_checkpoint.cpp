#include "app/store/fit_checkpoint.h"

#include <cstring>

#include "app/store/vectors.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

constexpr int32_t kFormat = 5;  // raised when a fit takes other steps, or keeps other things of them

/// Every array of doubles of a fit, but the modes' shapes.
template <class Fit, class Visit>
void visit_numbers(Fit& fit, Visit&& visit) {
  visit("young_sigma", fit.young_sigma);
  visit("parameters", fit.field);
  visit("modes_omega", fit.modes.omega);
  visit("modes_decay", fit.modes.decay);
  visit("search_log10_factor", fit.search.log10_factor);
  visit("search_unexplained", fit.search.unexplained);
  visit("gauss_newton_loss", fit.summary.loss);
  visit("candidate_factor", fit.candidate_factor);
  visit("candidate_rms", fit.candidate_rms);
}

/// Every single number, as a double.
template <class Fit, class Visit>
void visit_scalars(Fit& fit, Visit&& visit) {
  visit(fit.log10_factor);
  visit(fit.log10_sigma);
  visit(fit.damping_time);
  visit(fit.damping_time_low);
  visit(fit.damping_time_high);
  visit(fit.time);
  visit(fit.first_frame);
  visit(fit.last_frame);
  visit(fit.subframes);
  visit(fit.substeps);
  visit(fit.rms_search);
  visit(fit.rms);
  visit(fit.rms_rest);
  visit(fit.seconds);
  visit(fit.seconds_search);
  visit(fit.summary.converged);
  visit(fit.summary.evaluations);
  visit(fit.summary.rms);
  visit(fit.search.first_frame);
  visit(fit.search.periods);
  visit(fit.search.late);
  visit(fit.search.away);
  visit(fit.search.end);
}

template <class State, class Visit>
void visit_gradient(State& state, Visit&& visit) {
  visit("now_material", state.now.material);
  visit("now_velocity", state.now.velocity);
  visit("now_poisson", state.now.poisson);
  visit("best_poisson", state.best.poisson);
  visit("now_density", state.now.density);
  visit("best_density", state.best.density);
  visit("best_material", state.best.material);
  visit("best_velocity", state.best.velocity);
  visit("first_moment", state.first_moment);
  visit("second_moment", state.second_moment);
}

/// Rows of fixed-size matrices as one array of numbers.
template <class Matrix>
void write_rows(Hdf5Writer& out, const std::string& name, const std::vector<Matrix>& rows) {
  using Scalar = typename Matrix::Scalar;
  constexpr size_t kSize = Matrix::SizeAtCompileTime;
  std::vector<Scalar> flat(rows.size() * kSize);
  for (size_t i = 0; i < rows.size(); ++i) std::memcpy(flat.data() + i * kSize, rows[i].data(), kSize * sizeof(Scalar));
  out.dataset(name, flat.data(), {rows.size(), kSize});
}

template <class Matrix>
std::vector<Matrix> read_rows(const Hdf5Reader& in, const std::string& name, size_t count) {
  using Scalar = typename Matrix::Scalar;
  constexpr size_t kSize = Matrix::SizeAtCompileTime;
  const std::vector<Scalar> flat = in.dataset<Scalar>(name, {count, kSize});
  std::vector<Matrix> rows(flat.size() / kSize);
  for (size_t i = 0; i < rows.size(); ++i) std::memcpy(rows[i].data(), flat.data() + i * kSize, kSize * sizeof(Scalar));
  return rows;
}

void write_modes(Hdf5Writer& out, const std::string& group, const VibrationModes& modes) {
  for (size_t k = 0; k < modes.size(); ++k) {
    write_rows(out, group + "/shape_" + std::to_string(k), modes.shape[k]);
    write_rows(out, group + "/gradient_" + std::to_string(k), modes.gradient[k]);
  }
}

/// Shapes of `modes`, whose frequencies are known, at `n` particles.
void read_modes(const Hdf5Reader& in, const std::string& group, size_t n, VibrationModes& modes) {
  if (modes.decay.size() != modes.omega.size())
    throw in.complaint(group + "/modes_decay", "has another length than modes_omega");
  for (size_t m = 0; m < modes.size(); ++m) {
    modes.shape.push_back(read_rows<Vec3d>(in, group + "/shape_" + std::to_string(m), n));
    modes.gradient.push_back(read_rows<Mat3d>(in, group + "/gradient_" + std::to_string(m), n));
  }
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
  write_rows(out, group + "/x", fit.start.x);
  write_rows(out, group + "/v", fit.start.v);
  write_rows(out, group + "/C", fit.start.C);
  write_rows(out, group + "/F", fit.start.F);
  write_modes(out, group, fit.modes);
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
  fit.start.x = read_rows<Vec3f>(in, group + "/x", kAny);
  const size_t n = fit.start.x.size();
  fit.start.v = read_rows<Vec3f>(in, group + "/v", n);
  fit.start.C = read_rows<Mat3f>(in, group + "/C", n);
  fit.start.F = read_rows<Mat3f>(in, group + "/F", n);
  read_modes(in, group, n, fit.modes);
  return fit;
}

template <class State, class Visit>
void visit_refinement(State& state, Visit&& visit) {
  visit(state.damping);
  visit(state.raise);
  visit(state.linearised);
  visit(state.fresh);
  visit(state.iteration);
  visit(state.jacobians);
  visit(state.evaluations);
  visit(state.converged);
}

void write_refinement(Hdf5Writer& out, const std::string& group, const GaussNewtonState& state) {
  out.group(group);
  out.text(group, "stopped_by", state.stopped_by);
  std::vector<double> scalars;
  visit_refinement(state, [&](double value) { scalars.push_back(value); });
  out.dataset(group + "/scalars", scalars.data(), {scalars.size()});
  out.dataset(group + "/loss", state.loss.data(), {state.loss.size()});
  out.dataset(group + "/fixed", state.fixed.data(), {state.fixed.size()});
  const auto size = [](Eigen::Index n) { return static_cast<size_t>(n); };
  out.dataset(group + "/parameters", state.parameters.data(), {size(state.parameters.size())});
  out.dataset(group + "/residuals", state.residuals.data(), {size(state.residuals.size())});
  for (const auto& [name, J] : {std::pair("/jacobian", &state.jacobian), std::pair("/differences", &state.differences)})
    out.dataset(group + name, J->data(), {size(J->cols()), size(J->rows())});  // columns in a row
}

GaussNewtonState read_refinement(const Hdf5Reader& in, const std::string& group) {
  GaussNewtonState state;
  state.stopped_by = in.text(group, "stopped_by");
  size_t count = 0, k = 0;
  visit_refinement(state, [&](auto&) { ++count; });
  const std::vector<double> scalars = in.dataset<double>(group + "/scalars", {count});
  visit_refinement(state,
                   [&](auto& value) { value = static_cast<std::remove_reference_t<decltype(value)>>(scalars[k++]); });
  state.loss = in.dataset<double>(group + "/loss", {kAny});
  const auto vector = [&](const char* name) {
    const std::vector<double> values = in.dataset<double>(group + name, {kAny});
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  state.parameters = vector("/parameters");
  state.residuals = vector("/residuals");
  const Eigen::Index p = state.parameters.size(), r = state.residuals.size();
  state.fixed = in.dataset<uint8_t>(group + "/fixed", {static_cast<size_t>(p)});
  for (const auto& [name, J] :
       {std::pair("/jacobian", &state.jacobian), std::pair("/differences", &state.differences)}) {
    const std::vector<double> values = in.dataset<double>(group + name, {kAny, kAny});
    if (values.empty()) continue;
    if (static_cast<Eigen::Index>(values.size()) != p * r)
      throw in.complaint(group + name, "is not [parameters, residuals]");
    *J = Eigen::Map<const Eigen::MatrixXd>(values.data(), r, p);
  }
  if (state.loss.empty()) throw in.complaint(group + "/loss", "is empty");
  return state;
}

/// Those that have begun.
void write_refinements(Hdf5Writer& out, const std::string& name, const std::vector<GaussNewtonState>& states) {
  for (size_t k = 0; k < states.size() && !states[k].loss.empty(); ++k)
    write_refinement(out, name + std::to_string(k), states[k]);
}

std::vector<GaussNewtonState> read_refinements(const Hdf5Reader& in, const std::string& name) {
  std::vector<GaussNewtonState> states;
  for (size_t k = 0; in.has(name + std::to_string(k)); ++k)
    states.push_back(read_refinement(in, name + std::to_string(k)));
  return states;
}

void write_vibration(Hdf5Writer& out, const VibrationFitState& state) {
  if (state.modes) {
    out.group("/modes");
    out.dataset("/modes/modes_omega", state.modes->omega.data(), {state.modes->omega.size()});
    out.dataset("/modes/modes_decay", state.modes->decay.data(), {state.modes->decay.size()});
    write_modes(out, "/modes", *state.modes);
  }
  write_refinements(out, "/refinement_", state.refinements);
}

VibrationFitState read_vibration(const Hdf5Reader& in) {
  VibrationFitState state;
  if (in.has("/modes")) {
    VibrationModes& modes = state.modes.emplace();
    modes.omega = in.dataset<double>("/modes/modes_omega", {kAny});
    modes.decay = in.dataset<double>("/modes/modes_decay", {kAny});
    read_modes(in, "/modes", kAny, modes);
  }
  state.refinements = read_refinements(in, "/refinement_");
  return state;
}

constexpr size_t kColumns = 6;  // of a row of iterations

void write_gradient(Hdf5Writer& out, const std::string& group, const GradientFitState& g) {
  out.group(group);
  visit_gradient(g, [&](const char* name, const std::vector<double>& values) {
    out.dataset(group + "/" + name, values.data(), {values.size()});
  });
  const double scalars[7] = {g.now.damping,      g.best.damping,  g.best_loss, double(g.without_better),
                             double(g.finished), double(g.steps), g.rate};
  out.dataset(group + "/scalars", scalars, {7});
  std::vector<double> rows;
  for (const GradientFitRow& r : g.rows)
    rows.insert(rows.end(),
                {double(r.frames), r.loss, r.rollout_seconds, r.frames_seconds, r.reverse_seconds, r.field_seconds});
  out.dataset(group + "/rows", rows.data(), {g.rows.size(), kColumns});
}

GradientFitState read_gradient(const Hdf5Reader& in, const std::string& group) {
  GradientFitState g;
  visit_gradient(g, [&](const char* name, std::vector<double>& values) {
    values = in.dataset<double>(group + "/" + name, {kAny});
  });
  const std::vector<double> scalars = in.dataset<double>(group + "/scalars", {7});
  g.now.damping = scalars[0];
  g.best.damping = scalars[1];
  g.best_loss = scalars[2];
  g.without_better = static_cast<int>(scalars[3]);
  g.finished = scalars[4] != 0;
  g.steps = static_cast<long>(scalars[5]);
  g.rate = scalars[6];
  const std::vector<double> rows = in.dataset<double>(group + "/rows", {kAny, kColumns});
  for (size_t i = 0; i < rows.size(); i += kColumns)
    g.rows.push_back({static_cast<int>(rows[i]), rows[i + 1], rows[i + 2], rows[i + 3], rows[i + 4], rows[i + 5]});
  if (g.first_moment.size() != g.second_moment.size())
    throw in.complaint(group + "/second_moment", "has another length than first_moment");
  return g;
}

void write_markers(Hdf5Writer& out, const MarkerFitState& state) {
  out.group("/markers");
  std::vector<double> rows = {double(state.searched), double(state.best)};
  for (const MarkerFitState::Simulated& one : state.simulated) rows.insert(rows.end(), {double(one.step), one.loss});
  out.dataset("/markers/search", rows.data(), {rows.size() / 2, 2});
  if (!state.refinement.loss.empty()) write_refinement(out, "/markers/refinement", state.refinement);
}

MarkerFitState read_markers(const Hdf5Reader& in) {
  MarkerFitState state;
  const std::vector<double> rows = in.dataset<double>("/markers/search", {kAny, 2});
  if (rows.empty()) throw in.complaint("/markers/search", "is empty");
  state.searched = rows[0] != 0;
  state.best = static_cast<int>(rows[1]);
  for (size_t i = 2; i < rows.size(); i += 2) state.simulated.push_back({static_cast<int>(rows[i]), rows[i + 1]});
  if (in.has("/markers/refinement")) state.refinement = read_refinement(in, "/markers/refinement");
  return state;
}

}  // namespace

void write_fit_checkpoint(const fs::path& file, const FitCheckpoint& checkpoint) {
  write_hdf5(file, [&](Hdf5Writer& out) {
    if (checkpoint.homogeneous) write_fit(out, "/homogeneous", *checkpoint.homogeneous);
    if (checkpoint.field) write_fit(out, "/field", *checkpoint.field);
    write_vibration(out, checkpoint.vibration);
    write_gradient(out, "/velocity", checkpoint.velocity);
    write_gradient(out, "/gradient", checkpoint.gradient);
    write_refinements(out, "/posterior_", checkpoint.posterior);
    write_markers(out, checkpoint.markers);
    out.dataset("/format", &kFormat, {1});
    out.text("/", "provenance", checkpoint.provenance_json);
  });
}

std::string read_fit_checkpoint_provenance(const fs::path& file) {
  const Hdf5Reader in(file);
  if (!in.has("/format") || in.dataset<int32_t>("/format", {1})[0] != kFormat) return "";
  return in.text("/", "provenance");
}

FitCheckpoint read_fit_checkpoint(const fs::path& file) {
  const Hdf5Reader in(file);
  FitCheckpoint checkpoint;
  checkpoint.provenance_json = in.text("/", "provenance");
  if (in.has("/homogeneous")) checkpoint.homogeneous = read_fit(in, "/homogeneous");
  if (in.has("/field")) checkpoint.field = read_fit(in, "/field");
  checkpoint.vibration = read_vibration(in);
  checkpoint.velocity = read_gradient(in, "/velocity");
  checkpoint.gradient = read_gradient(in, "/gradient");
  checkpoint.posterior = read_refinements(in, "/posterior_");
  if (in.has("/markers")) checkpoint.markers = read_markers(in);
  return checkpoint;
}

}  // namespace pliant
