// Time of the collide kernels per pair, by type pair and instruction set, on boxes, capsules and spheres of
// about 1 m in random poses.
//
// ns a pair of processor time, least of 3, g++ 12, one core of an AMD EPYC (family 26) that others were using
// too:
//                              scalar   sse2   avx2  avx512
//   sphere_sphere   touching     34.2   18.1   14.2   13.3
//                   separated     3.2    2.9    2.8    3.3
//   sphere_capsule  touching     55.4   23.2   16.4   13.8
//                   separated     6.6    4.6    3.4    3.4
//   sphere_box      touching     78.0   23.9   17.0   14.9
//                   separated     9.0    4.5    3.4    3.5
//   capsule_capsule touching    116.4   38.6   24.9   18.9
//                   separated    20.2   10.1    8.3    6.2
//   capsule_box     touching    330.5   76.4   40.4   26.8
//                   separated    31.6   19.7   12.5    9.5
//   box_box         touching    451.7  125.0   58.5   41.1
//                   resting     299.1  112.5   53.5   38.3
//                   separated    62.5   30.7   18.9   13.6
#include <benchmark/benchmark.h>
#include <core/world/column.h>
#include <core/world/math.h>
#include <simd/dispatch/kernels.h>

#include <cmath>
#include <random>
#include <string>

namespace {

using namespace scree;

constexpr int kPairs = 4096;  // 2 MiB of rows: in the second-level cache, as in a step over a moderate scene

enum class Placement { touching, separated, resting };

struct Rows {
  Column<PoseRow> pose;
  Column<VelocityRow> velocity;
  Column<ExtentRow> extent;
  Column<MaterialRow> material;
  Column<Manifold> manifold;
  Column<ManifoldFeatures> features;
  Column<ContactSurface> surface;
  Column<ContactAnchor> anchor;
  Column<std::uint8_t> points;
  Column<simd::CollideItem> items;
};

enum Kind { kSphere, kCapsule, kBox };

ExtentRow extent_of(Kind kind) {
  if (kind == kSphere) return {{0, 0, 0}, 0.5f};
  if (kind == kCapsule) return {{0, 0.4f, 0}, 0.3f};
  return {{0.5f, 0.4f, 0.3f}, 0};
}

void add_row(Rows& rows, Kind kind, const float position[3], Quat q) {
  rows.pose.push_back({{position[0], position[1], position[2]}, 0, {q.x, q.y, q.z, q.w}});
  rows.extent.push_back(extent_of(kind));
  rows.material.push_back({0.6f, 0, 0, 3 | 4 << 8, {0, 0, 0}, kAutomaticPatch});
}

Rows make_rows(Kind first, Kind second, Placement placement) {
  Rows rows;
  std::mt19937 engine(1);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> shift(-0.3f, 0.3f);
  for (int k = 0; k < kPairs; ++k) {
    const Quat q1 = normalize(Quat{normal(engine), normal(engine), normal(engine), normal(engine)});
    Quat q2 = normalize(Quat{normal(engine), normal(engine), normal(engine), normal(engine)});
    Vec3 way{normal(engine), normal(engine), normal(engine)};
    // Random poses touch at 0.6 m; at 1.25 m they are mostly apart, though bounding spheres often touch.
    way = way * ((placement == Placement::touching ? 0.6f : 1.25f) / length(way));
    if (placement == Placement::resting) {
      q2 = q1;
      way = rotate(q1, {shift(engine), shift(engine), 0.597f});
    }
    const float p1[3] = {float(k % 64) * 5, float(k / 64) * 5, 0};
    const float p2[3] = {p1[0] + way.x, p1[1] + way.y, p1[2] + way.z};
    add_row(rows, first, p1, q1);
    add_row(rows, second, p2, q2);
    rows.items.push_back({2 * k, 2 * k + 1, 2 * k, 2 * k + 1, k, simd::kItemKnown, 0});
  }
  rows.manifold.resize(kPairs);
  rows.features.resize(kPairs);
  rows.surface.resize(kPairs);
  rows.anchor.resize(kPairs);
  rows.velocity.resize(rows.pose.size());
  rows.points.resize(kPairs);
  return rows;
}

void run(benchmark::State& state, const simd::Kernels& kernels, simd::CollideType type, Kind first,
         Kind second, Placement placement) {
  Rows rows = make_rows(first, second, placement);
  const simd::CollideColumns columns{.shape_pose = rows.pose.data(),
                                     .shape_extent = rows.extent.data(),
                                     .shape_material = rows.material.data(),
                                     .body_pose = rows.pose.data(),
                                     .body_velocity = rows.velocity.data(),
                                     .dt = 0.0f,
                                     .manifold = rows.manifold.data(),
                                     .features = rows.features.data(),
                                     .surface = rows.surface.data(),
                                     .anchor = rows.anchor.data(),
                                     .points = rows.points.data()};
  for (auto _ : state) {
    for (int begin = 0; begin < kPairs; begin += simd::kCollideChunk) {
      kernels.collide.collide[type](columns, rows.items.data() + begin, simd::kCollideChunk);
    }
  }
  int touching = 0;
  for (const std::uint8_t points : rows.points) touching += points != 0 ? 1 : 0;
  state.counters["touching"] = double(touching) / kPairs;
  state.counters["ns_per_pair"] = benchmark::Counter(
      kPairs * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void register_all() {
  struct Type {
    simd::CollideType type;
    Kind first, second;
    const char* name;
  };
  const Type types[] = {{simd::kSphereSphere, kSphere, kSphere, "sphere_sphere"},
                        {simd::kSphereCapsule, kSphere, kCapsule, "sphere_capsule"},
                        {simd::kSphereBox, kSphere, kBox, "sphere_box"},
                        {simd::kCapsuleCapsule, kCapsule, kCapsule, "capsule_capsule"},
                        {simd::kCapsuleBox, kCapsule, kBox, "capsule_box"},
                        {simd::kBoxBox, kBox, kBox, "box_box"}};
  for (const Type& type : types) {
    for (int set = 0; set < simd::kInstructionSetCount; ++set) {
      const simd::Kernels* kernels = simd::find_kernels(static_cast<simd::InstructionSet>(set));
      if (kernels == nullptr) continue;
      const auto add = [&](Placement placement, const char* name) {
        benchmark::RegisterBenchmark(
            (std::string("collide/") + type.name + "/" + name + "/" + kernels->name).c_str(),
            [=](benchmark::State& state) {
              run(state, *kernels, type.type, type.first, type.second, placement);
            });
      };
      add(Placement::touching, "touching");
      add(Placement::separated, "separated");
      if (type.type == simd::kBoxBox) add(Placement::resting, "resting");
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
