// Laws of solvers over the whole system where ranks share the world: bits, figures and forces are those of
// one process, whoever owns which body.
#include <parallel/constraints/constraints.h>
#include <scree/distributed_world.h>
#include <scree/step.h>
#include <scree/triangle_mesh.h>
#include <tests/parallel/distributed/eventful_pile.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/parallel/distributed/step_ranks.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

namespace scree {
namespace {

using namespace distributed_tests;

Fill with_solver(Solver solver, Fill fill) {
  return [=](Lab& lab) {
    WorldSettings settings = lab.world.settings();
    settings.solver = solver;
    lab.world.set_settings(settings);
    fill(lab);
  };
}

// Every method over the whole system.
template <class Work>
void for_each_method(Work&& work) {
  for (int solver = static_cast<int>(Solver::jacobi); solver < kSolverCount; ++solver) {
    SCOPED_TRACE(solver_name(static_cast<Solver>(solver)));
    work(static_cast<Solver>(solver));
  }
}

TEST(SolveAcross, EachMethodHasTheBitsOfOneProcess) {
  for_each_method([](Solver solver) {
    const Fill heap =
        with_solver(solver, [](Lab& lab) { physics::add_heap(lab, 24, 5, {.friction = 0.5f}); });
    expect_same_bits(heap, random_owner, {.ranks = 3, .steps = 50, .steps_per_draw = 1});
    const Fill joints = with_solver(solver, scene("ragdolls", {{"ragdolls", 2}}));
    expect_same_bits(joints, random_owner, {.ranks = 2, .steps = 20, .steps_per_draw = 7});
  });
}

TEST(SolveAcross, ImpactsAndSleepHaveTheBitsOfOneProcess) {
  const Fill heap = with_solver(Solver::gauss_seidel, [](Lab& lab) {
    physics::add_heap(lab, 24, 9, {.friction = 0.5f, .restitution = 0.5f});
  });
  for (const int ranks : {2, 8})
    expect_same_bits(heap, random_owner,
                     {.ranks = ranks, .steps = 200, .sleeping = true, .steps_per_draw = 4});
}

// Its owner alone has the constraints of a hub. Of two that touch, these have no color.
TEST(SolveAcross, HubsHaveTheBitsOfOneProcess) {
  const auto fill = [](Lab& lab) {
    lab.add_ground();
    for (int hub = 0; hub < 2; ++hub) {
      const float y = 0.2f + 1.2f * static_cast<float>(hub);
      const BodyId plate = lab.add({.position = {0, y, 0}}, Box{{3, 0.1f, 3}});
      for (int i = 0; i < 40; ++i) {
        const float x = 0.8f * static_cast<float>(i % 7 - 3), z = 0.9f * static_cast<float>(i / 7 - 3);
        const BodyId ball = lab.add({.position = {x, y + 0.36f, z}}, Sphere{0.25f});
        if (i % 10 == 0)
          lab.world.create_joint({.body_a = plate, .body_b = ball, .frame_a = {{x, 0.36f, z}, {}}},
                                 BallJoint{});
      }
    }
  };
  const Fill hubs = with_solver(Solver::gauss_seidel, fill);
  Lab lab(settings_for_ranks());
  hubs(lab);
  lab.run(40);
  const Column<BodyColors>& bodies = constraints_of(internals(lab.world)).body_colors;
  EXPECT_EQ(std::count_if(bodies.begin(), bodies.end(),
                          [](const BodyColors& colors) { return colors.degree > kHubDegree; }),
            2);
  for (const int ranks : {2, 4})
    expect_same_bits(hubs, random_owner, {.ranks = ranks, .steps = 40, .steps_per_draw = 5});
}

// A ball in a valley of a mesh has two contacts with it.
TEST(SolveAcross, MeshesHaveTheBitsOfOneProcess) {
  const auto fill = [](Lab& lab) {
    constexpr std::uint32_t kSide = 12;
    std::vector<Vec3> vertices;
    std::vector<MeshTriangle> triangles;
    for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
      const std::uint32_t x = i % kSide, z = i / kSide;
      const auto at = [](std::uint32_t place) { return 0.5f * static_cast<float>(place) - 3; };
      vertices.push_back({at(x), 0.4f * static_cast<float>(x % 2), at(z)});
      if (x + 1 == kSide || z + 1 == kSide) continue;
      triangles.push_back({i, i + kSide, i + 1});
      triangles.push_back({i + 1, i + kSide, i + kSide + 1});
    }
    const BodyId ground = lab.world.create_body({.type = BodyType::fixed});
    lab.world.add_shape(ground, TriangleMesh(vertices, triangles));
    for (int i = 0; i < 18; ++i)
      lab.add({.position = {static_cast<float>(i % 3 - 1), 0.6f + 0.5f * static_cast<float>(i / 9),
                            static_cast<float>(i / 3 % 3 - 1)}},
              Sphere{0.3f});
  };
  const Fill balls = with_solver(Solver::gauss_seidel, fill);
  Lab lab(settings_for_ranks());
  balls(lab);
  lab.run(40);
  const Contacts& contacts = internals(lab.world).contacts;
  int again = 0;  // contacts of a pair that has another one
  for (std::size_t i = 1; i < contacts.active.size(); ++i) {
    const ShapePair &one = contacts.now.pair[contacts.active[i - 1]],
                    &next = contacts.now.pair[contacts.active[i]];
    again += one.a == next.a && one.b == next.b ? 1 : 0;
  }
  EXPECT_GT(again, 5);
  expect_same_bits(balls, random_owner, {.ranks = 3, .steps = 60, .steps_per_draw = 3});
}

// What a step tells of contacts and joints, by their numbers.
using Told = std::map<std::tuple<int, std::uint32_t, std::uint32_t>, std::vector<float>>;

// Ranks that tell of the same must tell the same.
void note(Told& told, int step, std::uint32_t first, std::uint32_t second, std::vector<float> values) {
  const auto [place, is_new] = told.try_emplace({step, first, second}, values);
  EXPECT_TRUE(is_new || place->second == values) << "step " << step << ", " << first << " and " << second;
}

void note_all(const World& world, int step, Told& told) {
  for (const auto& events : {world.contact_begins(), world.contact_persists()}) {
    for (const ContactEvent& event : events)
      note(told, step, event.shape_a.index, event.shape_b.index,
           {event.normal_impulse, event.approach_speed});
  }
  constexpr std::uint32_t kJoint = 1u << 30, kBroken = kJoint + 1;
  for (const JointEvent& event : world.joint_events())
    note(told, step, kJoint, event.joint.index, {event.force, event.torque});
  for (const JointId joint : world.broken_joints()) note(told, step, kBroken, joint.index, {});
}

// A pile that falls on chains, whose links may break.
World make_pile_on_chains(const WorldSettings& of_solver) {
  World world = make_eventful_pile(30).world;
  WorldSettings settings = world.settings();
  settings.solver = of_solver.solver;
  settings.solver_options = of_solver.solver_options;
  settings.measure_residual = true;
  world.set_settings(settings);
  for (int chain = 0; chain < 3; ++chain) {
    BodyId last = world.create_body({.type = BodyType::fixed});
    for (int i = 0; i < 6; ++i) {
      const float x = -1.25f + 0.5f * static_cast<float>(i), z = static_cast<float>(chain) - 1;
      const BodyId link = world.create_body({.position = {x, 1, z}});
      world.add_shape(link, Box{{0.22f, 0.1f, 0.1f}});
      world.create_joint({.body_a = last,
                          .body_b = link,
                          .frame_a = {i == 0 ? Vec3{-1.5f, 1, z} : Vec3{0.25f, 0, 0}, {}},
                          .frame_b = {{-0.25f, 0, 0}, {}},
                          .break_force = 1500,
                          .event_force = 100},
                         BallJoint{});
      last = link;
    }
  }
  return world;
}

TEST(SolveAcross, TellsOfImpulsesAndFiguresAsOneProcessDoes) {
  constexpr int kSteps = 80;
  for (const Solver solver : {Solver::soft_step, Solver::sequential_impulse, Solver::conjugate_gradient}) {
    SCOPED_TRACE(solver_name(solver));
    WorldSettings settings;
    settings.solver = solver;
    World one = make_pile_on_chains(settings);
    Workers one_thread(1);
    Told expected, found;
    std::vector<std::pair<double, std::int32_t>> figures;
    std::size_t broken = 0;
    for (int i = 0; i < kSteps; ++i) {
      step(one, kStep, one_thread);
      note_all(one, i, expected);
      figures.push_back({one.stats().residual, one.stats().solver_iterations});
      broken += one.broken_joints().size();
    }
    EXPECT_GT(expected.size(), 500u);
    EXPECT_GT(broken, 0u);
    std::mutex mutex;
    const auto errors = run_ranks(3, [&](int, Transport& transport) {
      DistributedWorld world(make_pile_on_chains(settings), transport, {.steps_per_look = 0});
      Workers workers(1);
      for (int i = 0; i < kSteps; ++i) {
        redraw_owners(world.world(), i, 3, 4, workers);
        world.step(kStep, workers);
        const StepStats& stats = world.world().stats();
        const std::lock_guard lock(mutex);
        EXPECT_EQ(std::pair(stats.residual, stats.solver_iterations), figures[static_cast<std::size_t>(i)]);
        note_all(world.world(), i, found);
      }
    });
    EXPECT_EQ(all_of(errors), "");
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace scree
