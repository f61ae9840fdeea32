// The body kernels by themselves: rows filled by hand, ordinary ones and such as no solid body has.
#include <core/world/column.h>
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <simd/dispatch/kernels.h>
#include <tests/simd/all_kernels.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace scree {
namespace {

constexpr int kBodies = 512, kSubsteps = 3;
constexpr float kStep = 1.0f / 60.0f;
// Longest list of lanes that a kernel may read past the end of a list.
constexpr int kPadding = 32;

// Numbers of many sizes, some of them with squares or products that overflow or are denormal.
struct Numbers {
  std::mt19937 engine;
  explicit Numbers(unsigned seed) : engine(seed) {}
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine); }
  float ordinary(float size) { return std::uniform_real_distribution<float>(-size, size)(engine); }
  float any(float size) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kRare[] = {0.0f,    -0.0f,     1e-39f,     1e-22f,
                               1e10f,   1.7e19f,   2e19f,      -1e20f,
                               3.4e38f, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()};
    return pick(24) == 0 ? kRare[pick(static_cast<int>(std::size(kRare)))] : ordinary(size);
  }
};

// All columns that body kernels read or write.
struct BodyRows {
  Column<std::int32_t> list;
  Column<PoseRow> pose;
  Column<VelocityRow> velocity, free_velocity;
  Column<DeltaRow> delta;
  Column<InertiaRow> inertia, local_mass;
  Column<LocalInertiaRow> local_inertia;
  Column<MotionRow> motion;
  Column<std::uint8_t> step_notes, flags, non_finite;
  Column<ForceRow> force;
  Column<DriftRow> drift;
  Column<float> center, transform, sleep_timer, mass, kinetic_energy;

  explicit BodyRows(unsigned seed) {
    Numbers numbers(seed);
    for (int body = 0; body < kBodies; ++body) add(numbers);
    for (int body = 0; body < kBodies + kPadding; ++body) list.push_back(std::min(body, kBodies - 1));
    inertia.resize(kBodies);
    delta.resize(kBodies);
    free_velocity.resize(kBodies);
    step_notes.resize(kBodies);
    transform.resize(std::size_t{7} * kBodies);
    kinetic_energy.resize(kBodies + kPadding);
    non_finite.resize(kBodies + kPadding);
  }

  simd::BodyArgs args() {
    simd::BodyArgs args{};
    args.list = list.data();
    args.pose = pose.data();
    args.velocity = velocity.data();
    args.free_velocity = free_velocity.data();
    args.velocity_before = velocity.data();
    args.delta = delta.data();
    args.inertia = inertia.data();
    args.local_mass = local_mass.data();
    args.local_inertia = local_inertia.data();
    args.motion = motion.data();
    args.step_notes = step_notes.data();
    args.flags = flags.data();
    args.may_sleep = 1;
    args.force = force.data();
    args.center = center.data();
    args.transform = transform.data();
    args.sleep_timer = sleep_timer.data();
    args.drift = drift.data();
    args.mass = mass.data();
    args.kinetic_energy = kinetic_energy.data();
    args.non_finite = non_finite.data();
    args.gravity[1] = -9.81f;
    args.substep = kStep / kSubsteps;
    args.step = kStep;
    args.max_linear_speed = 400;
    args.max_angular_speed = 50;
    args.sleep_time = 0.5f;
    args.sleep_linear_speed = args.sleep_angular_speed = 0.05f;
    args.warm_start = true;
    return args;
  }

  // Calls visit(name, floats, floats of a body) for the columns that kernels write.
  void for_each_result(const std::function<void(const char*, const float*, std::size_t)>& visit) const {
    visit("pose", pose.data()->position, 8);
    visit("velocity", velocity.data()->linear, 8);
    visit("free_velocity", free_velocity.data()->linear, 8);
    visit("delta", delta.data()->position, 8);
    visit("inertia", inertia.data()->inverse_inertia, 8);
    visit("drift", drift.data()->way, 8);
    visit("transform", transform.data(), 7);
    visit("sleep_timer", sleep_timer.data(), 1);
    visit("kinetic_energy", kinetic_energy.data(), 1);
  }

 private:
  void add(Numbers& numbers) {
    const auto vector = [&numbers](float size) {
      return Vec3{numbers.any(size), numbers.any(size), numbers.any(size)};
    };
    const Vec3 at = vector(10), center_now = vector(1);
    const Quat q = normalize(Quat{numbers.ordinary(1), numbers.ordinary(1), numbers.ordinary(1), 1.1f});
    pose.push_back({{at.x, at.y, at.z}, 0, {q.x, q.y, q.z, q.w}});
    const float speed = numbers.pick(2) == 0 ? 0.05f : 80;
    const Vec3 v = vector(speed), w = vector(speed), f = vector(20), t = vector(5), way = vector(0.01f);
    velocity.push_back({{v.x, v.y, v.z}, {w.x, w.y, w.z}, 0, 0});
    force.push_back({{f.x, f.y, f.z}, {t.x, t.y, t.z}, {}});
    drift.push_back({{way.x, way.y, way.z}, {way.z, way.x, way.y}, {}});
    for (const float number : {center_now.x, center_now.y, center_now.z}) center.push_back(number);
    const bool is_dynamic = numbers.pick(8) != 0;
    const float kilograms = std::abs(numbers.ordinary(5)) + 0.1f;
    const Vec3 moments{1, 1 + std::abs(numbers.ordinary(0.5f)), 0.6f};
    mass.push_back(is_dynamic ? kilograms : 0);
    const float inverse = is_dynamic ? 1.0f : 0.0f;
    local_mass.push_back(
        {{inverse / moments.x, 0, 0, inverse / moments.y, 0, inverse / moments.z}, inverse / kilograms, 0});
    local_inertia.push_back({{moments.x, 0, 0, moments.y, 0, moments.z}, {}});
    std::uint32_t motion_flags = 0;
    if (numbers.pick(2) == 0) motion_flags |= kMotionGyroscopic;
    if (numbers.pick(2) == 0) motion_flags |= kMotionJointed;
    if (numbers.pick(6) == 0) motion_flags |= static_cast<std::uint32_t>(numbers.pick(kMotionLocksMask));
    motion.push_back({std::abs(numbers.ordinary(1)), std::abs(numbers.ordinary(1)), 1, motion_flags});
    flags.push_back(static_cast<std::uint8_t>(numbers.pick(2)));
    sleep_timer.push_back(std::abs(numbers.ordinary(1)));
  }
};

// What contacts and joints would do in a substep: of some bodies more than a number can hold the square of.
void push(BodyRows& rows, int substep) {
  Numbers numbers(static_cast<unsigned>(substep));
  for (int body = 0; body < kBodies; ++body) {
    for (float& component : rows.velocity[body].linear) component += numbers.any(1);
    for (float& component : rows.velocity[body].angular) component += numbers.any(1);
    if (body % 3 == 0) rows.step_notes[body] |= std::uint8_t{kHasContacts};
  }
}

// A step by these kernels, with ranges of so many bodies.
BodyRows run(const simd::BodyKernels& kernels, unsigned seed, int range) {
  BodyRows rows(seed);
  simd::BodyArgs args = rows.args();
  const auto over_bodies = [&](auto kernel) {
    for (int begin = 0; begin < kBodies; begin += range)
      kernel(args, begin, std::min(begin + range, kBodies));
  };
  over_bodies(kernels.prepare);
  for (int substep = 0; substep < kSubsteps; ++substep) {
    args.first_substep = substep == 0;
    args.elapsed = static_cast<float>(substep) * args.substep;
    over_bodies(kernels.integrate_velocities);
    push(rows, substep);
    over_bodies(kernels.integrate_poses);
  }
  over_bodies(kernels.finish);
  return rows;
}

// Numbers that are none count as equal: of two of them hardware keeps either.
void expect_same_bits(const BodyRows& expected, const BodyRows& rows, const std::string& name) {
  std::vector<std::pair<const float*, std::size_t>> columns;
  expected.for_each_result(
      [&](const char*, const float* column, std::size_t width) { columns.emplace_back(column, width); });
  std::size_t column = 0;
  rows.for_each_result([&](const char* what, const float* now, std::size_t width) {
    const float* before = columns[column++].first;
    for (std::size_t i = 0; i < width * kBodies; ++i) {
      if (std::isnan(before[i]) && std::isnan(now[i])) continue;
      ASSERT_EQ(std::bit_cast<std::uint32_t>(before[i]), std::bit_cast<std::uint32_t>(now[i]))
          << name << ": " << what << " of body " << i / width << ", " << before[i] << " and " << now[i];
    }
  });
  for (int body = 0; body < kBodies; ++body) {
    ASSERT_EQ(expected.step_notes[body], rows.step_notes[body]) << name << ", body " << body;
    ASSERT_EQ(expected.non_finite[body], rows.non_finite[body]) << name << ", body " << body;
  }
}

TEST(BodyKernels, TheBodiesBesideABodyChangeNothingInIt) {
  const simd::BodyKernels& widest = simd::widest_kernels().body;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    expect_same_bits(run(widest, seed, 1), run(widest, seed, kBodies), "seed " + std::to_string(seed));
  }
}

TEST(BodyKernels, EveryInstructionSetGivesTheSameBits) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const BodyRows expected = run(kernel_tests::scalar_kernels().body, seed, kBodies);
    for (const simd::Kernels* kernels : kernel_tests::all_kernels()) {
      expect_same_bits(expected, run(kernels->body, seed, kBodies),
                       std::string(kernels->name) + ", seed " + std::to_string(seed));
    }
  }
}

TEST(BodyKernels, NoBodyEndsAStepWithoutNumbers) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const BodyRows rows = run(simd::widest_kernels().body, seed, kBodies);
    int restored = 0;
    for (int body = 0; body < kBodies; ++body) {
      restored += rows.non_finite[body];
      const VelocityRow& v = rows.velocity[body];
      for (const float component : v.linear) ASSERT_TRUE(std::isfinite(component)) << "body " << body;
      for (const float component : v.angular) ASSERT_TRUE(std::isfinite(component)) << "body " << body;
    }
    EXPECT_GT(restored, kBodies / 8);
    EXPECT_LT(restored, kBodies);
  }
}

}  // namespace
}  // namespace scree
