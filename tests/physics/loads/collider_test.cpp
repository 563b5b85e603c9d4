// Surfaces, contact at single nodes, and bodies that meet colliders.

#include "physics/loads/collider.h"

#include <gtest/gtest.h>

#include "gaussians/base/linear_algebra.h"
#include "physics/mpm/node_conditions.h"
#include "physics/simulate/simulate.h"
#include "tests/check_adjoint.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

using State = BasicSimulationState<double>;
constexpr double kGravity = 9.81, kPi = 3.14159265358979324;

SignedDistanceGrid sphere_grid(double radius, double spacing, int nodes) {
  SignedDistanceGrid grid;
  grid.spacing = spacing;
  grid.size = {nodes, nodes, nodes};
  grid.origin = Vec3d::Constant(-0.5 * spacing * (nodes - 1));
  grid.value.resize(static_cast<size_t>(nodes) * nodes * nodes);
  for (int i = 0; i < nodes; ++i)
    for (int j = 0; j < nodes; ++j)
      for (int k = 0; k < nodes; ++k) grid.at(i, j, k) = static_cast<float>(grid.position(i, j, k).norm() - radius);
  return grid;
}

TEST(Collider, NormalsAreTheGradientsOfTheDistances) {
  Collider cylinder, box, container;
  cylinder.shape = Region::cylinder(Vec3d(0.1, 0.2, 0), Vec3d(0.5, -0.3, 0.4), 0.3);
  box.shape = Region::box(Vec3d(-0.3, -0.2, -0.1), Vec3d(0.4, 0.2, 0.3));
  container.shape = Region::sphere(Vec3d(0.1, 0, 0), 0.4);
  container.container = true;
  for (Collider collider : {cylinder, box, container}) {
    collider.angular_velocity = Vec3d(0.3, 2, -1);
    collider.move(Vec3d(0.1, 0.1, 0), Vec3d(0.05, 0, 0.02), 0.7);
    int checked = 0;
    for (int i = 0; i < 400; ++i) {
      Random random(5, i);
      const Vec3d x(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      const auto at = collider.surface(x);
      EXPECT_NEAR(at.normal.norm(), 1, 1e-12);
      Vec3d gradient;
      for (int a = 0; a < 3; ++a)
        gradient[a] = (collider.surface(x + 1e-6 * Vec3d::Unit(a)).distance -
                       collider.surface(x - 1e-6 * Vec3d::Unit(a)).distance) /
                      2e-6;
      if (std::abs(gradient.norm() - 1) > 1e-4) continue;  // astride an edge of the distance field
      ++checked;
      EXPECT_LT((at.normal - gradient).norm(), 1e-5) << x.transpose();
      // A step along the normal by the distance ends on the surface, seen from outside.
      const double way = collider.container ? 0 : std::max(at.distance, 0.0);
      EXPECT_NEAR(collider.surface(x - way * at.normal).distance, way > 0 ? 0 : at.distance, 1e-9);
    }
    EXPECT_GT(checked, 300);
  }
}

// L = a . normal + b . velocity of the surface; near edges of the distance field differences say nothing.
TEST(Collider, TheAdjointOfTheSurfaceAgreesWithDifferences) {
  std::vector<Collider> colliders(6);
  colliders[0].shape = Region::sphere(Vec3d(0.1, 0, 0), 0.4);
  colliders[1].shape = Region::box(Vec3d(-0.3, -0.2, -0.1), Vec3d(0.4, 0.2, 0.3));
  colliders[2].shape = Region::cylinder(Vec3d(0.1, 0.2, 0), Vec3d(0.5, -0.3, 0.4), 0.3);
  colliders[3].shape = Region::half_space(Vec3d(0, 0.1, 0), Vec3d(1, 2, 3));
  colliders[4] = colliders[2];
  colliders[4].container = true;
  colliders[5].grid = std::make_shared<SignedDistanceGrid>(sphere_grid(0.3, 0.2, 6));
  const Vec3d a(0.7, -1.1, 0.4), b(0.2, 0.5, -0.9);
  for (Collider& collider : colliders) {
    collider.angular_velocity = Vec3d(0.3, 2, -1);
    collider.move(Vec3d(0.1, 0.1, 0), Vec3d(0.05, 0, 0.02), 0.7);
    int checked = 0;
    for (int i = 0; i < 400; ++i) {
      Random random(15, i);
      const Vec3d x(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      const auto value = [&](const Vec3d& at) {
        return a.dot(collider.surface(at).normal) + b.dot(collider.velocity_at(at));
      };
      const auto slope = [&](double h) {
        Vec3d by;
        for (int k = 0; k < 3; ++k) by[k] = (value(x + h * Vec3d::Unit(k)) - value(x - h * Vec3d::Unit(k))) / (2 * h);
        return by;
      };
      const Vec3d fine = slope(1e-5), coarse = slope(2e-5);
      if ((fine - coarse).norm() > 1e-5 * (1 + fine.norm())) continue;
      ++checked;
      EXPECT_LT((collider.surface_adjoint(x, a, b) - fine).norm(), 1e-5 * (1 + fine.norm()))
          << &collider - colliders.data() << ": " << x.transpose();
    }
    EXPECT_GT(checked, 300) << &collider - colliders.data();
  }
}

TEST(Collider, ASampledDistanceIsThatOfTheShapeItWasMadeFrom) {
  const SignedDistanceGrid grid = sphere_grid(0.3, 0.05, 21);
  double worst = 0, turned = 0;
  for (int i = 0; i < 1000; ++i) {
    Random random(6, i);
    const Vec3d x(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const auto at = grid.sample(x);
    if (x.norm() < 0.1) continue;
    if (x.cwiseAbs().maxCoeff() < 0.5) {
      worst = std::max(worst, std::abs(at.distance - (x.norm() - 0.3)));
      turned = std::max(turned, std::acos(std::min(1.0, at.normal.dot(x.normalized()))));
    } else {
      EXPECT_GE(at.distance, x.norm() - 0.3 - 1e-3);  // no obstacle is invented outside the box
    }
  }
  EXPECT_LT(worst, 3 * 0.05 * 0.05 / 8 / 0.1);  // h^2 / 8 of second derivatives 1 / r
  EXPECT_LT(turned, 0.25);
}

TEST(Collider, TheVelocityOfASurfaceIsThatOfItsMotion) {
  Collider a, b;
  a.shape = b.shape = Region::sphere(Vec3d(0.3, 0, 0), 0.1);
  for (Collider* c : {&a, &b}) {
    c->velocity = Vec3d(1, 2, 3);
    c->angular_velocity = Vec3d(0.5, -2, 1);
  }
  const double t = 0.4, h = 1e-6;
  const Vec3d pivot(0.1, 0.2, -0.1);
  a.move(pivot, t * a.velocity, t);
  b.move(pivot, (t + h) * b.velocity, t + h);
  const Vec3d own(0.31, -0.05, 0.02);
  const Vec3d x = a.rotation * own + a.translation, later = b.rotation * own + b.translation;
  EXPECT_LT(((later - x) / h - a.velocity_at(x)).norm(), 1e-4);
}

// Random nodes around three colliders and a pin; nodes are far from switches.
struct NodeFixture {
  StepLoads<double> loads;
  std::array<Node<double>, BlockGrid::kNodes> node;
  NodeBlock<double> block{node.data(), Vec3d(-0.21, -0.19, -0.2), 0.13};

  NodeFixture() {
    Collider plane, sphere, slip, sticky;
    plane.shape = Region::half_space(Vec3d(0, 0, -0.1), Vec3d(0.3, 0.1, 1));
    plane.friction = 0.4;
    plane.velocity = Vec3d(0.2, 0, 0.1);
    sphere.shape = Region::sphere(Vec3d(0.1, 0.2, 0.1), 0.15);
    sphere.friction = 0.3;
    sphere.angular_velocity = Vec3d(0, 3, 1);
    slip.kind = ContactKind::kSlip;
    slip.shape = Region::box(Vec3d(0.1, -0.3, -0.3), Vec3d(0.3, 0.3, 0.3));
    sticky.kind = ContactKind::kSticky;
    sticky.shape = Region::cylinder(Vec3d(-0.3, -0.2, 0.1), Vec3d(0.3, -0.2, 0.1), 0.05);
    loads.colliders = {plane, sphere, slip, sticky};
    loads.pins = {Region::sphere(Vec3d(-0.2, 0.2, 0.2), 0.1)};
    loads.density = {1000};
    for (int k = 0; k < BlockGrid::kNodes; ++k) {
      Random random(9, k);
      for (int a = 0; a < 3; ++a) node[k].lane[a] = random.normal();
      node[k].lane[3] = 1000 * std::pow(0.13, 3) * random.uniform(0, 1.2);
    }
  }
};

TEST(NodeConditions, TheAdjointAgreesWithDifferences) {
  NodeFixture fixture;
  const auto original = fixture.node;
  std::vector<double> x;
  for (const auto& node : original) x.insert(x.end(), node.lane, node.lane + 3);
  // And displacements in centimeters, with which normals and velocities of the surfaces change.
  const size_t numbers = x.size();
  std::array<Node<double>, BlockGrid::kNodes> displacement{};
  fixture.block.displacement = displacement.data();
  x.resize(2 * numbers, 0.0);
  const auto set = [&](const std::vector<double>& values) {
    fixture.node = original;
    for (size_t i = 0; i < numbers; ++i) {
      fixture.node[i / 3].lane[i % 3] = values[i];
      displacement[i / 3].lane[i % 3] = 0.01 * values[numbers + i];
    }
  };
  AdjointCheckOptions options;
  options.step = 1e-4;
  options.unit_cotangents = 200;
  const AdjointCheck check = check_adjoint(
      [&](const std::vector<double>& values) {
        set(values);
        apply_node_conditions(fixture.loads, fixture.block);
        std::vector<double> y;
        for (const auto& node : fixture.node) y.insert(y.end(), node.lane, node.lane + 3);
        return y;
      },
      [&](const std::vector<double>& values, const std::vector<double>& adj_y) {
        set(values);
        std::array<Node<double>, BlockGrid::kNodes> adj{};
        for (size_t i = 0; i < adj_y.size(); ++i) adj[i / 3].lane[i % 3] = adj_y[i];
        std::array<Vec3d, BlockGrid::kNodes> by_displacement;
        by_displacement.fill(Vec3d::Zero());
        apply_node_conditions_adjoint(fixture.loads, fixture.block, adj.data(), by_displacement.data());
        std::vector<double> out;
        for (const auto& node : adj) out.insert(out.end(), node.lane, node.lane + 3);
        for (const Vec3d& by : by_displacement)
          for (int a = 0; a < 3; ++a) out.push_back(0.01 * by[a]);
        return out;
      },
      x, options);
  EXPECT_LT(check.worst, 1e-6) << check.message;
}

TEST(NodeConditions, TheImpulseReportedIsTheMomentumTaken) {
  NodeFixture fixture;
  fixture.loads.pins.clear();
  const auto before = fixture.node;
  std::vector<Vec3d> impulse(fixture.loads.colliders.size(), Vec3d::Zero());
  apply_node_conditions(fixture.loads, fixture.block, impulse.data());
  Vec3d gained = Vec3d::Zero(), reported = Vec3d::Zero();
  for (int k = 0; k < BlockGrid::kNodes; ++k)
    for (int a = 0; a < 3; ++a) gained[a] += before[k].lane[3] * (fixture.node[k].lane[a] - before[k].lane[a]);
  for (const Vec3d& j : impulse) {
    EXPECT_GT(j.norm(), 0);
    reported += j;
  }
  EXPECT_LT((gained - reported).norm(), 1e-12 * gained.norm());
}

TEST(NodeConditions, FrictionTakesAtMostItsShareAndNeverReverses) {
  Collider plane;
  plane.shape = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  for (const double mu : {0.0, 0.3, 2.0}) {
    plane.friction = mu;
    const Vec3d n = Vec3d::UnitZ(), after = velocity_after_contact(plane, n, Vec3d::Zero(), Vec3d(3, 4, -2));
    EXPECT_NEAR(after.norm(), std::max(0.0, 5 - 2 * mu), 1e-12);
    EXPECT_EQ(after.z(), 0);
    EXPECT_EQ(velocity_after_contact(plane, n, Vec3d::Zero(), Vec3d(3, 4, 2)), Vec3d(3, 4, 2));
  }
}

TEST(NodeConditions, AHalfSpaceFillsTheShareOfANodeThatItsSplineSays) {
  for (double d = -1.7; d < 1.7; d += 0.05) {
    double sum = 0;
    const int cells = 4000;
    for (int i = 0; i < cells; ++i) {
      const double y = 4.0 * (i + 0.5) / cells;  // above the face
      const double s = std::abs(y - d);
      sum += (s < 0.5 ? 0.75 - s * s : s < 1.5 ? 0.5 * (1.5 - s) * (1.5 - s) : 0) * 4.0 / cells;
    }
    EXPECT_NEAR(filled_share(d), sum, 1e-5) << d;
  }
}

// --- Bodies ---

Interaction collider(const Region& shape, double friction, ContactKind kind = ContactKind::kSeparating) {
  Interaction it;
  it.type = InteractionType::kCollider;
  it.region = shape;
  it.friction = friction;
  it.contact = kind;
  return it;
}

Vec3d mean_velocity(const State& s) {
  Vec3d sum = Vec3d::Zero();
  for (const Vec3d& v : s.v) sum += v / static_cast<double>(s.size());
  return sum;
}

Vec3d centre(const State& s) {
  Vec3d sum = Vec3d::Zero();
  for (const Vec3d& x : s.x) sum += x / static_cast<double>(s.size());
  return sum;
}

struct Course {
  std::vector<State> states;
  SimulateSummary summary;
};
Course run(const BasicParticles<double>& particles, const Vec3d& gravity, const std::vector<Interaction>& script,
           double seconds, const State& start, double damping_time = 0, double viscosity_time = 0) {
  SimulateOptions options;
  options.viscosity_time = viscosity_time;
  options.fps = 50;
  options.duration = seconds;
  options.gravity = gravity;
  options.damping_time = damping_time;
  Course out;
  out.summary = simulate<double>(options, particles, script, start, [&](const State& s) {
                  return out.states.push_back(s), true;
                }).summary;
  return out;
}

/// A flat block that came to rest on a plane, which is then tilted by `angle`: way along the plane, speed and
/// acceleration when the jolt has passed, which the block's viscosity damps.
struct Slide {
  double way, speed, acceleration;
};
Slide slide(double angle, double friction, double thickness) {
  const auto particles = fixture::block<double>({0.06, 0.06, thickness}, 0.01, 1.0, 1e5);
  Interaction tilted;
  tilted.type = InteractionType::kGravity;
  tilted.start = 0.1;
  tilted.vector = kGravity * Vec3d(std::sin(angle), 0, -std::cos(angle));
  const Interaction plane = collider(Region::half_space(Vec3d::Zero(), Vec3d::UnitZ()), friction);
  const auto states =
      run(particles, {0, 0, -kGravity * std::cos(angle)}, {plane, tilted}, 0.52, initial_state(particles), 0, 6e-4)
          .states;
  const State &half = states[20], &end = states.back();
  return {(centre(end) - centre(half)).x(), mean_velocity(end).x(),
          (mean_velocity(end) - mean_velocity(half)).x() / (end.time - half.time)};
}

TEST(ColliderLaw, ABlockSticksAndSlidesOnASlopeAsItsFrictionSays) {
  constexpr double kDegree = kPi / 180;
  // The middle of the block is a node row, so the plane lies 0, .75 and .5 of a cell above one.
  const double friction[] = {0.2, 0.5, 0.8}, thickness[] = {0.04, 0.035, 0.03};
  for (int k = 0; k < 3; ++k) {
    const double mu = friction[k], critical = std::atan(mu), steep = critical + 10 * kDegree;
    const Slide below = slide(critical - 1.5 * kDegree, mu, thickness[k]);
    EXPECT_LT(std::abs(below.way), 2e-4) << mu;
    EXPECT_LT(std::abs(below.speed), 5e-3) << mu;
    const Slide above = slide(critical + 1.5 * kDegree, mu, thickness[k]);
    EXPECT_GT(above.way, 0.008) << mu;
    const double expected = kGravity * (std::sin(steep) - mu * std::cos(steep));
    EXPECT_NEAR(slide(steep, mu, thickness[k]).acceleration / expected, 1, 0.01) << mu;
  }
}

// The lower half may be of a tenth of the density: where surfaces are does not depend on what is behind them.
TEST(ColliderLaw, ABodyRestsOnAPlaneAtTheRightHeightWhereverTheNodesLie) {
  for (const double thickness : {0.03, 0.0325, 0.035, 0.0375}) {
    for (const Vec3d& tilt : {Vec3d(0, 0, 1), Vec3d(0.48, 0.36, 0.8)}) {
      for (const double lower : {1.0, 0.1}) {
        // The block lies on the plane with its lower face; the frame is turned, not the block, for the tilted plane.
        auto particles = fixture::block<double>({0.05, 0.05, thickness}, 0.01, 0.0, 1e5);
        for (size_t i = 0; i < particles.size(); ++i)
          if (particles.position[i].z() < thickness / 2) particles.mass[i] *= lower;
        const Mat3d turn = shortest_rotation<double>(Vec3d::UnitZ(), tilt);
        for (Vec3d& x : particles.position) x = turn * x;
        const Interaction plane = collider(Region::half_space(Vec3d::Zero(), tilt), 0.5);
        const State end = run(particles, -kGravity * tilt, {plane}, 0.4, initial_state(particles), 0.05).states.back();
        double sunk = 0, count = 0;
        for (size_t i = 0; i < end.size(); ++i) {
          if (particles.position[i].dot(tilt) > 0.005) continue;
          sunk += (end.x[i] - particles.position[i]).dot(tilt);
          ++count;
        }
        EXPECT_LT(std::abs(sunk / count), 0.3 * 0.01) << thickness << " " << tilt.transpose() << " " << lower;
      }
    }
  }
}

BasicParticles<double> ball(double radius, double dx, double young) {
  return fixture::fill_shape<double>(Vec3d::Constant(2 * radius), dx, 2, 1.0, young, 0.3, 1000,
                                     [&](const Vec3d& x) { return (x - Vec3d::Constant(radius)).norm() < radius; });
}

/// Least signed distance of a particle from the shape, in cells.
double deepest(const State& s, const Interaction& obstacle, double dx) {
  Collider c;
  c.shape = obstacle.region;
  c.container = obstacle.container;
  c.grid = obstacle.distance;
  double least = INFINITY;
  for (const Vec3d& x : s.x) least = std::min(least, c.surface(x).distance / dx);
  return least;
}

TEST(ColliderLaw, ABallRollsOffASphereAndACylinderAndRestsOnABoxAndInAContainer) {
  constexpr double dx = 0.01, radius = 0.03;
  const auto particles = ball(radius, dx, 1e5);
  const Interaction sphere = collider(Region::sphere(Vec3d(0, 0.03, -0.0944), 0.098), 0.3);
  const Interaction cylinder = collider(Region::cylinder(Vec3d(0, -0.3, -0.0944), Vec3d(0, 0.3, -0.0944), 0.098), 0.3);
  for (const Interaction& round : {sphere, cylinder}) {
    const auto states = run(particles, {0, 0, -kGravity}, {round}, 0.3, initial_state(particles)).states;
    for (const State& s : states) EXPECT_GT(deepest(s, round, dx), -0.5);
    EXPECT_GT(mean_velocity(states.back()).x(), 0.05);  // to the side on which it lay
    const Vec3d surface = centre(states.back()) - Vec3d(0, 0.03, -0.0944);
    EXPECT_NEAR(std::hypot(surface.x(), surface.z()), 0.128, 0.5 * dx);
  }
  const Interaction box = collider(Region::box(Vec3d(-0.1, -0.1, -0.1), Vec3d(0.2, 0.2, -0.004)), 0.3);
  Interaction bowl = collider(Region::sphere(Vec3d(0.03, 0.03, 0.08), 0.084), 0.3);
  bowl.container = true;
  for (const Interaction& rest : {box, bowl}) {
    const State end = run(particles, {0, 0, -kGravity}, {rest}, 0.6, initial_state(particles), 0.1).states.back();
    EXPECT_GT(deepest(end, rest, dx), -0.5);
    EXPECT_NEAR(centre(end).z(), radius - 0.004, 0.5 * dx);
    EXPECT_LT(mean_velocity(end).norm(), 0.02);
  }
}

TEST(ColliderLaw, AFrictionlessBoxHoldsASoftBlockInItsCornersToo) {
  // Side walls allow no strain across: the block sinks by rho g h^2 / (2 M) in the mean, M = lambda + 2 mu.
  const double dx = 0.01, side = 0.06, young = 2e4, poisson = 0.3;
  const auto particles = fixture::block<double>({side, side, side}, dx, 1.0, young, poisson);
  SimulateOptions options;
  options.fps = 50;
  options.duration = 0.6;
  options.damping_time = 0.03;
  Interaction walls;
  walls.type = InteractionType::kCollider;
  walls.container = true;
  walls.friction = 0;
  walls.region = Region::box(Vec3d::Zero(), Vec3d(side, side, 1));
  const auto result = simulate<double>(options, particles, {walls}, initial_state(particles));
  const Lame<double> l = lame(young, poisson);
  const double sink = 1000 * kGravity * side * side / (2 * (l.lambda + 2 * l.mu));
  double top = 0;
  int count = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    const Vec3d x = result.state.x[i], above = Vec3d(side, side, 1) - x;
    EXPECT_GT(std::min(x.minCoeff(), above.minCoeff()), -0.4 * dx) << x.transpose();
    if (particles.position[i].z() > side - dx) {
      top += particles.position[i].z() - x.z();
      ++count;
    }
  }
  EXPECT_LT(std::abs(top / count - sink), 0.4 * dx) << "sank " << top / count << " m, theory " << sink;
}

TEST(ColliderLaw, AMovingStickyBoxCarriesABodyAndGivesItTheImpulseItReports) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01, 1.0, 4e4);
  Interaction box = collider(Region::box(Vec3d(-0.02, -0.02, -0.03), Vec3d(0.06, 0.06, 0.01)), 0, ContactKind::kSticky);
  box.vector = Vec3d(0.3, -0.1, 0.2);
  box.duration = 0.3;
  const Course carried = run(particles, Vec3d::Zero(), {box}, 0.5, initial_state(particles), 0.0);
  const Vec3d moved = centre(carried.states[15]) - centre(carried.states[0]);
  EXPECT_LT((moved - 0.3 * box.vector).norm(), 0.1 * 0.3 * box.vector.norm());
  Vec3d impulse = Vec3d::Zero();
  for (const auto& frame : carried.summary.impulse_of_frame) impulse += frame[0];
  const Vec3d momentum = particles.total_mass() * mean_velocity(carried.states.back());
  EXPECT_LT((impulse - momentum).norm(), 1e-10 * momentum.norm());
  EXPECT_LT((mean_velocity(carried.states[25]) - mean_velocity(carried.states[16])).norm(), 1e-10);  // let go
  EXPECT_EQ(carried.summary.impulse_of_frame[20][0], Vec3d::Zero());
}

TEST(ColliderLaw, ATurningStickyCylinderTurnsABody) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01, 1.0, 1e5);
  Interaction chuck =
      collider(Region::cylinder(Vec3d(0.02, 0.02, -0.05), Vec3d(0.02, 0.02, 0.03), 0.05), 0, ContactKind::kSticky);
  chuck.angular_velocity = Vec3d(0, 0, 2);
  chuck.pivot = Vec3d(0.02, 0.02, 0);
  const State end = run(particles, Vec3d::Zero(), {chuck}, 0.4, initial_state(particles), 0.05).states.back();
  const Mat3d turn = Eigen::AngleAxisd(0.8, Vec3d::UnitZ()).toRotationMatrix();
  for (size_t i = 0; i < end.size(); ++i) {
    const Vec3d expected = chuck.pivot + turn * (particles.position[i] - chuck.pivot);
    EXPECT_LT((end.x[i] - expected).norm(), 0.3 * 0.01);
  }
}

TEST(ColliderLaw, ASlipWallKeepsTheTangentialVelocityAndHoldsTheNormalOne) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01, 1.0, 1e5);
  State start = initial_state(particles);
  for (Vec3d& v : start.v) v = Vec3d(0.4, -0.3, 0);
  // The wall holds the whole lower half, so that nothing bounces; gravity pulls away from it.
  const Interaction wall = collider(Region::half_space(Vec3d(0, 0, 0.02), Vec3d::UnitZ()), 0, ContactKind::kSlip);
  const State end = run(particles, {0, 0, 2}, {wall}, 0.3, start).states.back();
  const Vec3d v = mean_velocity(end);
  EXPECT_NEAR(v.x(), 0.4, 1e-10);
  EXPECT_NEAR(v.y(), -0.3, 1e-10);
  EXPECT_LT(std::abs(v.z()), 0.02);
  EXPECT_LT(std::abs(centre(end).z() - 0.02), 1e-3);
}

TEST(ColliderLaw, ASeparatingPokeReportsTheForceOfItsFinger) {
  // A finger pushes a block along a frictionless floor at constant speed: what it gives is the block's momentum.
  const auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01, 1.0, 1e5);
  const Interaction floor = collider(Region::half_space(Vec3d::Zero(), Vec3d::UnitZ()), 0);
  Interaction poke;
  poke.type = InteractionType::kPoke;
  poke.region.kind = Region::Kind::kSphere;
  poke.region.radius = 0.02;
  poke.path = {{0, Vec3d(-0.04, 0.02, 0.02)}, {0.5, Vec3d(0.06, 0.02, 0.02)}};
  const Course pushed = run(particles, {0, 0, -kGravity}, {floor, poke}, 0.6, initial_state(particles));
  Vec3d given = Vec3d::Zero();
  for (const auto& frame : pushed.summary.impulse_of_frame) given += frame[1];
  const Vec3d momentum = particles.total_mass() * mean_velocity(pushed.states.back());
  EXPECT_NEAR(given.x(), momentum.x(), 1e-10);
  EXPECT_GT(mean_velocity(pushed.states.back()).x(), 0.19);         // at least the finger's speed
  EXPECT_EQ(pushed.summary.impulse_of_frame[0][1], Vec3d::Zero());  // 2 cm away at first
  EXPECT_GT(deepest(pushed.states.back(), floor, 0.01), -0.5);
}

}  // namespace
}  // namespace pliant
