// The law of queries to all ranks: they have the answers of one process, bit for bit.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/distributed/eventful_pile.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::EventfulPile;
using distributed_tests::make_eventful_pile;
using distributed_tests::run_ranks;
using physics::kStep;

// A pile in a gate, beside shapes of other kinds that overlap and are at the same distances.
EventfulPile make_pile() {
  EventfulPile pile = make_eventful_pile(120);
  World& world = pile.world;
  const BodyId hill = world.create_body({.type = BodyType::fixed, .position = {0, -0.2f, 0}});
  const Vec3 corners[] = {{-9, 0, -9}, {9, 0, -9}, {9, 0.4f, 9}, {-9, 0.4f, 9}};
  const MeshTriangle triangles[] = {{0, 2, 1}, {0, 3, 2}};
  world.add_shape(hill, TriangleMesh(corners, triangles));
  const BodyId lift = world.create_body(
      {.type = BodyType::kinematic, .position = {2, 1, 0}, .linear_velocity = {0, 0.5f, 0}});
  world.add_shape(lift, Cylinder{.half_height = 0.5f, .radius = 1});
  for (int i = 0; i < 12; ++i) {  // twins, the second one of which is larger by less than floats tell
    const BodyId twin = world.create_body({.position = {static_cast<float>(i / 2) - 3, 60, 30}});
    const float radius = i % 2 == 0 ? 0.3f : std::nextafter(0.3f, 1.0f);
    world.add_shape(twin, Sphere{radius}, {}, {.filter = {.group = -1}});
    pile.bodies.push_back(twin);
  }
  return pile;
}

// Calls between two steps, which the next queries see.
void change(World& world, const std::vector<BodyId>& bodies, int round) {
  const auto body = [&](int i) { return bodies[static_cast<std::size_t>(7 * round + i)]; };
  world.destroy_body(body(0));
  world.set_pose(body(1), {{0.5f, 3, 0.25f}, {}});
  world.set_body_type(body(2), BodyType::fixed);
  world.set_body_type(body(3), BodyType::kinematic);
  const BodyId more = world.create_body({.position = {-2, 4.0f + static_cast<float>(round), 1}});
  world.add_shape(more, Box{{0.4f, 0.4f, 0.4f}});
}

struct Answers {
  std::vector<std::optional<CastHit>> rays, casts;
  std::vector<std::uint8_t> blocked, casts_blocked;
  std::vector<std::optional<NearHit>> closest, closest_shapes;
  AnswerLists<CastHit> all_rays, all_casts;
  AnswerLists<OverlapHit> shapes, boxes, points;
  AnswerLists<NearHit> near, near_shapes;
};

struct Questions {
  std::vector<Ray> rays;
  std::vector<ShapeCast> casts;
  std::vector<PlacedShape> shapes;
  std::vector<AxisBox> boxes;
  std::vector<Vec3> points;
};

Questions draw_questions(std::uint64_t seed) {
  physics::Random random(seed);
  Questions questions;
  const auto place = [&] {
    const Vec3 at = random.vector(5);
    return Vec3{at.x, at.y + 4, at.z};
  };
  for (int i = 0; i < 80; ++i) {
    questions.rays.push_back({place(), random.vector(12)});
    const Pose pose{place(), random.rotation()};
    const Geometry geometry = i % 2 == 0 ? Geometry(Sphere{0.4f}) : Geometry(Box{{0.3f, 0.2f, 0.5f}});
    questions.casts.push_back({geometry, pose, random.vector(8)});
    questions.shapes.push_back({geometry, pose});
    const Vec3 lower = place(), size = random.vector(1);
    questions.boxes.push_back({lower, {lower.x + size.x * size.x, lower.y + 1, lower.z + 0.5f}});
    questions.points.push_back(place());
  }
  for (int i = 0; i < 6; ++i)  // at twins
    questions.rays.push_back({{static_cast<float>(i) - 3, 65, 30}, {0, -60, 0}});
  return questions;
}

template <class AnyWorld>
Answers ask(AnyWorld& world, const Questions& questions, Workers& workers, const QueryOptions& options) {
  Answers answers;
  const std::size_t rays = questions.rays.size(), casts = questions.casts.size();
  answers.rays.resize(rays);
  answers.blocked.resize(rays);
  answers.casts.resize(casts);
  answers.casts_blocked.resize(casts);
  answers.closest.resize(questions.points.size());
  answers.closest_shapes.resize(questions.shapes.size());
  cast_rays(world, questions.rays, answers.rays, workers, options);
  are_blocked(world, questions.rays, answers.blocked, workers, options);
  answers.all_rays = cast_rays_all(world, questions.rays, workers, options);
  cast_shapes(world, questions.casts, answers.casts, workers, options);
  are_casts_blocked(world, questions.casts, answers.casts_blocked, workers, options);
  answers.all_casts = cast_shapes_all(world, questions.casts, workers, options);
  answers.shapes = overlap_shapes(world, questions.shapes, workers, options);
  answers.boxes = overlap_boxes(world, questions.boxes, workers, options);
  answers.points = overlap_points(world, questions.points, workers, options);
  closest_to_points(world, questions.points, 3, answers.closest, workers, options);
  closest_to_shapes(world, questions.shapes, 3, answers.closest_shapes, workers, options);
  answers.near = near_points(world, questions.points, 1.5f, workers, options);
  answers.near_shapes = near_shapes(world, questions.shapes, 1, workers, options);
  return answers;
}

// Handles of another world name the same rows.
template <class Hit>
void expect_same(Hit hit, const Hit& expected) {
  EXPECT_EQ(hit.shape.index, expected.shape.index);
  EXPECT_EQ(hit.shape.generation, expected.shape.generation);
  EXPECT_EQ(hit.body.index, expected.body.index);
  EXPECT_EQ(hit.body.generation, expected.body.generation);
  hit.shape = expected.shape;
  hit.body = expected.body;
  EXPECT_EQ(hit, expected);
}

template <class Hit>
void expect_same(const std::vector<std::optional<Hit>>& hits,
                 const std::vector<std::optional<Hit>>& expected) {
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(hits[i].has_value(), expected[i].has_value()) << "query " << i;
    if (hits[i]) expect_same(*hits[i], *expected[i]);
  }
}

template <class Hit>
void expect_same(const AnswerLists<Hit>& lists, const AnswerLists<Hit>& expected) {
  ASSERT_EQ(lists.begins, expected.begins);
  for (std::size_t i = 0; i < expected.answers.size(); ++i)
    expect_same(lists.answers[i], expected.answers[i]);
}

void expect_same(const Answers& answers, const Answers& expected) {
  EXPECT_EQ(answers.blocked, expected.blocked);
  EXPECT_EQ(answers.casts_blocked, expected.casts_blocked);
  expect_same(answers.rays, expected.rays);
  expect_same(answers.casts, expected.casts);
  expect_same(answers.closest, expected.closest);
  expect_same(answers.closest_shapes, expected.closest_shapes);
  expect_same(answers.all_rays, expected.all_rays);
  expect_same(answers.all_casts, expected.all_casts);
  expect_same(answers.shapes, expected.shapes);
  expect_same(answers.boxes, expected.boxes);
  expect_same(answers.points, expected.points);
  expect_same(answers.near, expected.near);
  expect_same(answers.near_shapes, expected.near_shapes);
}

std::vector<QueryOptions> all_options(const std::vector<BodyId>& bodies) {
  return {{},
          {.types = BodyTypes::dynamic, .start_inside = StartInside::skip, .sensors = true},
          {.ignored = bodies.back(), .back_sides = true},
          {.predicate = [](ShapeId shape, BodyId) { return shape.index % 3 != 0; }}};
}

TEST(DistributedQueries, HaveTheAnswersOfOneProcess) {
  constexpr int kRounds = 4, kStepsPerRound = 30;
  EventfulPile one = make_pile();
  Workers workers(2);
  std::vector<Answers> expected;
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < kStepsPerRound; ++i) step(one.world, kStep, workers);
    change(one.world, one.bodies, round);
    for (const QueryOptions& options : all_options(one.bodies))
      expected.push_back(
          ask(one.world, draw_questions(static_cast<std::uint64_t>(round) + 1), workers, options));
  }
  std::size_t hits = 0;
  for (const Answers& answers : expected) {
    for (const auto& ray : answers.rays) hits += ray.has_value() ? 1 : 0;
    hits += answers.shapes.answers.size();
  }
  EXPECT_GT(hits, 500u);
  for (const int ranks : {1, 2, 5}) {
    const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
      EventfulPile part = make_pile();
      DistributedWorld world(std::move(part.world), transport, {.steps_per_look = 5, .imbalance = 1.0f});
      Workers of_rank(1);
      std::size_t asked = 0;
      for (int round = 0; round < kRounds; ++round) {
        for (int i = 0; i < kStepsPerRound; ++i) world.step(kStep, of_rank);
        change(world.world(), part.bodies, round);
        for (const QueryOptions& options : all_options(part.bodies))
          expect_same(ask(world, draw_questions(static_cast<std::uint64_t>(round) + 1), of_rank, options),
                      expected[asked++]);
      }
    });
    EXPECT_EQ(all_of(errors), "") << ranks << " ranks";
  }
}

TEST(DistributedQueries, ThrowOnAllRanksWhatOneThrows) {
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    DistributedWorld world(make_pile().world, transport);
    Workers workers(1);
    const std::vector<Ray> down = {{{0, 9, 0}, {0, -9, 0}}}, far = {{{0, 2e7f, 0}, {0, -9, 0}}};
    std::vector<std::optional<CastHit>> hits(1);
    const auto message_of = [&](auto&& ask_it) {
      try {
        ask_it();
      } catch (const Error& error) {
        return std::string(error.what());
      }
      return std::string("nothing");
    };
    const std::string wrong = message_of([&] { cast_rays(world, far, hits, workers); });
    EXPECT_NE(wrong.find("cast_rays: "), std::string::npos) << wrong;
    EXPECT_NE(wrong.find("origin"), std::string::npos) << wrong;
    std::vector<std::optional<NearHit>> near(1);
    const std::vector<Vec3> points(1);
    const std::string minus = message_of([&] { closest_to_points(world, points, -1, near, workers); });
    EXPECT_NE(minus.find("closest_to_points: most is -1"), std::string::npos) << minus;
    const QueryOptions fails = {.predicate = [&](ShapeId, BodyId) {
      return rank == 1 ? throw std::runtime_error("not that one") : true;
    }};
    const std::vector<AxisBox> everywhere = {{{-50, -50, -50}, {50, 50, 50}}};
    const std::string failed = message_of([&] { overlap_boxes(world, everywhere, workers, fails); });
    EXPECT_NE(failed.find("not that one"), std::string::npos) << failed;
    hits.resize(2);
    EXPECT_THROW(cast_rays(world, down, hits, workers), Error);
    hits.resize(1);
    cast_rays(world, down, hits, workers);
    EXPECT_TRUE(hits[0].has_value());
    EXPECT_EQ(cast_rays_all(world, {}, workers).size(), 0u);
  });
  EXPECT_EQ(all_of(errors), "");
}

}  // namespace
}  // namespace scree
