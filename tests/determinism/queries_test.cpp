// Laws of queries in worlds that are stepped: their answers are the same on every backend, and asking changes
// no step.
#include <gtest/gtest.h>
#include <tests/determinism/many_threads.h>
#include <tests/parallel/queries/query_fixture.h>

#include <vector>

namespace scree::determinism {
namespace {

constexpr float kQueryStep = 1.0f / 60.0f;  // s

struct Answers {
  std::vector<std::optional<CastHit>> rays, casts;
  std::vector<std::optional<NearHit>> near;
  std::uint64_t hash = 0;
};

// Handles name the world, and each has another one.
void forget_world(Answers& answers) {
  for (auto* hits : {&answers.rays, &answers.casts}) {
    for (auto& hit : *hits) {
      if (hit) hit->shape.world = hit->body.world = 0;
    }
  }
  for (auto& hit : answers.near) {
    if (hit) hit->shape.world = hit->body.world = 0;
  }
}

// What the world says after each of some steps and calls, all on one kind of workers.
std::vector<Answers> play(const WorkersOptions& options, bool asks) {
  testing::MixedWorld mixed(17, 150);
  Workers workers(options);
  std::vector<Answers> all;
  for (int round = 0; round < 12; ++round) {
    for (int i = 0; i < 4; ++i) step(mixed.world, kQueryStep, workers);
    mixed.change_something();
    Answers answers;
    answers.hash = mixed.world.hash();
    testing::Dice dice(static_cast<std::uint64_t>(round));
    std::vector<Ray> rays;
    std::vector<ShapeCast> casts;
    std::vector<Vec3> points;
    for (int i = 0; i < 100; ++i) {
      rays.push_back(dice.ray(9.0f));
      points.push_back(rays.back().origin);
      casts.push_back({Capsule{}, {points.back(), {}}, rays.back().translation});
    }
    answers.rays.resize(rays.size());
    answers.casts.resize(rays.size());
    answers.near.resize(rays.size());
    if (asks) {
      cast_rays(mixed.world, rays, answers.rays, workers);
      cast_shapes(mixed.world, casts, answers.casts, workers);
      closest_to_points(mixed.world, points, 2.0f, answers.near, workers);
    }
    forget_world(answers);
    all.push_back(answers);
  }
  return all;
}

class Queries : public ManyThreads {};

TEST_F(Queries, AnswerTheSameOnEveryBackendAndChangeNoStep) {
  const std::vector<Answers> expected = play({.threads = 1, .isa = Isa::scalar}, true);
  const std::vector<Answers> unasked = play({.threads = 1, .isa = Isa::scalar}, false);
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      const std::vector<Answers> found = play({.threads = threads, .isa = isa}, true);
      for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_EQ(found[i].hash, unasked[i].hash);
        EXPECT_EQ(found[i].rays, expected[i].rays);
        EXPECT_EQ(found[i].casts, expected[i].casts);
        EXPECT_EQ(found[i].near, expected[i].near);
      }
    }
  }
}

}  // namespace
}  // namespace scree::determinism
