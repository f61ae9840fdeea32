// Contact and body kernels on the resting contacts of a pyramid of boxes: 5,050 bodies, 14,950 manifolds of
// four points. One thread; time per manifold (or body) and pass, per instruction set.
#include <benchmark/benchmark.h>
#include <parallel/constraints/constraints.h>
#include <parallel/stages.h>

#include <memory>
#include <string>
#include <vector>

namespace {

using namespace scree;

constexpr int kBase = 100;

// A contact of two boxes of half-extent 0.5 at distance one along the normal.
Manifold face_contact(const Vec3& center_a, const Vec3& center_b, const Vec3& normal, std::int32_t a,
                      std::int32_t b, float half_u, float half_v, bool is_static) {
  Manifold manifold{};
  const Vec3 middle{0.5f * (center_a.x + center_b.x), 0.5f * (center_a.y + center_b.y),
                    0.5f * (center_a.z + center_b.z)};
  const float n[3] = {normal.x, normal.y, normal.z};
  const float arm_a[3] = {middle.x - center_a.x, middle.y - center_a.y, middle.z - center_a.z};
  const float arm_b[3] = {middle.x - center_b.x, middle.y - center_b.y, middle.z - center_b.z};
  const float signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int i = 0; i < 3; ++i) {
    manifold.normal[i] = n[i];
    manifold.arm_a[i] = arm_a[i];
    manifold.arm_b[i] = arm_b[i];
  }
  for (int k = 0; k < 4; ++k) {
    manifold.point_u[k] = signs[k][0] * half_u;
    manifold.point_v[k] = signs[k][1] * half_v;
    manifold.separation[k] = -0.001f;
    manifold.normal_impulse[k] = 1.0f;
  }
  manifold.friction = 0.6f;
  manifold.row_a = a;
  manifold.row_b = b;
  manifold.info = 4u | (is_static ? kManifoldStatic : 0u);
  return manifold;
}

void add_row(WorldData& data, const Manifold& manifold) {
  const std::size_t row = data.contacts.now.pair.size();
  data.contacts.now.resize(row + 1);
  data.contacts.now.manifold[row] = manifold;
  data.contacts.now.color[row] = kNoColor;
  data.contacts.active.push_back(static_cast<std::int32_t>(row));
}

std::unique_ptr<WorldData> make_pyramid() {
  auto data = std::make_unique<WorldData>();
  const int count = kBase * (kBase + 1) / 2;
  data->bodies.resize(static_cast<std::size_t>(kFirstBody + count));
  std::vector<Vec3> centers(static_cast<std::size_t>(kFirstBody + count));
  std::vector<std::vector<std::int32_t>> grid(kBase);
  std::int32_t body = kFirstBody;
  for (int i = 0; i < kBase; ++i) {
    for (int j = i; j < kBase; ++j, ++body) {
      const auto index = static_cast<std::size_t>(body);
      centers[index] = {0.5f * static_cast<float>(i + 1) + static_cast<float>(j - i),
                        static_cast<float>(i) + 0.5f, 0};
      grid[static_cast<std::size_t>(i)].push_back(body);
      data->bodies.pose[index].rotation[3] = 1.0f;
      data->bodies.local_mass[index] = {{0.06f, 0, 0, 0.06f, 0, 0.06f}, 0.01f, 0};
      data->bodies.local_mass[index].inverse_inertia[5] = 0.06f;
      data->bodies.mass[index] = 100.0f;
      data->bodies.motion[index].gravity_factor = 1.0f;
      data->bodies.type[index] = BodyType::dynamic;
      data->bodies.awake.push_back(body);
    }
  }
  for (int i = 0; i < kBase; ++i) {
    const auto& row = grid[static_cast<std::size_t>(i)];
    for (std::size_t j = 0; j < row.size(); ++j) {
      const Vec3 center = centers[static_cast<std::size_t>(row[j])];
      if (i == 0) {
        const Vec3 ground{center.x, -0.5f, 0};
        add_row(*data, face_contact(ground, center, {0, 1, 0}, kFixedRow, row[j], 0.5f, 0.5f, true));
      } else {
        for (std::size_t side = 0; side < 2; ++side) {
          const std::int32_t below = grid[static_cast<std::size_t>(i - 1)][j + side];
          add_row(*data, face_contact(centers[static_cast<std::size_t>(below)], center, {0, 1, 0}, below,
                                      row[j], 0.25f, 0.5f, false));
        }
      }
      if (j + 1 < row.size()) {
        const Vec3 next = centers[static_cast<std::size_t>(row[j + 1])];
        add_row(*data, face_contact(center, next, {1, 0, 0}, row[j], row[j + 1], 0.5f, 0.5f, false));
      }
    }
  }
  return data;
}

enum class Pass { prepare, warm_start, solve, relax, store, whole, color, pack };

void run_pass(benchmark::State& state, Isa isa, Pass pass) {
  if (!is_supported(isa)) {
    state.SkipWithError("not supported here");
    return;
  }
  Workers workers(WorkersOptions{.threads = 1, .isa = isa});
  Crew crew(workers);
  const std::unique_ptr<WorldData> data = make_pyramid();
  data->last_dt = 1.0f / 60.0f;
  data->last_substep = substep_of(*data, data->last_dt);
  color_constraints(*data, crew);
  pack_blocks(*data, crew);
  solve(*data, 1.0f / 60.0f, crew);
  const Constraints& constraints = constraints_of(*data);
  const simd::ContactArgs args = contact_args(*data, constraints_of(*data), 1.0f / 60.0f);
  const simd::ContactKernels& kernels = crew.kernels().contact;
  void (*const kernel[])(const simd::ContactArgs&, const simd::ConstraintChunk&) = {
      kernels.prepare, kernels.warm_start, kernels.solve, kernels.relax, kernels.store};
  for (auto _ : state) {
    if (pass == Pass::whole) {
      solve(*data, 1.0f / 60.0f, crew);
    } else if (pass == Pass::color) {
      color_constraints(*data, crew);
    } else if (pass == Pass::pack) {
      pack_blocks(*data, crew);
    } else {
      for (const simd::ConstraintChunk& chunk : constraints.contact_chunks)
        kernel[static_cast<int>(pass)](args, chunk);
    }
  }
  state.counters["ns_per_manifold"] =
      benchmark::Counter(static_cast<double>(data->contacts.active.size()) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["lane_fill"] = data->stats.lane_fill;
}

const bool kRegistered = [] {
  const std::pair<const char*, Pass> passes[] = {{"prepare", Pass::prepare}, {"warm_start", Pass::warm_start},
                                                 {"solve", Pass::solve},     {"relax", Pass::relax},
                                                 {"store", Pass::store},     {"whole_solve", Pass::whole},
                                                 {"color", Pass::color},     {"pack", Pass::pack}};
  for (const auto& [name, pass] : passes) {
    for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
      benchmark::RegisterBenchmark(
          (std::string(name) + "/" + isa_name(isa)).c_str(),
          [isa, pass = pass](benchmark::State& state) { run_pass(state, isa, pass); })
          ->Unit(benchmark::kMicrosecond);
    }
  }
  return true;
}();

}  // namespace
