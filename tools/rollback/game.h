// The game of the two peers: a scene, a player's inputs, and one step of both.
//
// A step's result depends only on the world and on both inputs. So a snapshot of the world is all that a peer
// must keep of the past; a game with state of its own keeps that beside the snapshot.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/random.h>

#include <array>
#include <cstdint>
#include <vector>

namespace scree::rollback {

inline constexpr int kPlayers = 2;
inline constexpr float kTimeStep = 1.0f / 60.0f;  // s

/// What one player presses during one step.
struct Input {
  std::int8_t right = 0;    ///< -1, 0 or 1, along x
  std::int8_t forward = 0;  ///< -1, 0 or 1, along z
  bool jumps = false;
  bool throws = false;

  friend bool operator==(const Input&, const Input&) = default;
};
using Inputs = std::array<Input, kPlayers>;

/// Two players and a pile of boxes in a yard.
class Game {
 public:
  /// `boxes` of them; the same bits for everyone who starts with the same number.
  explicit Game(int boxes);

  /// One step: what the players press, then the world's.
  void advance(const Inputs& inputs, Workers& workers);

  World& world() { return world_; }
  const World& world() const { return world_; }

 private:
  void press(BodyId player, const Input& input);

  World world_;
  std::array<BodyId, kPlayers> players_;  // created first and never destroyed: the same in every snapshot
};

/// A player's hands: presses something for a while, then something else.
class Hands {
 public:
  explicit Hands(std::uint64_t seed) : random_(seed) {}
  Input next();

 private:
  scenes::Random random_;
  Input held_;
  int steps_left_ = 0;
};

/// The hash after every step of the game in which both inputs were known all along; the first is that before
/// the first step.
std::vector<std::uint64_t> play_with_perfect_knowledge(int boxes, const std::vector<Inputs>& inputs,
                                                       Workers& workers);

}  // namespace scree::rollback
