// Laws of lists that keep the pairs of the ones before, but for those of shapes that have left their bounds.
#include <tests/parallel/broad_phase/pair_lists.h>

#include <algorithm>
#include <set>
#include <vector>

namespace scree {
namespace {

using testing::add_random_body;
using testing::brute_force;
using testing::expect_canonical;
using testing::Follower;
using testing::HandMadeWorld;
using testing::kPairStep;
using testing::listed;
using testing::Pair;
using testing::Random;
using testing::random_filter;

// Most bodies rest or move slowly, and some fall asleep: most lists keep the pairs of the one before but for
// those of the shapes that have left their bounds. `spread`: m, of the boxes that bodies start in.
void expect_lists_of_few_moved(const WorkersOptions& options, std::uint64_t seed, Vec3 spread) {
  Workers workers(options);
  HandMadeWorld world;
  Random random(seed);
  BroadPhase& broad_phase = broad_phase_of(world.data);
  world.add_box(BodyType::fixed, {0, -5, 0}, {100, 1, 100});
  std::vector<std::int32_t> bodies;
  for (int i = 0; i < 300; ++i) {
    const BodyType type = random.below(8) == 0 ? BodyType::fixed : BodyType::dynamic;
    const float speed = random.below(12) == 0 ? 6.0f : 0.05f;
    bodies.push_back(add_random_body(world, random, type, spread, speed,
                                     1 + static_cast<int>(random.below(3)), random_filter(random)));
  }
  for (const float speed : {0.0f, 0.2f, 5.0f}) {
    bodies.push_back(add_random_body(world, random, BodyType::kinematic, spread, speed, 3));
  }
  Follower follower;
  int kept = 0, slept = 0, kinematic = 0;
  for (int i = 0; i < 60; ++i) {
    world.refresh();
    if (i > 0) world.data.shapes.trees_changed = false;  // as refresh_lists, which notes what changes
    if (i % 3 == 1) {
      const std::int32_t body = bodies[random.below(static_cast<std::uint32_t>(bodies.size()))];
      if (world.data.bodies.type[static_cast<std::size_t>(body)] == BodyType::dynamic) {
        world.set_asleep(body, i % 12 != 10);
        for (std::int32_t shape = world.data.bodies.first_shape[static_cast<std::size_t>(body)]; shape >= 0;
             shape = world.data.shapes.next[static_cast<std::size_t>(shape)])
          broad_phase.changed.push_back(shape);
      }
    }
    if (i % 20 == 15) world.move_by_call(bodies[random.below(300)], random.point(spread));
    Crew crew(workers);
    const bool a_kinematic_one_left =
        std::any_of(broad_phase.left.begin(), broad_phase.left.end(), [&](std::int32_t shape) {
          return world.data.shapes.tree[static_cast<std::size_t>(shape)] == TreeKind::kinematic;
        });
    find_pairs(world.data, crew);
    const std::vector<Pair> list = listed(world.data);
    const std::set<Pair> expected = brute_force(world.data);
    std::vector<Pair> found;  // resting pairs are not in the definition
    for (const ShapePair& pair : world.data.contacts.pairs.pair) found.emplace_back(pair.a, pair.b);
    expect_canonical(list);
    ASSERT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end()))
        << "step " << i << ": " << found.size() << " " << expected.size();
    follower.check_and_move(world.data);
    kept += broad_phase.few_moved ? 1 : 0;
    kinematic += broad_phase.few_moved && a_kinematic_one_left ? 1 : 0;
    slept += broad_phase.few_moved && world.data.bodies.asleep > 0 ? 1 : 0;
    world.refresh();
    world.integrate(kPairStep);
    update_bounds(world.data, kPairStep, crew);
  }
  EXPECT_GT(kept, 30);
  EXPECT_GT(slept, 20);
  EXPECT_GT(kinematic, 20);
}

TEST(FindPairsMoved, ListEqualsBruteForceWhereFewShapesLeaveTheirBounds) {
  for (const WorkersOptions& options : testing::all_workers()) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      expect_lists_of_few_moved(options, seed, {4, 4, 4});
      expect_lists_of_few_moved(options, seed, {80, 4, 80});
    }
  }
}

}  // namespace
}  // namespace scree
