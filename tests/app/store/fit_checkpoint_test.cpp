#include "app/store/fit_checkpoint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/store/hdf5_file.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

FitCheckpoint made() {
  FitCheckpoint c;
  VibrationFit fit;
  fit.log10_factor = 0.1 + 1e-17;
  fit.damping_time = 1 / 3.0;
  fit.first_frame = 7;
  fit.last_frame = 40;
  fit.subframes = 4;
  fit.substeps = 33;
  fit.search.log10_factor = {-1, 0, 1};
  fit.search.unexplained = {0.5, 0.1, 0.7};
  fit.search.late = true;
  fit.search.end = -1;
  fit.summary.loss = {4, 2};
  fit.summary.converged = true;
  fit.summary.stopped_by = "small change";
  fit.seconds_search = 2.5;
  fit.modes.omega = {3, 5};
  fit.modes.decay = {0.1, 0.2};
  Random random(1, 1);
  for (int i = 0; i < 4; ++i) {
    fit.start.x.push_back(Vec3f::Constant(static_cast<float>(random.uniform())));
    fit.start.v.push_back(Vec3f(1, 2, static_cast<float>(i)));
    fit.start.C.push_back(Mat3f::Identity() * i);
    fit.start.F.push_back(Mat3f::Constant(static_cast<float>(random.normal())));
  }
  for (int k = 0; k < 2; ++k) {
    fit.modes.shape.push_back(std::vector<Vec3d>(4, Vec3d(k, 1, 2)));
    fit.modes.gradient.push_back(std::vector<Mat3d>(4, Mat3d::Constant(k + 0.5)));
  }
  c.homogeneous = fit;
  c.vibration.modes = fit.modes;
  GaussNewtonState step;
  step.parameters = Eigen::VectorXd::Constant(2, 1 / 3.0);
  step.residuals = Eigen::VectorXd::LinSpaced(3, 0, 1);
  step.jacobian = Eigen::MatrixXd::Random(3, 2);
  step.fixed = {0, 1};
  step.damping = 1e-7;
  step.linearised = true;
  step.iteration = 4;
  step.jacobians = 2;
  step.evaluations = 21;
  step.loss = {5, 4, 3};
  c.vibration.refinements = {step, step};
  c.vibration.refinements[0].stopped_by = "small change";
  c.vibration.refinements[1].jacobian.resize(0, 0);
  fit.field = {0.5, -1.25};
  fit.candidate_factor = {0.5, 1};
  fit.candidate_rms = {2, 3};
  c.field = fit;
  c.gradient.now = {{1, 2, 3}, {4, 5, 6}, 0.25};
  c.gradient.best = {{1, 1, 1}, {0, 0, 0}, -0.5};
  c.gradient.first_moment.assign(7, 0.1);
  c.gradient.second_moment.assign(7, 0.2);
  c.gradient.best_loss = 0.125;
  c.gradient.without_better = 3;
  c.gradient.steps = 5;
  c.gradient.rate = 0.25;
  c.gradient.rows = {{6, 0.5, 1, 2, 3, 4}, {8, 0.25, 1, 2, 3, 4}};
  c.velocity.now.velocity = {7, 8};
  c.velocity.rows = {{3, 0.75, 1, 2, 3, 4}};
  c.velocity.finished = true;
  c.markers.simulated = {{3, 0.25}, {-2, INFINITY}};
  c.markers.searched = true;
  c.markers.best = 3;
  c.markers.refinement = step;
  c.posterior = {step};
  c.provenance_json = "{\"a\":1}";
  return c;
}

TEST(FitCheckpoint, ComesBackBitForBit) {
  const TemporaryFolder folder;
  const FitCheckpoint a = made();
  write_fit_checkpoint(folder / "c.h5", a);
  const FitCheckpoint b = read_fit_checkpoint(folder / "c.h5");
  ASSERT_TRUE(b.homogeneous);
  EXPECT_EQ(b.homogeneous->log10_factor, a.homogeneous->log10_factor);
  EXPECT_EQ(b.homogeneous->substeps, 33);
  EXPECT_EQ(b.homogeneous->start.F, a.homogeneous->start.F);
  EXPECT_EQ(b.homogeneous->start.x, a.homogeneous->start.x);
  EXPECT_EQ(b.homogeneous->modes.shape, a.homogeneous->modes.shape);
  EXPECT_EQ(b.homogeneous->modes.gradient, a.homogeneous->modes.gradient);
  EXPECT_EQ(b.homogeneous->search.unexplained, a.homogeneous->search.unexplained);
  EXPECT_TRUE(b.homogeneous->search.late && !b.homogeneous->search.away);
  EXPECT_EQ(b.homogeneous->search.end, -1);
  EXPECT_TRUE(b.homogeneous->summary.converged);
  EXPECT_EQ(b.homogeneous->summary.stopped_by, "small change");
  EXPECT_EQ(b.homogeneous->summary.loss, a.homogeneous->summary.loss);
  EXPECT_EQ(b.homogeneous->seconds_search, 2.5);
  ASSERT_TRUE(b.field);
  EXPECT_EQ(b.field->field, a.field->field);
  EXPECT_EQ(b.field->start.v, a.field->start.v);
  EXPECT_EQ(b.field->candidate_rms, a.field->candidate_rms);
  ASSERT_TRUE(b.vibration.modes);
  EXPECT_EQ(b.vibration.modes->gradient, a.vibration.modes->gradient);
  ASSERT_EQ(b.vibration.refinements.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    const GaussNewtonState &was = a.vibration.refinements[k], &is = b.vibration.refinements[k];
    EXPECT_EQ(is.parameters, was.parameters);
    EXPECT_EQ(is.residuals, was.residuals);
    EXPECT_EQ(is.jacobian, was.jacobian);
    EXPECT_EQ(is.fixed, was.fixed);
    EXPECT_EQ(is.damping, was.damping);
    EXPECT_TRUE(is.linearised && !is.fresh);
    EXPECT_EQ(is.iteration, 4);
    EXPECT_EQ(is.jacobians, 2);
    EXPECT_EQ(is.evaluations, 21);
    EXPECT_EQ(is.loss, was.loss);
    EXPECT_EQ(is.stopped_by, was.stopped_by);
  }
  EXPECT_EQ(b.gradient.now.material, a.gradient.now.material);
  EXPECT_EQ(b.gradient.now.damping, a.gradient.now.damping);
  EXPECT_EQ(b.gradient.best.velocity, a.gradient.best.velocity);
  EXPECT_EQ(b.gradient.second_moment, a.gradient.second_moment);
  EXPECT_EQ(b.gradient.steps, 5);
  EXPECT_EQ(b.gradient.rate, 0.25);
  ASSERT_EQ(b.gradient.rows.size(), 2u);
  EXPECT_EQ(b.gradient.rows[1].loss, 0.25);
  EXPECT_EQ(b.velocity.now.velocity, a.velocity.now.velocity);
  EXPECT_EQ(b.velocity.rows.size(), 1u);
  EXPECT_TRUE(b.velocity.finished && !b.gradient.finished);
  ASSERT_EQ(b.posterior.size(), 1u);
  EXPECT_EQ(b.posterior[0].jacobian, a.posterior[0].jacobian);
  ASSERT_EQ(b.markers.simulated.size(), 2u);
  EXPECT_EQ(b.markers.simulated[0].step, 3);
  EXPECT_EQ(b.markers.simulated[1].loss, INFINITY);
  EXPECT_TRUE(b.markers.searched && b.markers.best == 3);
  EXPECT_EQ(b.markers.refinement.parameters, a.markers.refinement.parameters);
  EXPECT_EQ(b.provenance_json, a.provenance_json);
}

TEST(FitCheckpoint, ThatOfAnotherVersionIsOfNoFit) {
  const TemporaryFolder folder;
  write_fit_checkpoint(folder / "c.h5", made());
  EXPECT_EQ(read_fit_checkpoint_provenance(folder / "c.h5"), made().provenance_json);
  const int32_t other = 1;
  write_hdf5(folder / "other.h5", [&](Hdf5Writer& out) {
    out.dataset("/format", &other, {1});
    out.text("/", "provenance", "{}");
  });
  write_hdf5(folder / "none.h5", [](Hdf5Writer& out) { out.text("/", "provenance", "{}"); });
  EXPECT_EQ(read_fit_checkpoint_provenance(folder / "other.h5"), "");
  EXPECT_EQ(read_fit_checkpoint_provenance(folder / "none.h5"), "");
}

TEST(FitCheckpoint, WhatIsCutOffOrLacksADatasetIsRefusedByName) {
  const TemporaryFolder folder;
  write_fit_checkpoint(folder / "c.h5", made());
  const std::string bytes = read_text(folder / "c.h5");
  write_text(folder / "cut.h5", bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(read_fit_checkpoint(folder / "cut.h5"), Error);
  write_hdf5(folder / "bare.h5", [](Hdf5Writer& out) {
    out.group("/gradient");
    out.group("/velocity");
    out.text("/", "provenance", "{}");
  });
  try {
    read_fit_checkpoint(folder / "bare.h5");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/velocity/now_material"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace pliant
