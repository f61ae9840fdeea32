// Laws of solvers over the whole system where ranks share the world: bits, figures and forces are those of
// one process, whoever owns which body.
#include <parallel/constraints/constraints.h>
#include <scree/distributed_world.h>
#include <scree/step.h>
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

// By pair of shapes: the largest normal impulse of each step.
using Impulses = std::map<std::tuple<int, std::uint32_t, std::uint32_t>, float>;

void note_impulses(const World& world, int step, Impulses& impulses) {
  for (const auto& events : {world.contact_begins(), world.contact_persists()}) {
    for (const ContactEvent& event : events)
      impulses[{step, event.shape_a.index, event.shape_b.index}] = event.normal_impulse;
  }
}

TEST(SolveAcross, TellsOfImpulsesAndFiguresAsOneProcessDoes) {
  constexpr int kSteps = 80;
  const auto make = [] {
    World world = make_eventful_pile(30).world;
    WorldSettings settings = world.settings();
    settings.solver = Solver::conjugate_gradient;
    world.set_settings(settings);
    return world;
  };
  World one = make();
  Workers one_thread(1);
  Impulses expected, found;
  std::vector<std::pair<double, std::int32_t>> figures;
  for (int i = 0; i < kSteps; ++i) {
    step(one, kStep, one_thread);
    note_impulses(one, i, expected);
    figures.push_back({one.stats().residual, one.stats().solver_iterations});
  }
  EXPECT_GT(expected.size(), 500u);
  std::mutex mutex;
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    DistributedWorld world(make(), transport, {.steps_per_look = 5, .imbalance = 1.0f});
    Workers workers(1);
    for (int i = 0; i < kSteps; ++i) {
      world.step(kStep, workers);
      const StepStats& stats = world.world().stats();
      const std::lock_guard lock(mutex);
      EXPECT_EQ(std::pair(stats.residual, stats.solver_iterations), figures[static_cast<std::size_t>(i)]);
      note_impulses(world.world(), i, found);
    }
  });
  EXPECT_EQ(all_of(errors), "");
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace scree
