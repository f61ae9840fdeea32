// Collide kernels give the same bits on every instruction set, wherever in a chunk a pair lies.
#include "collide_fixture.h"

#include <algorithm>
#include <limits>

namespace scree::collide_tests {
namespace {

constexpr ShapeType kTypes[] = {ShapeType::sphere, ShapeType::capsule, ShapeType::box};

void append(Pairs& to, const Pairs& from) {
  for (std::size_t s = 0; s < from.pose.size(); s += 2) {
    to.add({from.type[s], from.extent[s]}, from.pose[s], {from.type[s + 1], from.extent[s + 1]},
           from.pose[s + 1]);
  }
}

// All types, touching and apart, with aligned and coincident boxes among them, every body kind and material.
Pairs mixed_pairs() {
  Pairs pairs;
  for (const ShapeType a : kTypes) {
    for (const ShapeType b : kTypes) append(pairs, random_pairs(a, b, 301, 11, -0.3f, 0.1f));
  }
  Random random(12);
  for (int k = 0; k < 301; ++k) {
    const Vec3 place = 100.0f * random.vector();
    const Shape one = box(random.size(), random.size(), random.size());
    pairs.add(one, pose_row(place), k % 3 == 0 ? one : box(1, random.size(), 1),
              pose_row(place, turn({0, 1, 0}, 0.1f * float(k % 5))));
    pairs.add(capsule(1, 0.3f), pose_row(place), kTypes[k % 3] == ShapeType::box ? one : capsule(1, 0.3f),
              pose_row(place));
  }
  for (std::size_t row = 0; row < pairs.items.size(); ++row) {
    if (row % 3 == 1) pairs.items[row].flags = simd::kItemFlip | simd::kItemStatic | simd::kItemFixed;
    if (row % 7 == 2) pairs.items[row].flags = simd::kItemStatic;
  }
  for (MaterialRow& material : pairs.material) {
    const std::uint32_t rule = static_cast<std::uint32_t>(random.uniform(0.0f, 4.99f));
    const bool moves = random.uniform(0, 1) < 0.1f;
    material = {random.uniform(0, 1),
                random.uniform(-0.5f, 0.5f) > 0 ? 0.5f : 0.0f,
                random.uniform(-0.5f, 0.1f) > 0 ? 0.1f : 0.0f,
                rule | (4 - rule) << 8 | (moves ? kMaterialMoves : 0u),
                {moves ? 1.0f : 0.0f, moves ? -2.0f : 0.0f, 0},
                0};
  }
  return pairs;
}

// The same pairs a moment later.
Pairs jittered(const Pairs& pairs) {
  Pairs result;
  Random random(13);
  for (std::size_t s = 0; s < pairs.pose.size(); s += 2) {
    PoseRow moved = pairs.pose[s + 1];
    for (float& x : moved.position) x += random.uniform(-1e-3f, 1e-3f);
    result.add({pairs.type[s], pairs.extent[s]}, pairs.pose[s], {pairs.type[s + 1], pairs.extent[s + 1]},
               moved);
  }
  for (std::size_t s = 0; s < pairs.pose.size(); ++s) result.material[s] = pairs.material[s];
  for (std::size_t row = 0; row < pairs.items.size(); ++row) result.items[row].flags = pairs.items[row].flags;
  return result;
}

// As the solver would: some impulse at every point.
void fill_impulses(Rows& rows) {
  for (std::size_t row = 0; row < rows.manifold.size(); ++row) {
    Manifold& m = rows.manifold[row];
    if (m.info == 0) continue;
    for (int k = 0; k < points_of(m); ++k) m.normal_impulse[k] = 0.1f * float(row % 17) + float(k);
    m.friction_impulse[0] = 0.3f;
    m.friction_impulse[1] = -0.7f;
    m.twist_impulse = 0.2f;
    for (float& r : rows.surface[row].rolling_impulse) r = float(row % 5);
  }
}

void expect_same_bits(const Rows& a, const Rows& b, const char* name) {
  int touching = 0;
  for (std::size_t row = 0; row < a.manifold.size(); ++row) {
    ASSERT_EQ(a.points[row], b.points[row]) << name << " row " << row;
    ASSERT_EQ(a.manifold[row].info, b.manifold[row].info) << name << " row " << row;
    if (a.manifold[row].info == 0) continue;
    ++touching;
    ASSERT_EQ(std::memcmp(&a.manifold[row], &b.manifold[row], sizeof(Manifold)), 0) << name << " row " << row;
    ASSERT_EQ(std::memcmp(&a.features[row], &b.features[row], sizeof(ManifoldFeatures)), 0) << name;
    ASSERT_EQ(std::memcmp(&a.surface[row], &b.surface[row], sizeof(ContactSurface)), 0) << name;
  }
  EXPECT_GT(touching, 2000);
}

TEST(CollideBits, EveryInstructionSetGivesThoseOfScalar) {
  const Pairs first = mixed_pairs(), second = jittered(first);
  Rows before = first.run(scalar_kernels());
  fill_impulses(before);
  const Rows after = second.run(scalar_kernels(), &before);
  for (const simd::Kernels* kernels : all_kernels()) {
    Rows wide = first.run(*kernels);
    fill_impulses(wide);
    expect_same_bits(before, wide, kernels->name);
    expect_same_bits(after, second.run(*kernels, &wide), kernels->name);
  }
}

TEST(CollideBits, NeighborsInAChunkChangeNothing) {
  Pairs pairs = mixed_pairs();
  const Rows expected = pairs.run(scalar_kernels());
  std::mt19937 engine(14);
  std::shuffle(pairs.items.begin(), pairs.items.end(), engine);
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_same_bits(expected, pairs.run(*kernels), kernels->name);
  }
}

TEST(CollideBits, NonFiniteShapesDoNotTouchAndDisturbNobody) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  Pairs pairs = mixed_pairs();
  const Rows expected = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); row += 5) {
    PoseRow& pose = pairs.pose[static_cast<std::size_t>(pairs.items[row].shape_2)];
    const float bad = row % 2 == 0 ? nan : row % 3 == 0 ? infinity : -infinity;
    (row % 4 < 2 ? pose.position[row % 3] : pose.rotation[row % 4]) = bad;
  }
  for (const simd::Kernels* kernels : all_kernels()) {
    const Rows rows = pairs.run(*kernels);
    for (std::size_t row = 0; row < pairs.items.size(); ++row) {
      if (row % 5 == 0) {
        ASSERT_EQ(rows.manifold[row].info, 0u) << kernels->name;
        ASSERT_EQ(rows.points[row], 0);
      } else if (expected.manifold[row].info != 0) {
        ASSERT_EQ(std::memcmp(&rows.manifold[row], &expected.manifold[row], sizeof(Manifold)), 0)
            << kernels->name;
      }
    }
  }
}

}  // namespace
}  // namespace scree::collide_tests
