// Queries against a mesh of 1,000,000 triangles: rays, casts, overlaps and distances, and the same rays by
// Embree (if CMake has found it), whose hits are compared. parallel/queries has the figures.
//
// The mesh is a ball of 50 m with hills. Rays begin 100 m from its center and aim into it, so that nearly all
// meet it, in no order: each finds other parts of the mesh than the one before.
#include <benchmark/benchmark.h>
#include <scree/scree.h>
#include <tools/scenes/random.h>

#ifdef SCREE_BENCH_EMBREE
#include <embree3/rtcore.h>
#include <immintrin.h>
#endif

#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

namespace {

using scree::scenes::Random;

constexpr int kRings = 708;  // of as many squares, of two triangles each
constexpr int kQueries = 1 << 15;
constexpr float kRadius = 50.0f;  // m

struct Surface {
  std::vector<scree::Vec3> vertices;
  std::vector<scree::MeshTriangle> triangles;

  Surface() {
    for (int i = 0; i <= kRings; ++i) {
      for (int j = 0; j < kRings; ++j) {
        const double polar = M_PI * i / kRings, turn = 2.0 * M_PI * j / kRings;
        const double size = kRadius * (1.0 + 0.1 * std::sin(9.0 * turn) * std::sin(7.0 * polar) +
                                       0.02 * std::sin(61.0 * turn) * std::sin(53.0 * polar));
        vertices.push_back({static_cast<float>(size * std::sin(polar) * std::cos(turn)),
                            static_cast<float>(size * std::cos(polar)),
                            static_cast<float>(size * std::sin(polar) * std::sin(turn))});
      }
    }
    const auto at = [](int i, int j) { return static_cast<std::uint32_t>(i * kRings + j % kRings); };
    for (int i = 0; i < kRings; ++i) {
      for (int j = 0; j < kRings; ++j) {
        if (i > 0) triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
        if (i < kRings - 1) triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
      }
    }
  }
};

scree::Vec3 direction(Random& random) {
  for (;;) {
    const float x = random.between(-1, 1);
    const float y = random.between(-1, 1);
    const float z = random.between(-1, 1);
    const float square = x * x + y * y + z * z;
    if (square < 1.0f && square > 0.01f) return (1.0f / std::sqrt(square)) * scree::Vec3{x, y, z};
  }
}

struct Scene {
  Surface surface;
  scree::World world;
  std::vector<scree::Ray> rays;
  std::vector<scree::ShapeCast> casts;
  std::vector<scree::Vec3> points;  // near the surface

  Scene() {
    world.add_shape(world.create_body({.type = scree::BodyType::fixed}),
                    scree::TriangleMesh(surface.vertices, surface.triangles));
    Random random(1);
    for (int i = 0; i < kQueries; ++i) {
      const scree::Vec3 origin = 2.0f * kRadius * direction(random);
      const scree::Vec3 aim = random.between(0, kRadius) * direction(random);
      rays.push_back({origin, 2.0f * (aim - origin)});
      casts.push_back({scree::Sphere{0.3f}, {origin, {}}, rays.back().translation});
      points.push_back(kRadius * direction(random));
    }
    cast_ray(world, rays[0]);
  }
};

const Scene& scene() {
  static const Scene made;
  return made;
}

template <class Ask>
void ask_singly(benchmark::State& state, std::size_t count, Ask&& ask) {
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; ++i) benchmark::DoNotOptimize(ask(i));
  }
  state.counters["queries/s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(count), benchmark::Counter::kIsRate);
}

void single_rays(benchmark::State& state) {
  const Scene& s = scene();
  ask_singly(state, kQueries, [&](std::size_t i) { return cast_ray(s.world, s.rays[i]); });
}
BENCHMARK(single_rays)->Unit(benchmark::kMillisecond);

void single_any(benchmark::State& state) {
  const Scene& s = scene();
  ask_singly(state, kQueries, [&](std::size_t i) { return is_blocked(s.world, s.rays[i]); });
}
BENCHMARK(single_any)->Unit(benchmark::kMillisecond);

// Arguments: threads, instruction set.
void many_rays(benchmark::State& state) {
  const Scene& s = scene();
  const auto isa = static_cast<scree::Isa>(state.range(1));
  if (!is_supported(isa)) return state.SkipWithError("not supported");
  scree::Workers workers({.threads = static_cast<int>(state.range(0)), .isa = isa});
  std::vector<std::optional<scree::CastHit>> hits(s.rays.size());
  for (auto _ : state) cast_rays(s.world, s.rays, hits, workers);
  state.counters["queries/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kQueries, benchmark::Counter::kIsRate);
  state.SetLabel(isa_name(isa));
}
BENCHMARK(many_rays)->ArgsProduct({{1, 2}, {1, 2, 3, 4}})->Unit(benchmark::kMillisecond)->UseRealTime();

void single_casts(benchmark::State& state) {
  const Scene& s = scene();
  ask_singly(state, 2048, [&](std::size_t i) { return cast_shape(s.world, s.casts[i]); });
}
BENCHMARK(single_casts)->Unit(benchmark::kMillisecond);

void single_overlaps(benchmark::State& state) {
  const Scene& s = scene();
  ask_singly(state, 2048, [&](std::size_t i) {
    return overlap_shape(s.world, {scree::Box{{0.5f, 0.5f, 0.5f}}, {s.points[i], {}}}).size();
  });
}
BENCHMARK(single_overlaps)->Unit(benchmark::kMillisecond);

void single_closest(benchmark::State& state) {
  const Scene& s = scene();
  ask_singly(state, 2048, [&](std::size_t i) { return closest_to_point(s.world, s.points[i], 100.0f); });
}
BENCHMARK(single_closest)->Unit(benchmark::kMillisecond);

#ifdef SCREE_BENCH_EMBREE

// Embree's scene of the same mesh, made to lose no hit between triangles, as ours is.
struct EmbreeScene {
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = rtcNewScene(device);

  explicit EmbreeScene(const Surface& surface) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), surface.vertices.size()));
    for (const scree::Vec3& v : surface.vertices) {
      for (int axis = 0; axis < 3; ++axis) *vertices++ = v[axis];
    }
    auto* indices =
        static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                       3 * sizeof(unsigned), surface.triangles.size()));
    for (const scree::MeshTriangle& t : surface.triangles) {
      for (const std::uint32_t corner : {t.a, t.b, t.c}) *indices++ = corner;
    }
    rtcCommitGeometry(geometry);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  RTCRayHit cast(const scree::Ray& ray) const {
    RTCRayHit asked{};
    asked.ray.org_x = ray.origin.x;
    asked.ray.org_y = ray.origin.y;
    asked.ray.org_z = ray.origin.z;
    asked.ray.dir_x = ray.translation.x;
    asked.ray.dir_y = ray.translation.y;
    asked.ray.dir_z = ray.translation.z;
    asked.ray.tfar = 1.0f;
    asked.ray.mask = ~0u;
    asked.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &asked);
    return asked;
  }
};

void embree_rays(benchmark::State& state) {
  const Scene& s = scene();
  static const EmbreeScene embree(s.surface);
  const unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8040);  // denormals are zero, as its manual asks for
  ask_singly(state, kQueries, [&](std::size_t i) { return embree.cast(s.rays[i]); });
  _mm_setcsr(before);
  int other_triangle = 0, other_place = 0;
  for (const scree::Ray& ray : s.rays) {
    const std::optional<scree::CastHit> hit = cast_ray(s.world, ray);
    const RTCRayHit theirs = embree.cast(ray);
    const bool is_hit = theirs.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (is_hit == hit.has_value() && (!hit || hit->triangle == static_cast<int>(theirs.hit.primID))) continue;
    ++other_triangle;
    if (is_hit != hit.has_value() || std::abs(hit->fraction - theirs.ray.tfar) > 1e-5f) ++other_place;
  }
  state.counters["other triangle"] = other_triangle;
  state.counters["other place"] = other_place;
}
BENCHMARK(embree_rays)->Unit(benchmark::kMillisecond);

#endif

}  // namespace
