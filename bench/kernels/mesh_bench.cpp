// Building triangle meshes: time, and bytes a triangle.
//
// `terrain` is a hilly grid, whose triangles come row by row; `shuffled` has them and their vertices in
// random order; `soup` has three vertices of its own for each triangle, as an STL file has.
#include <benchmark/benchmark.h>
#include <scree/triangle_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

namespace scree {
namespace {

struct Surface {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;
};

// About as many triangles as asked for.
Surface terrain(std::int64_t triangles) {
  const auto side = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(triangles) / 2)) + 1;
  Surface surface;
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const float x = 0.5f * static_cast<float>(column), z = 0.5f * static_cast<float>(row);
      surface.vertices.push_back({x, 3.0f * std::sin(0.05f * x) * std::cos(0.07f * z), z});
    }
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t first = row * side + column;
      surface.triangles.push_back({first, first + side, first + 1});
      surface.triangles.push_back({first + 1, first + side, first + side + 1});
    }
  }
  return surface;
}

Surface shuffled(std::int64_t triangles) {
  Surface surface = terrain(triangles);
  std::mt19937 random(5);
  std::vector<std::uint32_t> place(surface.vertices.size());
  std::iota(place.begin(), place.end(), 0u);
  std::shuffle(place.begin(), place.end(), random);
  Surface result{std::vector<Vec3>(place.size()), {}};
  for (std::size_t i = 0; i < place.size(); ++i) result.vertices[place[i]] = surface.vertices[i];
  for (const MeshTriangle& t : surface.triangles)
    result.triangles.push_back({place[t.a], place[t.b], place[t.c]});
  std::shuffle(result.triangles.begin(), result.triangles.end(), random);
  return result;
}

Surface soup(std::int64_t triangles) {
  const Surface surface = terrain(triangles);
  Surface result;
  for (const MeshTriangle& t : surface.triangles) {
    const auto first = static_cast<std::uint32_t>(result.vertices.size());
    for (const std::uint32_t corner : {t.a, t.b, t.c}) result.vertices.push_back(surface.vertices[corner]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

void build(benchmark::State& state, Surface (*make)(std::int64_t)) {
  const Surface surface = make(state.range(0));
  std::size_t bytes = 0;
  for (auto _ : state) {
    const TriangleMesh mesh(surface.vertices, surface.triangles);
    bytes = mesh.memory();
    benchmark::DoNotOptimize(bytes);
  }
  const auto triangles = static_cast<double>(surface.triangles.size());
  state.counters["bytes_per_triangle"] = static_cast<double>(bytes) / triangles;
  state.counters["per_triangle"] = benchmark::Counter(
      triangles, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
void report(benchmark::State& state) {
  const Surface surface = terrain(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(inspect_mesh(surface.vertices, surface.triangles).edges);
}

BENCHMARK_CAPTURE(build, terrain, terrain)
    ->RangeMultiplier(100)
    ->Range(100, 1000000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(build, shuffled, shuffled)->Arg(1000000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(build, soup, soup)->Arg(1000000)->Unit(benchmark::kMillisecond);
BENCHMARK(report)->Arg(1000000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace scree
