// Time of the kernels for spheres and capsules on hulls per pair, by corners of the hull and instruction set.
// Beside it Box3D's functions, if its library is found.
//
// Hulls of about 1 m with their corners on a sphere (8: a box), in random poses. "touching" pairs overlap by
// 0 to 2 cm. "resting" pairs have a capsule's side on a face. "separated" pairs are 3 to 15 cm apart:
// bounding spheres often touch. Box3D's functions run warm, each with last time's cache, and give a bare
// contact without materials, impulses and identities. Its hulls have at most 128 edges: where ours have 128
// corners, its hulls have 44.
//
// ns a pair of processor time, one run, g++ 12, one core of an AMD EPYC (family 26) that others used too:
//                               scalar    sse2    avx2  avx512   box3d
//   sphere_hull8    touching      123      68      44      45      95
//   sphere_hull8    separated      43      18      10      10     133
//   sphere_hull32   touching      401     197      90      91     173
//   sphere_hull32   separated      40      12       7       6     256
//   sphere_hull128  touching      907     429     235     182     255
//   sphere_hull128  separated      31      11       8       7     393
//   capsule_hull8   touching      407     186     137     153     337
//   capsule_hull8   resting       193     114      82     115     468
//   capsule_hull8   separated     167      65      44      45     285
//   capsule_hull32  touching     1298     470     306     277     757
//   capsule_hull32  resting      1156     421     284     255     866
//   capsule_hull32  separated      97      33      21      18     506
//   capsule_hull128 touching     2265     655     330     251     944
//   capsule_hull128 resting      1256     540     310     226     827
//   capsule_hull128 separated      33       9       7       6     440
#include <benchmark/benchmark.h>
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/reference/collide_hull_round.h>
#include <core/world/column.h>
#include <core/world/math.h>
#include <simd/dispatch/kernels.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#ifdef SCREE_BENCH_BOX3D
#include <box3d/collision.h>
#endif

namespace {

using namespace scree;
using reference::Vector;

constexpr int kPairs = 2048;
constexpr int kPlaces = 128;  // number of different poses; finding them takes time

enum class Placement { touching, resting, separated };

struct TestHull {
  std::shared_ptr<const HullSolid> solid;
  std::vector<Vector> corners;
  std::vector<std::vector<int>> faces;
  ExtentRow extent{};
};

const TestHull& hull_with(int corners) {
  static std::map<int, TestHull> hulls;
  TestHull& hull = hulls[corners];
  if (hull.solid != nullptr) return hull;
  std::vector<Vec3> points;
  for (int k = 0; k < corners; ++k) {
    if (corners == 8) {
      points.push_back(
          {(k & 1) != 0 ? 0.5f : -0.5f, (k & 2) != 0 ? 0.4f : -0.4f, (k & 4) != 0 ? 0.3f : -0.3f});
    } else {
      const float y = 1.0f - 2.0f * (float(k) + 0.5f) / float(corners), angle = 2.3999632f * float(k);
      const float r = std::sqrt(1.0f - y * y);
      points.push_back({0.5f * r * std::cos(angle), 0.5f * y, 0.5f * r * std::sin(angle)});
    }
  }
  hull.solid = build_hull("bench", points, {});
  const HullTopology& topology = hull.solid->topology;
  for (const Vec3& v : topology.vertices) {
    hull.corners.emplace_back(v.x, v.y, v.z);
    const float along[3] = {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
    for (int k = 0; k < 3; ++k) hull.extent.half[k] = std::max(hull.extent.half[k], along[k]);
  }
  for (std::size_t f = 0; f + 1 < topology.begin.size(); ++f) {
    hull.faces.emplace_back(topology.loops.begin() + topology.begin[f],
                            topology.loops.begin() + topology.begin[f + 1]);
  }
  hull.extent.radius = hull.solid->columns.data->outer_radius;
  return hull;
}

ExtentRow round_extent(bool is_sphere) {
  return is_sphere ? ExtentRow{{0, 0, 0}, 0.4f} : ExtentRow{{0, 0.4f, 0}, 0.3f};
}

struct Place {
  PoseRow round, hull;
};
Vector random_vector(std::mt19937& engine) {
  std::normal_distribution<double> normal;
  return {normal(engine), normal(engine), normal(engine)};
}
PoseRow pose_of(const Vector& p, const Eigen::Quaterniond& q) {
  return {{float(p.x()), float(p.y()), float(p.z())},
          0,
          {float(q.x()), float(q.y()), float(q.z()), float(q.w())}};
}

// The capsule's side on a random face.
Place resting_place(const TestHull& hull, float radius, const Eigen::Quaterniond& turn,
                    std::mt19937& engine) {
  const std::vector<int>& face = hull.faces[engine() % hull.faces.size()];
  const Vector normal = reference::normal_of(hull.corners, face);
  Vector middle = Vector::Zero();
  for (const int corner : face)
    middle += hull.corners[static_cast<std::size_t>(corner)] / double(face.size());
  Eigen::Matrix3d axes;
  axes.col(1) = normal.cross(random_vector(engine)).normalized();
  axes.col(2) = normal;
  axes.col(0) = axes.col(1).cross(axes.col(2));
  const Eigen::Quaterniond lying(turn * Eigen::Quaterniond(axes));
  return {pose_of(turn * (middle + (double(radius) - 0.003) * normal), lying), pose_of(Vector::Zero(), turn)};
}

std::vector<Place> find_places(const TestHull& hull, bool is_sphere, Placement placement) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> overlap(-0.02, 0.0), apart(0.03, 0.15);
  const ExtentRow extent = round_extent(is_sphere);
  std::vector<Place> places;
  for (int k = 0; k < kPlaces; ++k) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(Eigen::AngleAxisd(double(k), random_vector(engine).normalized()));
    if (placement == Placement::resting) {
      places.push_back(resting_place(hull, extent.radius, turn, engine));
      continue;
    }
    const Eigen::Quaterniond other(Eigen::AngleAxisd(double(k), random_vector(engine).normalized()));
    Place place{pose_of(random_vector(engine).normalized(), other), pose_of(Vector::Zero(), turn)};
    const double gap = placement == Placement::touching ? overlap(engine) : apart(engine);
    const reference::FacedHull solid = reference::make_faced_hull(hull.corners, hull.faces, place.hull);
    for (int step = 0; step < 3; ++step) {
      double core;
      const reference::Gap now = reference::gap_to_hull(
          reference::make_solid(is_sphere ? ShapeType::sphere : ShapeType::capsule, extent, place.round),
          solid, core);
      for (int axis = 0; axis < 3; ++axis) {
        place.round.position[axis] += float((now.separation - gap) * now.normal[axis]);
      }
    }
    places.push_back(place);
  }
  return places;
}
const std::vector<Place>& places_of(int corners, bool is_sphere, Placement placement) {
  static std::map<std::tuple<int, bool, Placement>, std::vector<Place>> found;
  std::vector<Place>& places = found[{corners, is_sphere, placement}];
  if (places.empty()) places = find_places(hull_with(corners), is_sphere, placement);
  return places;
}

struct Rows {
  Column<PoseRow> pose;
  Column<VelocityRow> velocity;
  Column<ExtentRow> extent;
  Column<MaterialRow> material;
  Column<std::int32_t> shape_hull;
  Column<Manifold> manifold;
  Column<ManifoldFeatures> features;
  Column<ContactSurface> surface;
  Column<ContactAnchor> anchor;
  Column<std::uint8_t> points;
  Column<simd::CollideItem> items;
};

Rows make_rows(int corners, bool is_sphere, Placement placement) {
  const std::vector<Place>& places = places_of(corners, is_sphere, placement);
  Rows rows;
  for (int k = 0; k < kPairs; ++k) {
    const Place& place = places[static_cast<std::size_t>(k % kPlaces)];
    rows.pose.push_back(place.round);
    rows.pose.push_back(place.hull);
    rows.extent.push_back(round_extent(is_sphere));
    rows.extent.push_back(hull_with(corners).extent);
    rows.shape_hull.push_back(-1);
    rows.shape_hull.push_back(0);
    for (int side = 0; side < 2; ++side)
      rows.material.push_back({0.6f, 0, 0, 3 | 4 << 8, {0, 0, 0}, kAutomaticPatch});
    rows.items.push_back({2 * k, 2 * k + 1, 2 * k, 2 * k + 1, k, simd::kItemKnown, 0});
  }
  rows.velocity.resize(rows.pose.size());
  rows.manifold.resize(kPairs);
  rows.features.resize(kPairs);
  rows.surface.resize(kPairs);
  rows.anchor.resize(kPairs);
  rows.points.resize(kPairs);
  return rows;
}

void report(benchmark::State& state, int touching) {
  state.counters["touching"] = double(touching) / kPairs;
  state.counters["ns_per_pair"] = benchmark::Counter(
      kPairs * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void run(benchmark::State& state, const simd::Kernels& kernels, int corners, bool is_sphere,
         Placement placement) {
  Rows rows = make_rows(corners, is_sphere, placement);
  const HullData* const hulls[1] = {hull_with(corners).solid->columns.data};
  simd::CollideColumns columns{};
  columns.shape_pose = columns.body_pose = rows.pose.data();
  columns.shape_extent = rows.extent.data();
  columns.shape_material = rows.material.data();
  columns.shape_hull = rows.shape_hull.data();
  columns.hulls = hulls;
  columns.body_velocity = rows.velocity.data();
  columns.manifold = rows.manifold.data();
  columns.features = rows.features.data();
  columns.surface = rows.surface.data();
  columns.anchor = rows.anchor.data();
  columns.points = rows.points.data();
  const simd::CollideType type = is_sphere ? simd::kSphereHull : simd::kCapsuleHull;
  for (auto _ : state) {
    for (int begin = 0; begin < kPairs; begin += simd::kCollideChunk) {
      kernels.collide.collide[type](columns, rows.items.data() + begin, simd::kCollideChunk);
    }
  }
  int touching = 0;
  for (const std::uint8_t points : rows.points) touching += points != 0 ? 1 : 0;
  report(state, touching);
}

#ifdef SCREE_BENCH_BOX3D
b3Transform to_box3d(const PoseRow& pose) {
  return {{pose.position[0], pose.position[1], pose.position[2]},
          {{pose.rotation[0], pose.rotation[1], pose.rotation[2]}, pose.rotation[3]}};
}

void run_box3d(benchmark::State& state, int corners, bool is_sphere, Placement placement) {
  std::vector<b3Vec3> points;
  for (const Vec3& v : hull_with(corners).solid->topology.vertices) points.push_back({v.x, v.y, v.z});
  constexpr int kMostCorners = 44;  // Box3D allows 128 edges
  b3HullData* hull = b3CreateHull(points.data(), corners, std::min(corners, kMostCorners));
  if (hull == nullptr) {
    state.SkipWithError("Box3D makes no hull of these corners");
    return;
  }
  const std::vector<Place>& places = places_of(corners, is_sphere, placement);
  const ExtentRow extent = round_extent(is_sphere);
  const b3Sphere sphere{{0, 0, 0}, extent.radius};
  const b3Capsule capsule{{0, -extent.half[1], 0}, {0, extent.half[1], 0}, extent.radius};
  std::vector<b3Transform> to_hull;
  for (const Place& place : places) {
    to_hull.push_back(b3InvMulTransforms(to_box3d(place.hull), to_box3d(place.round)));
  }
  std::vector<b3SimplexCache> caches(kPairs);
  b3LocalManifoldPoint buffer[4];
  int touching = 0;
  for (auto _ : state) {
    touching = 0;
    for (int k = 0; k < kPairs; ++k) {
      b3LocalManifold manifold{};
      manifold.points = buffer;
      const b3Transform& pose = to_hull[static_cast<std::size_t>(k % kPlaces)];
      b3SimplexCache* cache = &caches[static_cast<std::size_t>(k)];
      if (is_sphere) {
        b3CollideHullAndSphere(&manifold, 4, hull, &sphere, pose, cache);
      } else {
        b3CollideHullAndCapsule(&manifold, 4, hull, &capsule, pose, cache);
      }
      touching += manifold.pointCount > 0 ? 1 : 0;
    }
    benchmark::DoNotOptimize(touching);
  }
  report(state, touching);
  state.counters["corners"] = hull->vertexCount;
  b3DestroyHull(hull);
}
#endif

void register_all() {
  struct Named {
    Placement placement;
    const char* name;
  };
  const Named placements[] = {{Placement::touching, "touching"},
                              {Placement::resting, "resting"},
                              {Placement::separated, "separated"}};
  for (const bool is_sphere : {true, false}) {
    for (const int corners : {8, 32, 128}) {
      for (const Named& named : placements) {
        if (is_sphere && named.placement == Placement::resting) continue;
        const std::string name = std::string("collide/") + (is_sphere ? "sphere" : "capsule") + "_hull" +
                                 std::to_string(corners) + "/" + named.name + "/";
        for (int set = 0; set < simd::kInstructionSetCount; ++set) {
          const simd::Kernels* kernels = simd::find_kernels(static_cast<simd::InstructionSet>(set));
          if (kernels == nullptr) continue;
          benchmark::RegisterBenchmark((name + kernels->name).c_str(), [=](benchmark::State& state) {
            run(state, *kernels, corners, is_sphere, named.placement);
          });
        }
#ifdef SCREE_BENCH_BOX3D
        benchmark::RegisterBenchmark((name + "box3d").c_str(), [=](benchmark::State& state) {
          run_box3d(state, corners, is_sphere, named.placement);
        });
#endif
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
