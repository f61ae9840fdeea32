// Collide kernels give the same bits on every instruction set, at any place of a pair in a chunk.
#include <core/plain/rows.h>

#include <tests/simd/same_bits.h>
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
                rule | (4 - rule) << 8 | (moves ? kMaterialMoves : 0u) |
                    (rule == 1 || rule == 2 ? kMaterialPatch : 0u),
                {moves ? 1.0f : 0.0f, moves ? -2.0f : 0.0f, 0},
                rule == 1   ? 0.05f
                : rule == 2 ? 0.0f
                            : kAutomaticPatch};
  }
  return pairs;
}

// The same pairs after a small motion.
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

constexpr int kLeastTouching = 2001;  // of the mixed pairs

TEST(CollideBits, EveryInstructionSetGivesTheBitsOfScalar) {
  const Pairs first = mixed_pairs(), second = jittered(first);
  Rows before = first.run(scalar_kernels());
  fill_impulses(before);
  const Rows after = second.run(scalar_kernels(), &before);
  for (const simd::Kernels* kernels : all_kernels()) {
    Rows wide = first.run(*kernels);
    fill_impulses(wide);
    expect_same_bits(before, wide, kernels->name, kLeastTouching);
    expect_same_bits(after, second.run(*kernels, &wide), kernels->name, kLeastTouching);
  }
}

TEST(CollideBits, NeighborsInAChunkChangeNothing) {
  Pairs pairs = mixed_pairs();
  const Rows expected = pairs.run(scalar_kernels());
  std::mt19937 engine(14);
  std::shuffle(pairs.items.begin(), pairs.items.end(), engine);
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_same_bits(expected, pairs.run(*kernels), kernels->name, kLeastTouching);
  }
}

TEST(CollideBits, NonFiniteShapesDoNotTouchAndChangeNoOtherLane) {
  Pairs pairs = mixed_pairs();
  const Rows expected = pairs.run(scalar_kernels());
  for (std::size_t row = 0; row < pairs.items.size(); row += kSpoiledStride) {
    spoil(pairs.pose[static_cast<std::size_t>(pairs.items[row].shape_2)], row);
  }
  for (const simd::Kernels* kernels : all_kernels()) {
    expect_only_spoiled_to_part(expected, pairs.run(*kernels), kernels->name);
  }
}

}  // namespace
}  // namespace scree::collide_tests
