// With warm start, bias and surface velocity off, no pass of the solver raises the kinetic energy.
#include <parallel/constraints/constraints.h>
#include <parallel/stages.h>
#include <tests/physics/lab.h>

namespace scree::physics {
namespace {

double kinetic_energy(const Lab& lab, const std::vector<BodyId>& bodies) {
  double sum = 0.0;
  for (const BodyId body : bodies) sum += lab.kinetic_energy(body);
  return sum;
}

// The phases of a step up to the blocks, and then the solver's passes one by one.
class PassByPass {
 public:
  PassByPass(Lab& lab, const std::vector<BodyId>& bodies)
      : lab_(lab), bodies_(bodies), data_(internals(lab.world)), crew_(lab.workers) {
    refresh_lists(data_, crew_);
    find_pairs(data_, crew_);
    collide(data_, crew_);
    wake_touched_islands(data_, crew_);
    put_islands_to_sleep(data_, crew_);
    refresh_joints(data_, crew_);
    color_constraints(data_, crew_);
    pack_blocks(data_, crew_);
    Constraints& constraints = constraints_of(data_);
    constraints.moving_bodies.clear();
    for (const std::int32_t body : data_.bodies.awake) constraints.moving_bodies.push_back(body);
    const int count = static_cast<int>(constraints.moving_bodies.size());
    crew_.kernels().body.prepare(body_args(data_, kStep), 0, count);
    args_ = contact_args(data_, constraints, kStep);
    args_.soft = args_.soft_static = {.bias_rate = 0.0f, .mass_scale = 1.0f, .impulse_scale = 0.0f};
    args_.inverse_substep = 0.0f;  // no bias of gaps either
    args_.warm_start_scale = args_.impulse_keep = 0.0f;
    for_each_chunk(
        [&](const simd::ConstraintChunk& chunk) { crew_.kernels().contact.prepare(args_, chunk); });
  }

  // Runs a pass and expects that no chunk of it raises the energy.
  void expect_no_gain(void (*kernel)(const simd::ContactArgs&, const simd::ConstraintChunk&),
                      const char* name) {
    for_each_chunk([&](const simd::ConstraintChunk& chunk) {
      const double before = kinetic_energy(lab_, bodies_);
      kernel(args_, chunk);
      const double after = kinetic_energy(lab_, bodies_);
      EXPECT_LE(after, before * (1.0 + 1e-5)) << name << ", variant " << chunk.variant;
      most_ = std::max(most_, after / before - 1.0);
    });
  }
  const simd::ContactKernels& kernels() const { return crew_.kernels().contact; }
  std::size_t contacts() const { return data_.contacts.active.size(); }
  double most() const { return most_; }

 private:
  template <class Work>
  void for_each_chunk(Work&& work) {
    for (const simd::ConstraintChunk& chunk : constraints_of(data_).contact_chunks) work(chunk);
  }

  Lab& lab_;
  const std::vector<BodyId>& bodies_;
  WorldData& data_;
  Crew crew_;
  simd::ContactArgs args_{};
  double most_ = -1.0;
};

class PassEnergy : public ::testing::TestWithParam<Isa> {};

void check(Isa isa, const Material& material, float spin, std::uint64_t seed) {
  WorldSettings settings = without_sleep();
  settings.warm_start = false;
  Lab lab(settings);
  lab.workers = Workers(WorkersOptions{.threads = 1, .isa = isa});
  const std::vector<BodyId> bodies = add_heap(lab, 80, seed, material);
  lab.run(60);
  Random random(seed + 100);
  for (const BodyId body : bodies) {
    lab.world.set_linear_velocity(body, random.vector(5.0f));
    lab.world.set_angular_velocity(body, random.vector(spin));
  }
  PassByPass passes(lab, bodies);
  ASSERT_GT(passes.contacts(), 60u);
  for (int substep = 0; substep < 4; ++substep) {
    passes.expect_no_gain(passes.kernels().solve, "solve");
    passes.expect_no_gain(passes.kernels().relax, "relax");
  }
}

TEST_P(PassEnergy, NeverRises) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    check(GetParam(), {.friction = 0.6f}, 10.0f, seed);
    check(GetParam(), {.friction = 0.0f}, 10.0f, seed);
    check(GetParam(), {.friction = 2.0f, .rolling_resistance = 0.1f}, 30.0f, seed);
  }
}

std::string isa_of(const ::testing::TestParamInfo<Isa>& info) { return isa_name(info.param); }
std::vector<Isa> supported_isas() {
  std::vector<Isa> supported;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (is_supported(isa)) supported.push_back(isa);
  }
  return supported;
}
INSTANTIATE_TEST_SUITE_P(Each, PassEnergy, ::testing::ValuesIn(supported_isas()), isa_of);

TEST(Energy, AHeapWithoutRestitutionNeverGainsMoreThanItFalls) {
  Lab lab;
  const std::vector<BodyId> heap = add_heap(lab, 100, 2, {.friction = 0.5f});
  const auto energy = [&] {
    double sum = kinetic_energy(lab, heap);
    for (const BodyId body : heap) sum += lab.mass(body) * kGravity * lab.height(body);
    return sum;
  };
  const double start = energy();
  double highest = start;
  for (int i = 0; i < 300; ++i) {
    lab.run(1);
    highest = std::max(highest, energy());
  }
  EXPECT_LT(highest, 1.001 * start);
  EXPECT_LT(kinetic_energy(lab, heap), 0.01 * start);
}

}  // namespace
}  // namespace scree::physics
