// Mechanics of whole bodies, law by law.  Prints one JSON object per figure, with the bar it is held to.
//   laws_study [waves] [bulk] [slope] [relaxation] [snow] [metal] [foam] [plasticine] [fluid] [energy]    none = all
// grid=eulerian|lagrangian: of waves and dents; default: the solver's own choice.

#include <chrono>
#include <cstdio>
#include <string>

#include "tests/physics/simulate/laws_bodies.h"
#include "tests/studies/study_grid.h"

namespace pliant {
namespace {

using namespace pliant::fixture;

bool all_good = true;
GridKind grid = GridKind::kAutomatic;

void report(const char* study, const std::string& which, double measured, double expected, const char* bar, bool good) {
  static auto last = std::chrono::steady_clock::now();
  const auto now = std::chrono::steady_clock::now();
  std::printf(
      "{\"study\": \"%s\", \"case\": \"%s\", \"measured\": %.6g, \"expected\": %.6g, \"bar\": \"%s\", "
      "\"good\": %s, \"seconds\": %.1f}\n",
      study, which.c_str(), measured, expected, bar, good ? "true" : "false",
      std::chrono::duration<double>(now - last).count());
  std::fflush(stdout);
  last = now;
  all_good &= good;
}

Substance substance(Law law) {
  Substance s;
  s.material.law = law;
  s.material.yield_stress = 1e4;
  s.material.plastic_viscosity = 50;
  s.material.hardening = 0;
  s.material.branch_shear = 3e4;
  s.material.branch_lambda = 2e4;
  s.material.branch_viscosity = 1e6;
  return s;
}

constexpr Law kLaws[] = {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky,     Law::kMetal, Law::kSand,
                         Law::kSnow,           Law::kFoam,       Law::kPlasticine, Law::kFluid, Law::kViscoelastic};

void waves() {
  for (const Law law : kLaws) {
    Substance s = substance(law);
    s.grid = grid;
    const Lame<double> l = s.moduli();
    double modulus = l.lambda + 2 * l.mu;
    if (law == Law::kFluid) modulus = s.bulk();
    if (law == Law::kViscoelastic) modulus += s.material.branch_lambda + 2 * s.material.branch_shear;
    const double expected = std::sqrt(modulus / s.density), measured = p_wave_speed(s, expected);
    report("p_wave_speed", law_name(law), measured, expected, "2 %", std::abs(measured / expected - 1) <= 0.02);
  }
}

void bulk() {
  for (const Law law : kLaws) {
    const Substance s = substance(law);
    double expected = s.bulk();
    if (law == Law::kViscoelastic) expected += s.material.branch_lambda + 2 * s.material.branch_shear / 3;
    const double measured = measured_bulk_modulus(s);
    report("bulk_modulus", law_name(law), measured, expected, "2 %", std::abs(measured / expected - 1) <= 0.02);
  }
}

void slope() {
  for (const double phi : {25.0, 30.0, 40.0}) {
    const double critical = critical_slope(phi);
    for (const double off : {-2.0, 2.0}) {
      const double run = sand_slope_run(phi, critical + off, 8, 2.0);
      const std::string which =
          "phi " + std::to_string(static_cast<int>(phi)) + " slope " + std::to_string(critical + off).substr(0, 5);
      report("sand_slope_cells_in_2_s", which, run, 1, off < 0 ? "holds: < 1" : "flows: > 1",
             off < 0 ? run < 1 : run > 1);
    }
  }
}

void relaxation() {
  Substance visco = substance(Law::kViscoelastic);
  visco.material.branch_viscosity = 2 * visco.material.branch_shear * 0.05;
  double measured = branch_relaxation_time(visco);
  report("relaxation_time", "viscoelastic", measured, 0.05, "5 %", std::abs(measured / 0.05 - 1) <= 0.05);

  Substance foam = substance(Law::kFoam);
  foam.material.yield_stress = 1e3;
  foam.material.plastic_viscosity = 2 * foam.moduli().mu * 0.05;
  measured = foam_relaxation_time(foam);
  report("relaxation_time", "foam", measured, 0.05, "5 %", std::abs(measured / 0.05 - 1) <= 0.05);

  Substance fluid = substance(Law::kFluid);
  fluid.material.bulk_modulus = 1e5;
  const double dx = 0.01;
  const int cells = 12;
  for (const double viscosity : {5.0, 20.0}) {
    fluid.material.dynamic_viscosity = viscosity;
    const double expected = fluid.density * std::pow(cells * dx / M_PI, 2) / viscosity;
    measured = shear_flow_decay_time(fluid, dx, cells);
    report("shear_flow_decay_time", "fluid of " + std::to_string(viscosity).substr(0, 4) + " Pa s", measured, expected,
           "5 %", std::abs(measured / expected - 1) <= 0.05);
  }
}

void snow() {
  Substance s;
  s.material.law = Law::kSnow;
  s.young = 1.4e5;
  s.poisson = 0.2;
  s.density = 400;
  for (const int cells : {10, 14}) {
    const auto [before, after] = rest_on_ground(ball_of(s, 0.2, cells), 2.0);
    const double growth = after.width / before.width - 1;
    report("snow_lump_growth", std::to_string(cells) + " cells", growth, 0, "< 0.1", growth < 0.1);
    report("snow_lump_height", std::to_string(cells) + " cells", after.height / before.height, 1, "> 0.9",
           after.height > 0.9 * before.height);
  }
}

void metal() {
  Substance s;
  s.material.law = Law::kMetal;
  s.young = 1e7;
  s.density = 2000;
  s.material.yield_stress = 1e5;
  for (const double hardening : {0.0, 5e5}) {
    s.material.hardening = hardening;
    const Dent d = dent(s, 5e5, 0.05, 0.01);
    report("metal_dent_kept", "hardening " + std::to_string(static_cast<int>(hardening)), d.left / d.loaded, 1,
           ">= 0.5", d.left >= 0.5 * d.loaded && d.loaded > 0.002);
  }
  s.material.law = Law::kHencky;
  s.grid = grid;
  const Dent d = dent(s, 5e5, 0.05, 0.01);
  report("elastic_dent_kept", "hencky", d.left / d.loaded, 0, "< 0.1", std::abs(d.left) < 0.1 * d.loaded);
}

void foam() {
  Substance s;
  s.material.law = Law::kFoam;
  s.young = 2e5;
  s.density = 1000;
  const double height = 0.12, weight = s.density * 9.81 * height;
  s.material.plastic_viscosity = 100;
  const Bodies shape = block_of(s, Vec3d(0.08, 0.08, height), 0.01, 1.0);
  for (const double part : {2.0, 0.1}) {
    Bodies p = shape;
    p.materials[0].yield_stress = part * weight;
    const auto [before, after] = rest_on_ground(p, 1.0);
    const double left = after.height / before.height;
    report("foam_column_height", "yield stress / weight " + std::to_string(part).substr(0, 3), left, 1,
           part > 1 ? "stands: > 0.95" : "flows: < 0.7", part > 1 ? left > 0.95 : left < 0.7);
  }
}

void plasticine() {
  Substance s;
  s.material.law = Law::kPlasticine;
  s.young = 2e5;
  s.density = 1000;
  const double height = 0.12, weight = s.density * 9.81 * height;
  s.material.yield_stress = 0.7 * weight;
  double left[2];
  for (const int soft : {0, 1}) {
    s.material.hardening = soft ? -2 * s.material.yield_stress : 0;
    const auto [before, after] = rest_on_ground(block_of(s, Vec3d(0.06, 0.06, height), 0.01, 1.0), 1.0);
    left[soft] = after.height / before.height;
  }
  report("plasticine_column_height", "without softening", left[0], 1, "> 0.6", left[0] > 0.6);
  report("plasticine_column_height", "with softening", left[1], 0, "flows: < half of that", left[1] < 0.5 * left[0]);
}

void fluid() {
  const WaterColumn w = water_column(12, 2.0, true);
  report("water_pressure_slope", "relative to density g", w.pressure_slope, 1, "5 %",
         std::abs(w.pressure_slope - 1) <= 0.05);
  report("water_mean_pressure", "relative to half the depth", w.mean_pressure, 1, "5 %",
         std::abs(w.mean_pressure - 1) <= 0.05);
  report("water_height_change", "2 s", w.height_change, 0, "2 %", std::abs(w.height_change) <= 0.02);
}

void energy() {
  for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky}) {
    const double growth = energy_growth(substance(law), 5, 10000, 0.4);
    report("energy_growth_10000_steps", law_name(law), growth, 0, "<= 0.001", growth <= 1e-3);
  }
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  grid = fixture::take_grid(argc, argv);
  const std::pair<const char*, void (*)()> studies[] = {
      {"waves", waves}, {"bulk", bulk}, {"slope", slope},           {"relaxation", relaxation}, {"snow", snow},
      {"metal", metal}, {"foam", foam}, {"plasticine", plasticine}, {"fluid", fluid},           {"energy", energy}};
  for (const auto& [name, run] : studies) {
    bool wanted = argc < 2;
    for (int a = 1; a < argc; ++a) wanted |= name == std::string(argv[a]);
    if (wanted) run();
  }
  return all_good ? 0 : 1;
}
