// Time of hull against hull and box against hull per pair, by vertices and instruction set, cold and with the
// cached axes of the last step. Beside it Box3D's b3CollideHulls on the same hulls and poses, if CMake finds
// Box3D.
//
// Hulls are of random points on a sphere of 1 m, in random poses. Touching pairs overlap by 5 mm, separated
// pairs are 0.05 to 0.3 m apart, so that their bounding spheres overlap. Poses alternate between two sets 1
// mm apart, so that no cached axis fits exactly. Box3D's figure is the function alone; Scree's has everything
// from the bodies' poses to the finished manifold.
//
// ns a pair of processor time, least of 3, g++ 12, one core of an AMD EPYC (family 26) that others were using
// too. 128 vertices are more than Box3D's hulls can hold; such pairs that are apart, their spheres tell:
//                                  scalar   sse2   avx2 avx512  box3d
//   hull_hull/8/touching/cold        2821   1303    538    531   3334
//   hull_hull/8/touching/warm        2156   1075    382    360    504
//   hull_hull/8/separated/cold        545    254     95     96    586
//   hull_hull/8/separated/warm        191     78     25     19     76
//   hull_hull/32/touching/cold       7017   2572    607    546  33856
//   hull_hull/32/touching/warm       4634   1912    401    431    615
//   hull_hull/32/separated/cold       181     78     51     51    674
//   hull_hull/32/separated/warm       110     48     35     34     70
//   hull_hull/128/touching/cold      9220   2778   1588   1137      -
//   hull_hull/128/touching/warm      6188   2196    694    501      -
//   hull_hull/128/separated/cold       19     10      7      7      -
//   hull_hull/128/separated/warm       19     10      7      7      -
//   box_hull/8/touching/cold         2886   1386    466    455   2695
//   box_hull/8/touching/warm         2332   1230    348    314    503
//   box_hull/8/separated/cold         630    330    117    112    418
//   box_hull/8/separated/warm         226    112     30     32     76
//   box_hull/32/touching/cold        5073   2089    541    484   8628
//   box_hull/32/touching/warm        3556   1567    372    335    522
//   box_hull/32/separated/cold        614    278     85     79    715
//   box_hull/32/separated/warm        269    123     30     31    135
//   box_hull/128/touching/cold      14710   5109    916    713      -
//   box_hull/128/touching/warm       9279   3335    712    532      -
//   box_hull/128/separated/cold       236    113     76     71      -
//   box_hull/128/separated/warm       138     62     41     38      -
#include <benchmark/benchmark.h>
#include <core/geometry/hull/hull_build.h>
#include <core/world/column.h>
#include <core/world/math.h>
#include <simd/dispatch/kernels.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#ifdef SCREE_BENCH_BOX3D
#include <box3d/box3d.h>
#endif

namespace {

using namespace scree;

constexpr int kPairs = 2048;
constexpr int kUntimedRounds = 2;  // fill the caches

enum class Placement { touching, separated };

std::vector<Vec3> rock_points(int vertices) {
  std::mt19937 engine(7);
  std::normal_distribution<float> normal;
  std::vector<Vec3> points;
  for (int k = 0; k < vertices; ++k) {
    const Vec3 v{normal(engine), normal(engine), normal(engine)};
    points.push_back(v * (1.0f / length(v)));
  }
  return points;
}

struct Rows {
  Hull hull;
  std::vector<const HullData*> hulls;
  Column<PoseRow> pose[2];  // used alternately
  Column<std::int32_t> shape_hull;
  Column<VelocityRow> velocity;
  Column<ExtentRow> extent;
  Column<MaterialRow> material;
  Column<Manifold> manifold;
  Column<ManifoldFeatures> features;
  Column<ContactSurface> surface;
  Column<ContactAnchor> anchor;
  Column<ContactAxis> axis;
  Column<std::uint8_t> points;
  Column<simd::CollideItem> items;

  simd::CollideColumns columns(int turn) {
    return {.shape_pose = pose[turn].data(),
            .shape_extent = extent.data(),
            .shape_material = material.data(),
            .shape_hull = shape_hull.data(),
            .hulls = hulls.data(),
            .body_pose = pose[turn].data(),
            .body_velocity = velocity.data(),
            .dt = 0.0f,
            .manifold = manifold.data(),
            .features = features.data(),
            .surface = surface.data(),
            .anchor = anchor.data(),
            .axis = axis.data(),
            .points = points.data()};
  }
};

void add_shape(Rows& rows, bool is_box, const PoseRow& pose) {
  rows.shape_hull.push_back(is_box ? -1 : 0);
  for (auto& column : rows.pose) column.push_back(pose);
  const float r = is_box ? 0.0f : rows.hulls[0]->outer_radius;
  rows.extent.push_back(is_box ? ExtentRow{{0.6f, 0.5f, 0.7f}, 0} : ExtentRow{{r, r, r}, r});
  rows.material.push_back({0.6f, 0, 0, 3 | 4 << 8, {0, 0, 0}, kAutomaticPatch});
}

// Distance along `way` at which the pair begins to touch, less the speculative distance, by bisection.
float touching_distance(Rows& rows, simd::CollideType type, int pair, Vec3 way) {
  const std::size_t one = static_cast<std::size_t>(2 * pair);
  const PoseRow& first = rows.pose[0][one];
  PoseRow& second = rows.pose[0][one + 1];
  simd::CollideItem item = rows.items[static_cast<std::size_t>(pair)];
  item.flags = 0;
  float low = 0.0f, high = 3.0f;
  for (int step = 0; step < 16; ++step) {
    const float middle = 0.5f * (low + high);
    second.position[0] = first.position[0] + middle * way.x;
    second.position[1] = first.position[1] + middle * way.y;
    second.position[2] = first.position[2] + middle * way.z;
    simd::widest_kernels().collide.collide[type](rows.columns(0), &item, 1);
    (rows.points[static_cast<std::size_t>(pair)] != 0 ? low : high) = middle;
  }
  return low;
}

std::unique_ptr<Rows> make_rows(simd::CollideType type, int vertices, Placement placement) {
  auto made = std::make_unique<Rows>();
  Rows& rows = *made;
  rows.hull = Hull(rock_points(vertices));
  rows.hulls.push_back(HullAccess::solid(rows.hull)->columns.data);
  std::mt19937 engine(1);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  const auto rotation = [&] {
    return normalize(Quat{normal(engine), normal(engine), normal(engine), normal(engine)});
  };
  rows.manifold.resize(kPairs);
  rows.features.resize(kPairs);
  rows.surface.resize(kPairs);
  rows.anchor.resize(kPairs);
  rows.axis.resize(kPairs);
  rows.points.resize(kPairs);
  rows.velocity.resize(2 * kPairs);
  for (int k = 0; k < kPairs; ++k) {
    const Quat q1 = rotation(), q2 = rotation();
    const float x = float(k % 64) * 5, y = float(k / 64) * 5;
    add_shape(rows, type == simd::kBoxHull, {{x, y, 0}, 0, {q1.x, q1.y, q1.z, q1.w}});
    add_shape(rows, false, {{x, y, 0}, 0, {q2.x, q2.y, q2.z, q2.w}});
    rows.items.push_back({2 * k, 2 * k + 1, 2 * k, 2 * k + 1, k, simd::kItemKnown, k});
  }
  for (int k = 0; k < kPairs; ++k) {
    Vec3 way{normal(engine), normal(engine), normal(engine)};
    way = way * (1.0f / length(way));
    const float start = touching_distance(rows, type, k, way);
    const float distance = placement == Placement::touching ? start - kSpeculativeDistance - 0.005f
                                                            : start + 0.05f + 0.25f * share(engine);
    const std::size_t one = static_cast<std::size_t>(2 * k);
    for (int turn = 0; turn < 2; ++turn) {
      const PoseRow& first = rows.pose[turn][one];
      PoseRow& second = rows.pose[turn][one + 1];
      const float shift = turn == 0 ? 0.0f : 1e-3f;
      second.position[0] = first.position[0] + distance * way.x + shift * way.y;
      second.position[1] = first.position[1] + distance * way.y + shift * way.z;
      second.position[2] = first.position[2] + distance * way.z + shift * way.x;
    }
  }
  for (Manifold& m : rows.manifold) m = {};
  for (ContactAxis& a : rows.axis) a = {};
  return made;
}

void report(benchmark::State& state, int touching) {
  state.counters["touching"] = double(touching) / kPairs;
  state.counters["ns_per_pair"] = benchmark::Counter(
      kPairs * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void run(benchmark::State& state, const simd::Kernels& kernels, simd::CollideType type, int vertices,
         Placement placement, bool cold) {
  const std::unique_ptr<Rows> rows = make_rows(type, vertices, placement);
  if (cold) {
    for (simd::CollideItem& item : rows->items) item.flags = 0;
  }
  int turn = 0;
  const auto collide_all = [&] {
    const simd::CollideColumns columns = rows->columns(turn);
    if (cold) std::fill(rows->axis.begin(), rows->axis.end(), ContactAxis{});
    for (int begin = 0; begin < kPairs; begin += simd::kCollideChunk) {
      kernels.collide.collide[type](columns, rows->items.data() + begin, simd::kCollideChunk);
    }
    turn = 1 - turn;
  };
  for (int round = 0; round < kUntimedRounds; ++round) collide_all();
  for (auto _ : state) collide_all();
  int touching = 0;
  for (const std::uint8_t points : rows->points) touching += points != 0 ? 1 : 0;
  report(state, touching);
}

#ifdef SCREE_BENCH_BOX3D

b3Transform transform_of(const PoseRow& pose) {
  const float *p = pose.position, *q = pose.rotation;
  return {{p[0], p[1], p[2]}, {{q[0], q[1], q[2]}, q[3]}};
}

void run_box3d(benchmark::State& state, simd::CollideType type, int vertices, Placement placement,
               bool cold) {
  const std::unique_ptr<Rows> rows = make_rows(type, vertices, placement);
  std::vector<b3Vec3> points;
  const auto* data = rows->hulls[0];  // about the centroid, as the poses have it
  for (int k = 0; k < data->vertex_count; ++k) {
    points.push_back({data->vertex[0][k], data->vertex[1][k], data->vertex[2][k]});
  }
  b3HullData* hull = b3CreateHull(points.data(), static_cast<int>(points.size()), 256);
  if (hull == nullptr) {
    state.SkipWithError("more than Box3D's hulls can hold");
    return;
  }
  const b3BoxHull box = b3MakeBoxHull(0.6f, 0.5f, 0.7f);
  const b3HullData* first = type == simd::kBoxHull ? &box.base : hull;
  std::vector<b3Transform> second_to_first[2];
  for (int turn = 0; turn < 2; ++turn) {
    for (std::size_t k = 0; k < kPairs; ++k) {
      second_to_first[turn].push_back(b3InvMulTransforms(transform_of(rows->pose[turn][2 * k]),
                                                         transform_of(rows->pose[turn][2 * k + 1])));
    }
  }
  std::vector<b3SATCache> caches(kPairs);
  b3LocalManifoldPoint buffer[32];
  int turn = 0, touching = 0;
  const auto collide_all = [&] {
    touching = 0;
    for (std::size_t k = 0; k < kPairs; ++k) {
      if (cold) caches[k] = {};
      b3LocalManifold manifold{};
      manifold.points = buffer;
      b3CollideHulls(&manifold, 32, first, hull, second_to_first[turn][k], &caches[k]);
      touching += manifold.pointCount > 0 ? 1 : 0;
    }
    turn = 1 - turn;
  };
  for (int round = 0; round < kUntimedRounds; ++round) collide_all();
  for (auto _ : state) collide_all();
  b3DestroyHull(hull);
  report(state, touching);
}

#endif

void register_all() {
  for (const simd::CollideType type : {simd::kHullHull, simd::kBoxHull}) {
    for (const int vertices : {8, 32, 128}) {
      for (const Placement placement : {Placement::touching, Placement::separated}) {
        for (const bool cold : {true, false}) {
          const std::string name =
              std::string(type == simd::kHullHull ? "hull_hull/" : "box_hull/") + std::to_string(vertices) +
              (placement == Placement::touching ? "/touching" : "/separated") + (cold ? "/cold/" : "/warm/");
          for (int set = 0; set < simd::kInstructionSetCount; ++set) {
            const simd::Kernels* kernels = simd::find_kernels(static_cast<simd::InstructionSet>(set));
            if (kernels == nullptr) continue;
            benchmark::RegisterBenchmark((name + kernels->name).c_str(), [=](benchmark::State& state) {
              run(state, *kernels, type, vertices, placement, cold);
            });
          }
#ifdef SCREE_BENCH_BOX3D
          benchmark::RegisterBenchmark((name + "box3d").c_str(), [=](benchmark::State& state) {
            run_box3d(state, type, vertices, placement, cold);
          });
#endif
        }
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  register_all();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
