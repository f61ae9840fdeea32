// Laws of frames: they hold every body of a world, and pages learn of each once.
#include <tests/tools/view/frames.h>
#include <tools/scenes/scene.h>
#include <tools/scenes/stage.h>
#include <tools/view/frame.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace scree::view {
namespace {

constexpr float kFrameStep = 1.0f / 60.0f;

struct Filmed {
  explicit Filmed(const std::string& scene, const scenes::Parameters& parameters = {}, int steps = 0)
      : stage(measured(scenes::build(scene, parameters))) {
    for (int i = 0; i < steps; ++i) stage.advance(kFrameStep, workers);
  }
  static std::vector<scenes::Scene> measured(std::vector<scenes::Scene> scenes) {
    for (scenes::Scene& scene : scenes) scene.settings.contact_forces = true;
    return scenes;
  }
  World& world() { return stage.worlds().front(); }
  ReadFrame frame(const FrameOptions& options = {}, std::uint32_t track = 0) {
    return ReadFrame(make_frame(world(), track, 7, kFrameStep, options, cast, memory));
  }

  Workers workers{WorkersOptions{.threads = 1}};
  scenes::Stage stage;
  Cast cast;
  Cast::Memory memory;
};

std::vector<BodyId> moving_bodies(const World& world) {
  std::vector<BodyId> bodies;
  for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
    const BodyId body = world.body_at(i);
    if (world.is_alive(body) && world.body_type(body) != BodyType::fixed) bodies.push_back(body);
  }
  return bodies;
}

TEST(Frames, HoldThePoseOfEachBodyThatMayMove) {
  Filmed pile("pile", {{"bodies", 80}}, 60);
  const ReadFrame frame = pile.frame({}, 4);
  const std::vector<BodyId> bodies = moving_bodies(pile.world());
  EXPECT_EQ(frame.track, 4u);
  EXPECT_EQ(frame.step, 7.0);
  ASSERT_EQ(frame.numbers.size(), bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Pose pose = pile.world().pose(bodies[i]);
    EXPECT_EQ((Vec3{frame.positions[3 * i], frame.positions[3 * i + 1], frame.positions[3 * i + 2]}),
              pose.position);
    const float parts[] = {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w};
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(static_cast<float>(frame.rotations[4 * i + k]) / 32767.0f, parts[k], 2e-5f);
    EXPECT_FLOAT_EQ(frame.speeds[i], length(pile.world().linear_velocity(bodies[i])));
    EXPECT_EQ(frame.awake[i] != 0, pile.world().is_awake(bodies[i]));
  }
}

TEST(Frames, TellOfEachBodyAndMeshOnce) {
  Filmed pile("pile", {{"bodies", 40}});
  pile.frame();
  const std::vector<Bytes> news = pile.cast.take_news();
  ASSERT_EQ(news.size(), 2u);
  const nlohmann::json head = head_of_news(*news[0]);
  EXPECT_EQ(head.at("bodies"), pile.world().body_count());
  EXPECT_EQ(kind_of(*news[1]), 2u);
  pile.stage.advance(kFrameStep, pile.workers);
  pile.frame();
  EXPECT_TRUE(pile.cast.take_news().empty()) << "nobody is new";
  const BodyId late = pile.world().create_body({.position = {0.0f, 20.0f, 0.0f}});
  pile.world().add_shape(late, Sphere{0.5f});
  const ReadFrame after = pile.frame();
  const std::vector<Bytes> more = pile.cast.take_news();
  ASSERT_EQ(more.size(), 1u);
  EXPECT_EQ(head_of_news(*more[0]).at("bodies"), 1u);
  EXPECT_TRUE(std::count(after.numbers.begin(), after.numbers.end(), head.at("bodies").get<std::uint32_t>()));
  EXPECT_EQ(pile.cast.all_news().size(), 3u);
}

TEST(Frames, OfEqualWorldsHaveTheSameNumbers) {
  Filmed first("ragdolls", {{"ragdolls", 2}}), second("ragdolls", {{"ragdolls", 2}}, 30);
  Cast::Memory memory;
  const ReadFrame a = first.frame();
  const ReadFrame b(make_frame(second.world(), 1, 30, kFrameStep, {}, first.cast, memory));
  EXPECT_EQ(a.numbers, b.numbers);
  EXPECT_EQ(a.roster, b.roster);
  EXPECT_EQ(first.cast.all_news().size(), 2u);
}

TEST(Frames, NumberABodyAnewWhenItsShapesOrItsTypeChange) {
  Filmed stack("stack", {{"bodies", 3}});
  const ReadFrame before = stack.frame();
  const BodyId body = moving_bodies(stack.world()).front();
  stack.world().add_shape(body, Sphere{0.7f});
  const ReadFrame grown = stack.frame();
  EXPECT_NE(before.numbers.front(), grown.numbers.front());
  EXPECT_EQ(before.numbers.back(), grown.numbers.back());
  stack.world().set_body_type(body, BodyType::fixed);
  const ReadFrame stopped = stack.frame();
  EXPECT_EQ(stopped.numbers.size(), 2u);
  EXPECT_NE(stopped.roster, grown.roster);
}

TEST(Frames, ListTheContactsWithTheirForces) {
  Filmed stack("stack", {{"bodies", 4}});
  WorldSettings settings = stack.world().settings();
  settings.sleeping = false;  // sleepers keep what they bore as they fell asleep
  stack.world().set_settings(settings);
  for (int i = 0; i < 200; ++i) stack.stage.advance(kFrameStep, stack.workers);
  const ReadFrame frame = stack.frame({.details = true});
  double up = 0.0;  // N, of the ground
  for (std::size_t i = 0; i < frame.contacts.size(); i += 12) {
    if (frame.contacts[i + 3] < 0.05f) up += static_cast<double>(frame.contacts[i + 8]);
  }
  const double gravity = -static_cast<double>(stack.world().settings().gravity.y);
  double weight = 0.0;
  for (const BodyId body : moving_bodies(stack.world()))
    weight += gravity * static_cast<double>(stack.world().mass_properties(body).mass);
  EXPECT_NEAR(up / weight, 1.0, 0.01);
}

// A ball at a height of 3 m that moves at 2 m/s and turns at 5 rad/s: m (v^2 / 2 + g h) + 2/5 m r^2 w^2 / 2.
TEST(Frames, TellTheEnergiesOfBodiesWithDetails) {
  World world;
  const BodyId ball = world.create_body({.position = {1.0f, 3.0f, 0.0f},
                                         .linear_velocity = {2.0f, 0.0f, 0.0f},
                                         .angular_velocity = {0.0f, 0.0f, 5.0f}});
  world.add_shape(ball, Sphere{0.5f});
  const BodyId floor = world.create_body({.type = BodyType::kinematic});
  world.add_shape(floor, Box{{1.0f, 0.1f, 1.0f}});
  Cast cast;
  Cast::Memory memory;
  const ReadFrame frame(make_frame(world, 0, 0, 0.0f, {.details = true}, cast, memory));
  const float mass = world.mass_properties(ball).mass, g = -world.settings().gravity.y;
  ASSERT_EQ(frame.energies.size(), 2u);
  EXPECT_NEAR(frame.energies[0] / (mass * (2.0f + 3.0f * g + 0.2f * 0.25f * 25.0f)), 1.0f, 1e-5f);
  EXPECT_EQ(frame.energies[1], 0.0f);
  EXPECT_TRUE(ReadFrame(make_frame(world, 0, 0, 0.0f, {}, cast, memory)).energies.empty());
}

TEST(Frames, DrawJointsBetweenTheirAnchors) {
  Filmed dolls("ragdolls", {{"ragdolls", 2}}, 20);
  const ReadFrame frame = dolls.frame({.details = true});
  ASSERT_EQ(frame.joints.size(), 12 * dolls.world().joint_count());
  for (std::size_t i = 0; i < frame.joints.size(); i += 12) {
    const Vec3 a{frame.joints[i], frame.joints[i + 1], frame.joints[i + 2]};
    const Vec3 b{frame.joints[i + 3], frame.joints[i + 4], frame.joints[i + 5]};
    EXPECT_LT(length(a - b), 0.05f);
    EXPECT_GE(frame.joints[i + 6], 0.0f);
    std::uint32_t body = 0;
    std::memcpy(&body, &frame.joints[i + 8], sizeof body);
    EXPECT_TRUE(dolls.world().is_alive(dolls.world().body_at(body)));
  }
}

TEST(Frames, ShadeWhatIsConnectedAlike) {
  Filmed dolls("ragdolls", {{"ragdolls", 3}});
  const ReadFrame apart = dolls.frame({.shade = Shade::island});
  EXPECT_EQ(apart.shade, 1u);
  EXPECT_EQ(std::set<float>(apart.values.begin(), apart.values.end()).size(), 3u);
  Filmed stack("stack", {{"bodies", 4}}, 200);
  const ReadFrame together = stack.frame({.shade = Shade::island});
  EXPECT_EQ(std::set<float>(together.values.begin(), together.values.end()).size(), 1u);
}

TEST(Frames, ShadeByForceResidualAndColorOfContacts) {
  Filmed stack("stack", {{"bodies", 4}}, 200);
  const std::vector<BodyId> bodies = moving_bodies(stack.world());
  const ReadFrame forces = stack.frame({.shade = Shade::force});
  const ReadFrame residuals = stack.frame({.shade = Shade::residual});
  const ReadFrame colors = stack.frame({.shade = Shade::color});
  std::size_t lowest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (stack.world().pose(bodies[i]).position.y < stack.world().pose(bodies[lowest]).position.y) lowest = i;
    EXPECT_GE(residuals.values[i], 0.0f);
    EXPECT_LT(residuals.values[i], 0.01f);
    EXPECT_GE(colors.values[i], 0.0f);
  }
  EXPECT_EQ(std::max_element(forces.values.begin(), forces.values.end()) - forces.values.begin(),
            static_cast<std::ptrdiff_t>(lowest));
  // What has not been measured is zero, and no color.
  Filmed fresh("stack", {{"bodies", 4}});
  for (const float value : fresh.frame({.shade = Shade::force}).values) EXPECT_EQ(value, 0.0f);
  for (const float value : fresh.frame({.shade = Shade::color}).values) EXPECT_EQ(value, -1.0f);
}

TEST(Frames, OfEmptyWorldsAreEmpty) {
  World world;
  Cast cast;
  Cast::Memory memory;
  const ReadFrame frame(
      make_frame(world, 0, 0, 0.0f, {.shade = Shade::island, .details = true}, cast, memory));
  EXPECT_TRUE(frame.numbers.empty());
  EXPECT_TRUE(frame.contacts.empty());
  EXPECT_GT(frame.roster, 0u) << "the roster of nobody";
}

}  // namespace
}  // namespace scree::view
