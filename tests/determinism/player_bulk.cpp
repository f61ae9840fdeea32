// The player's calls that create and destroy many bodies at once.
#include <tests/determinism/player.h>

#include <vector>

namespace scree::determinism {

namespace {

std::uint32_t bulk_size(const Call& call) { return static_cast<std::uint32_t>(call.seed & 0xffff); }

}  // namespace

// Creates bodies without shapes, in consecutive slots.
void Player::create_empty(const Call& call) {
  constexpr std::uint32_t kCount = 3;
  if (model_.slots.size() < kBulkSlots) model_.slots.resize(kBulkSlots);
  const std::uint32_t first = call.slot % (kBulkSlots - kCount);
  Random random(call.seed);
  std::vector<BodyDef> defs;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    empty_slot(model_.slots[first + i]);
    defs.push_back(random_body_def(random));
  }
  tell("create_bodies", defs[0], defs[1], defs[2]);
  std::vector<BodyId> ids(kCount);
  world_.create_bodies(defs, ids);
  for (std::uint32_t i = 0; i < kCount; ++i) model_.slots[first + i].body = ids[i];
  model_.bodies += kCount;
}

void Player::create_bulk(const Call& call) {
  const std::uint32_t count = bulk_size(call);
  if (model_.slots.size() < call.slot + count) model_.slots.resize(call.slot + count);
  destroy_bulk(call);
  Random random(call.seed);
  std::vector<BodyDef> defs;
  std::vector<Geometry> geometries;
  for (std::uint32_t i = 0; i < count; ++i) {
    defs.push_back(random_body_def(random));
    defs.back().type = BodyType::dynamic;
    defs.back().can_sleep = true;
    defs.back().locks = AxisLocks::none;
    geometries.push_back(random_geometry(random));
  }
  Material material = random_material(random);
  material.surface_velocity = {};
  tell("create_bodies", defs.front().position, "to", defs.back().position, count, material);
  std::vector<BodyId> ids(count);
  world_.create_bodies(defs, geometries, material, {}, ids);
  model_.bodies += count;
  model_.shapes += count;
  for (std::uint32_t i = 0; i < count; ++i) {
    Slot& slot = model_.slots[call.slot + i];
    slot.body = ids[i];
    slot.shapes.resize(1);
    if (world_.shapes_of(ids[i], slot.shapes) != 1) fail("a body created with one shape has another number");
  }
}

void Player::destroy_bulk(const Call& call) {
  std::vector<BodyId> ids;
  for (std::uint32_t i = 0; i < bulk_size(call) && call.slot + i < model_.slots.size(); ++i) {
    Slot& slot = model_.slots[call.slot + i];
    if (slot.body == BodyId{}) continue;
    ids.push_back(slot.body);
    lose_joints(slot.body);
    model_.shapes -= slot.shapes.size();
    slot = Slot{};
  }
  tell("destroy_bodies", static_cast<std::uint32_t>(ids.size()));
  model_.bodies -= ids.size();
  world_.destroy_bodies(ids);
}

}  // namespace scree::determinism
