// The player's snapshots: a world that is saved, restored, cloned or sent as bytes continues unchanged, and a
// snapshot kept as changes stays equal to the original.
#include <tests/determinism/player.h>
#include <tests/determinism/replay.h>

#include <algorithm>

namespace scree::determinism {
namespace {

constexpr std::uint32_t kMostAside = 5;  // steps of a clone

}  // namespace

std::vector<std::byte> bytes_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

void lead_astray(World& world, Workers& workers) {
  for (std::uint32_t index = 0; index < 40; index += 3) {
    const BodyId body = world.body_at(index);
    if (world.is_alive(body)) world.destroy_body(body);
  }
  for (int i = 0; i < 30; ++i) {
    const BodyId body = world.create_body({.position = {0.3f * static_cast<float>(i), 6.0f, 0.0f}});
    world.add_shape(body, Sphere{0.4f});
  }
  WorldSettings settings = world.settings();
  settings.gravity = {3.0f, 1.0f, 0.0f};
  world.set_settings(settings);
  for (int i = 0; i < 8; ++i) step(world, 1.0f / 90.0f, workers);
}

// The first snapshot is the base of all changes. Replacing it makes them useless.
void Player::forget_changes() {
  for (Saved& saved : saved_) {
    if (!saved.full || !saved.in_changes) continue;
    bool refused = false;
    try {
      apply_changes(saved_[0].snapshot, saved.changes, restored_);
    } catch (const Error&) {
      refused = true;
    }
    if (!refused) fail("changes are applied to another snapshot than their own");
    saved.full = false;
  }
}

void Player::save_somewhere(const Call& call) {
  Random random(call.seed);
  const std::uint32_t place = random.below(static_cast<std::uint32_t>(saved_.size()));
  const bool in_changes = place > 0 && saved_[0].full && random.below(2) == 0;
  tell(in_changes ? "save, keep_changes" : "save", place);
  Saved& saved = saved_[place];
  if (in_changes) {
    save(world_, scratch_);
    keep_changes(saved_[0].snapshot, scratch_, saved.changes);
  } else {
    save(world_, saved.snapshot);
  }
  if (place == 0) forget_changes();
  saved.full = true;
  saved.in_changes = in_changes;
  saved.model = model_;
  const Snapshot& kept = whole(saved);
  if (checks_ && write_snapshot(kept) != bytes_of(world_)) fail("a snapshot holds another world");
  if (kept.step() != world_.stats().step) fail("a snapshot is of another step");
}

const Snapshot& Player::whole(const Saved& saved) {
  if (!saved.in_changes) return saved.snapshot;
  apply_changes(saved_[0].snapshot, saved.changes, restored_);
  return restored_;
}

void Player::restore_saved(const Call& call) {
  Random random(call.seed);
  const std::uint32_t place = random.below(static_cast<std::uint32_t>(saved_.size()));
  std::uint32_t way = random.below(4);
  if (one_world_ && way != 3) way = 0;
  const Saved& saved = saved_[place];
  if (!saved.full) return;
  constexpr const char* kWays[] = {"into this world", "into a new world", "into a used world", "from bytes"};
  tell("restore", place, kWays[way]);
  const Snapshot& snapshot = whole(saved);
  switch (way) {
    case 0:
      restore(world_, snapshot);
      break;
    case 1: {
      World fresh;
      fresh.share_handles(world_);  // the snapshot may have been read from bytes
      restore(fresh, snapshot);
      world_ = std::move(fresh);
      break;
    }
    case 2:
      restore(used_, snapshot);
      std::swap(world_, used_);
      break;
    default:
      restore(world_, read_snapshot(write_snapshot(snapshot)));
      break;
  }
  const Model before = std::move(model_);
  model_ = saved.model;
  check_handles(before);
  if (checks_ && write_snapshot(snapshot) != bytes_of(world_)) fail("a restored world has another state");
}

// Handles that were valid when the world was saved are valid again; no other known handles are.
void Player::check_handles(const Model& before) {
  std::set<BodyId> bodies;
  std::set<ShapeId> shapes;
  for (const Slot& slot : model_.slots) {
    if (slot.body == BodyId{}) continue;
    bodies.insert(slot.body);
    shapes.insert(slot.shapes.begin(), slot.shapes.end());
    if (!world_.is_alive(slot.body)) fail("a body is not restored");
  }
  for (const ShapeId shape : shapes) {
    if (!world_.is_alive(shape)) fail("a shape is not restored");
  }
  for (const auto& [joint, joined] : model_.joints) {
    if (!world_.is_alive(joint)) fail("a joint is not restored");
  }
  for (const auto& [joint, joined] : before.joints) {
    if (world_.is_alive(joint) && !model_.joints.contains(joint)) fail("a joint from later lives on");
  }
  for (const Slot& slot : before.slots) {
    if (slot.body == BodyId{}) continue;
    if (world_.is_alive(slot.body) && !bodies.contains(slot.body)) fail("a body from later lives on");
    for (const ShapeId shape : slot.shapes) {
      if (world_.is_alive(shape) && !shapes.contains(shape)) fail("a shape from later lives on");
    }
  }
}

// Runs with checks make every other round trip, and runs without checks make the others: results must not
// show whether a round trip happened.
void Player::go_round(const Call& call) {
  Random random(call.seed);
  std::uint32_t way = random.below(4);
  if ((random.below(2) == 0) != checks_) return;
  if (one_world_ && way == 2) way = 1;
  constexpr const char* kWays[] = {"astray", "as bytes", "as a clone", "as changes"};
  tell("save, go, restore", kWays[way]);
  save(world_, scratch_);
  switch (way) {
    case 0:
      lead_astray(world_, shift_.at(static_cast<int>(hashes_.size()) + 1));
      restore(world_, scratch_);
      break;
    case 1:
      restore(world_, read_snapshot(write_snapshot(scratch_)));
      break;
    case 2:
      world_ = clone(world_);
      break;
    default: {
      const Snapshot& base = saved_[0].full ? saved_[0].snapshot : scratch_;
      SnapshotChanges changes;
      keep_changes(base, scratch_, changes);
      apply_changes(base, changes, restored_);
      restore(world_, restored_);
      break;
    }
  }
  if (checks_ && bytes_of(world_) != write_snapshot(scratch_)) fail("going round has changed the world");
}

// Two clones step the same way on different backends, one of them in a list. This must not affect the world.
void Player::branch_off(const Call& call) {
  Random random(call.seed);
  const std::uint32_t steps = 1 + random.below(kMostAside);
  spare_slow_solvers();
  tell("clone, step aside", steps);
  World alone = clone(world_), listed = clone(world_);
  hook_up(alone), hook_up(listed), hook_up(used_);
  const std::uint64_t before = world_.hash();
  const int now = static_cast<int>(hashes_.size());
  for (std::uint32_t i = 0; i < steps; ++i) {
    const float dt = random_time_step(random);
    step(alone, dt, shift_.at(now + static_cast<int>(i)));
    World* const worlds[] = {&listed, &used_};
    step(worlds, dt, shift_.at(now + static_cast<int>(i) + 1));
    if (alone.hash() != listed.hash()) fail("two clones go different ways");
    if (digest_of_events(alone) != digest_of_events(listed)) fail("two clones tell different events");
  }
  if (world_.hash() != before) fail("a clone's steps have changed the world");
}

void Player::make_wrong_call_of_snapshots(std::uint32_t which) {
  switch (which) {
    case 0:
      restore(world_, Snapshot());
      break;
    case 1:
      apply_changes(scratch_, SnapshotChanges(), restored_);
      break;
    default: {
      std::vector<std::byte> bytes = bytes_of(world_);
      bytes.resize(bytes.size() / 2);
      restore(world_, read_snapshot(bytes));
      break;
    }
  }
}

}  // namespace scree::determinism
