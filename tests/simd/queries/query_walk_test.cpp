// Laws of the walks through trees: they come to every shape that may count, and in the same order for every
// instruction set.
#include <tests/simd/all_kernels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace scree {
namespace {

using kernel_tests::all_kernels;

constexpr float kLargestFloat = 3.402823466e38f;

// A tree of random boxes.
struct Grove {
  std::vector<BoundsRow> bounds;
  std::vector<std::int32_t> order;
  std::vector<simd::LeafBlock> leaves;
  std::vector<std::vector<simd::NodeBlock>> nodes;
  simd::TreeView view{};

  Grove(unsigned seed, int count, float reach) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(-reach, reach), size(0.01f, 1.0f);
    for (int i = 0; i < count; ++i) {
      BoundsRow row{};
      for (int axis = 0; axis < 3; ++axis) {
        row.lower[axis] = place(random);
        const float extent = size(random);
        row.upper[axis] = row.lower[axis] + extent;
      }
      if (i % 37 == 5) {  // of a shape that is nowhere
        for (int axis = 0; axis < 3; ++axis)
          row.lower[axis] = kLargestFloat, row.upper[axis] = -kLargestFloat;
      }
      bounds.push_back(row);
      order.push_back(i % 11 == 3 ? -1 : i);
    }
    while (order.size() % simd::kBlock != 0) order.push_back(-1);
    leaves.resize(order.size() / simd::kBlock);
    std::size_t blocks = leaves.size();
    while (nodes.empty() || blocks > 1) {
      const std::size_t parents = (blocks + simd::kBlock - 1) / simd::kBlock;
      nodes.emplace_back(parents);
      for (simd::NodeBlock& node : nodes.back()) {
        for (int child = 0; child < simd::kBlock; ++child) {
          for (int axis = 0; axis < 3; ++axis) {
            node.bounds[axis][child] = kLargestFloat;
            node.bounds[axis + 3][child] = -kLargestFloat;
          }
        }
      }
      blocks = parents;
    }
    const simd::PairKernels& kernels = kernel_tests::scalar_kernels().pair;
    kernels.refit_leaves({order.data(), bounds.data(), leaves.data(), nodes[0].data()}, 0,
                         static_cast<int>(leaves.size()));
    view.leaves = leaves.data();
    view.levels = static_cast<int>(nodes.size());
    for (int level = 0; level < view.levels; ++level) {
      const auto at = static_cast<std::size_t>(level);
      view.nodes[level] = nodes[at].data();
      if (level == 0) continue;
      kernels.refit_nodes(nodes[at - 1].data(), nodes[at].data(), 0, static_cast<int>(nodes[at - 1].size()));
    }
  }
  bool holds(int shape) const { return order[static_cast<std::size_t>(shape)] >= 0; }
};

struct Asked {
  std::vector<std::int32_t> shapes;
  float factor = 1.0f;  // of the limit, at each shape
};

float note(void* context, std::int32_t shape, float limit) {
  Asked& asked = *static_cast<Asked*>(context);
  asked.shapes.push_back(shape);
  return limit * asked.factor;
}

simd::CrossTask crossing(std::mt19937& random, float reach, bool thick) {
  std::uniform_real_distribution<float> place(-reach, reach);
  simd::CrossTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    task.origin[axis] = place(random);
    const float way = place(random) * (axis == 1 && thick ? 0.0f : 1.0f);
    task.inverse[axis] = way != 0.0f ? 1.0f / way : std::copysign(simd::kLargestInverse, way);
    task.half[axis] = thick ? 0.3f : 0.0f;
  }
  return task;
}

// Where the moving box enters a box, in double precision; above 1: nowhere.
double entry(const simd::CrossTask& task, const BoundsRow& row) {
  double enters = 0.0, leaves = 1.0;
  if (row.lower[0] > row.upper[0]) return 2.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = double{row.lower[axis]} - task.half[axis] - task.origin[axis];
    const double high = double{row.upper[axis]} + task.half[axis] - task.origin[axis];
    const double a = low * task.inverse[axis], b = high * task.inverse[axis];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  return enters <= leaves ? enters : 2.0;
}

TEST(QueryWalk, ComesToEveryBoxThatARayOrAMovingBoxEnters) {
  for (const int count : {1, 16, 17, 300, 5000}) {
    const Grove grove(static_cast<unsigned>(count), count, 10.0f);
    std::mt19937 random(3);
    for (int i = 0; i < 100; ++i) {
      const simd::CrossTask task = crossing(random, 12.0f, i % 2 == 0);
      for (const simd::Kernels* kernels : all_kernels()) {
        Asked asked;
        kernels->query.cross(grove.view, task, 1.0f, note, &asked);
        std::sort(asked.shapes.begin(), asked.shapes.end());
        EXPECT_EQ(std::adjacent_find(asked.shapes.begin(), asked.shapes.end()), asked.shapes.end());
        for (int shape = 0; shape < count; ++shape) {
          const double at = entry(task, grove.bounds[static_cast<std::size_t>(shape)]);
          const bool was_asked = std::binary_search(asked.shapes.begin(), asked.shapes.end(), shape);
          if (!grove.holds(shape)) {
            EXPECT_FALSE(was_asked);
          } else if (at <= 1.0) {
            EXPECT_TRUE(was_asked) << shape;
          }
        }
      }
    }
  }
}

TEST(QueryWalk, ComesToEveryBoxThatIsMetOrNear) {
  const Grove grove(5, 2000, 10.0f);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> place(-11.0f, 11.0f);
  for (int i = 0; i < 100; ++i) {
    simd::MeetTask task{};
    for (int axis = 0; axis < 3; ++axis) {
      task.lower[axis] = place(random);
      task.upper[axis] = task.lower[axis] + 0.5f;
    }
    for (const simd::Kernels* kernels : all_kernels()) {
      Asked met, near;
      kernels->query.meet(grove.view, task, 0.0f, note, &met);
      kernels->query.approach(grove.view, task, 4.0f, note, &near);
      std::sort(met.shapes.begin(), met.shapes.end());
      std::sort(near.shapes.begin(), near.shapes.end());
      for (int shape = 0; shape < 2000; ++shape) {
        const BoundsRow& row = grove.bounds[static_cast<std::size_t>(shape)];
        double square = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
          const double apart = std::max(
              {double{row.lower[axis]} - task.upper[axis], double{task.lower[axis]} - row.upper[axis], 0.0});
          square += apart * apart;
        }
        const bool counts = grove.holds(shape);
        EXPECT_EQ(std::binary_search(met.shapes.begin(), met.shapes.end(), shape), counts && square == 0.0);
        const bool was_near = std::binary_search(near.shapes.begin(), near.shapes.end(), shape);
        if (counts && square <= 4.0) {
          EXPECT_TRUE(was_near);
        }
        if (!counts || square > 4.001) {
          EXPECT_FALSE(was_near);
        }
      }
    }
  }
}

TEST(QueryWalk, AsksInTheSameOrderForEveryInstructionSet) {
  const Grove grove(6, 3000, 10.0f);
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    const simd::CrossTask task = crossing(random, 12.0f, i % 2 == 0);
    const simd::MeetTask box{{task.origin[0], task.origin[1], task.origin[2]},
                             {task.origin[0] + 1, task.origin[1] + 1, task.origin[2] + 1}};
    for (const float factor : {1.0f, 0.9f, -1.0f}) {
      Asked expected[2];
      for (const simd::Kernels* kernels : all_kernels()) {
        Asked asked[2]{{{}, factor}, {{}, factor}};
        kernels->query.cross(grove.view, task, 1.0f, note, &asked[0]);
        kernels->query.approach(grove.view, box, 9.0f, note, &asked[1]);
        for (int which = 0; which < 2; ++which) {
          if (kernels->lanes == 1) expected[which] = asked[which];
          EXPECT_EQ(asked[which].shapes, expected[which].shapes);
          if (factor < 0.0f) {
            EXPECT_LE(asked[which].shapes.size(), 1u);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace scree
