// The scene and its players; see game.h.
#include <tools/rollback/game.h>

#include <algorithm>
#include <cmath>

namespace scree::rollback {
namespace {

constexpr float kYard = 14.0f;          // m, half its width
constexpr float kWall = 4.0f;           // m, half the walls' height: players jump 1.3 m
constexpr float kPush = 30.0f;          // m/s^2, that a player gives itself
constexpr float kPlayerDamping = 2.5f;  // 1/s: a player runs at kPush / kPlayerDamping at most
constexpr float kJump = 5.0f;           // m/s
constexpr float kStanding = 0.2f;       // m/s: a player that rises or falls faster does not stand
constexpr int kPileHeight = 6;          // boxes
constexpr std::uint64_t kPileSeed = 1;
constexpr std::uint64_t kThrowPause = 20;  // steps

// A floor at y = 0 and four walls.
void build_yard(World& world) {
  const BodyId yard = world.create_body({.type = BodyType::fixed});
  const auto add = [&](Vec3 half_extents, Vec3 position) {
    world.add_shape(yard, Box{half_extents}, {}, {.local_pose = {position, {}}});
  };
  add({kYard, 1.0f, kYard}, {0.0f, -1.0f, 0.0f});
  for (const float side : {-1.0f, 1.0f}) {
    add({1.0f, kWall, kYard + 2.0f}, {side * (kYard + 1.0f), kWall, 0.0f});
    add({kYard, kWall, 1.0f}, {0.0f, kWall, side * (kYard + 1.0f)});
  }
}

BodyId create_player(World& world, float x) {
  BodyDef def;
  def.position = {x, 0.6f, 0.0f};
  def.linear_damping = kPlayerDamping;
  def.angular_damping = 5.0f;
  def.locks = AxisLocks::rotation_x | AxisLocks::rotation_z;  // players stay upright
  def.can_sleep = false;
  const BodyId player = world.create_body(def);
  world.add_shape(player, Box{{0.6f, 0.6f, 0.6f}}, {.friction = 0.2f, .density = 1500.0f});
  return player;
}

// Columns of boxes, side by side about the yard's center.
void build_pile(World& world, int boxes) {
  scenes::Random random(kPileSeed);
  constexpr float kCell = 0.9f;  // m; no box is wider
  const int columns = (boxes + kPileHeight - 1) / kPileHeight;
  const int side = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(columns)))));
  const float corner = -0.5f * kCell * static_cast<float>(side - 1);
  std::vector<float> heights(static_cast<std::size_t>(columns), 0.0f);  // of the columns so far
  for (int i = 0; i < boxes; ++i) {
    const int column = i % columns;
    const float x = random.between(0.2f, 0.4f), y = random.between(0.15f, 0.35f),
                z = random.between(0.2f, 0.4f);
    float& height = heights[static_cast<std::size_t>(column)];
    BodyDef def;
    def.position = {corner + kCell * static_cast<float>(column % side), height + y,
                    corner + kCell * static_cast<float>(column / side)};
    height += 2.0f * y;
    world.add_shape(world.create_body(def), Box{{x, y, z}}, {.density = 200.0f});
  }
}

}  // namespace

Game::Game(int boxes) {
  players_ = {create_player(world_, -11.0f), create_player(world_, 11.0f)};
  build_yard(world_);
  build_pile(world_, boxes);
}

void Game::press(BodyId player, const Input& input) {
  const float mass = world_.mass_properties(player).mass;
  const float push = kPush * mass;
  if (input.right != 0 || input.forward != 0) {
    world_.add_force(
        player, {push * static_cast<float>(input.right), 0.0f, push * static_cast<float>(input.forward)});
  }
  const Vec3 velocity = world_.linear_velocity(player);
  if (input.jumps && std::fabs(velocity.y) < kStanding) {
    world_.add_impulse(player, {0.0f, kJump * mass, 0.0f});
  }
  // The pause is counted by the world's step counter, which a restored world has back.
  if (input.throws && world_.stats().step % kThrowPause == 0) {
    const Vec3 from = world_.pose(player).position;
    const BodyId ball = world_.create_body({.position = {from.x, from.y + 1.2f, from.z},
                                            .linear_velocity = {from.x < 0.0f ? 12.0f : -12.0f, 2.0f, 0.0f}});
    world_.add_shape(ball, Sphere{0.3f}, {.restitution = 0.3f, .density = 3000.0f});
  }
}

void Game::advance(const Inputs& inputs, Workers& workers) {
  for (std::size_t player = 0; player < kPlayers; ++player) press(players_[player], inputs[player]);
  step(world_, kTimeStep, workers);
}

Input Hands::next() {
  if (steps_left_ == 0) {
    const auto direction = [&] { return static_cast<std::int8_t>(static_cast<int>(random_.below(3)) - 1); };
    held_.right = direction();
    held_.forward = direction();
    held_.jumps = random_.below(8) == 0;
    held_.throws = random_.below(4) == 0;
    steps_left_ = 5 + static_cast<int>(random_.below(30));
  }
  --steps_left_;
  return held_;
}

std::vector<std::uint64_t> play_with_perfect_knowledge(int boxes, const std::vector<Inputs>& inputs,
                                                       Workers& workers) {
  Game game(boxes);
  std::vector<std::uint64_t> hashes{game.world().hash()};
  for (const Inputs& pressed : inputs) {
    game.advance(pressed, workers);
    hashes.push_back(game.world().hash());
  }
  return hashes;
}

}  // namespace scree::rollback
