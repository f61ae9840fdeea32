// See order_chunks.h.
#include <parallel/constraints/order_chunks.h>

#include <algorithm>

namespace scree {
namespace {

// The lower of two bodies that can be pushed, or the one that can.
std::int32_t pushed_of(const WorldData& data, std::int32_t a, std::int32_t b) {
  const auto is_pushed = [&](std::int32_t body) { return data.bodies.type[body] == BodyType::dynamic; };
  if (!is_pushed(a)) return b;
  return is_pushed(b) ? std::min(a, b) : a;
}

// Chunks list their constraints in the order of the bodies: the one in the middle stands for all.
std::int32_t middle_row(const simd::ConstraintChunk& chunk, const Column<std::int32_t>& rows) {
  return rows[chunk.first_lane + chunk.lanes / 2];
}

std::int32_t body_of_joints(const WorldData& data, const Constraints& constraints, std::int32_t chunk) {
  const JointBodies bodies =
      data.joints.bodies[middle_row(constraints.joint_chunks[chunk], constraints.joint_lanes)];
  return pushed_of(data, bodies.a, bodies.b);
}

std::int32_t body_of_contacts(const WorldData& data, const Constraints& constraints, std::int32_t chunk) {
  const Manifold& manifold =
      data.contacts.now.manifold[middle_row(constraints.contact_chunks[chunk], constraints.contact_lanes)];
  return pushed_of(data, manifold.row_a, manifold.row_b);
}

void sort(Column<ChunkPlace>& places) {
  std::sort(places.begin(), places.end(), [](const ChunkPlace& one, const ChunkPlace& other) {
    return one.place != other.place ? one.place < other.place : one.chunk < other.chunk;
  });
}

// The chunks of a stage by the places of their bodies; a stage that one thread runs stays as it is.
void place_chunks(const WorldData& data, const Constraints& constraints, const ColorStage& stage,
                  Column<ChunkPlace>& places) {
  places.clear();
  for (std::int32_t i = 0; i < stage.joint_chunk_count; ++i)
    places.push_back({body_of_joints(data, constraints, stage.first_joint_chunk + i), i});
  for (std::int32_t i = 0; i < stage.contact_chunk_count; ++i) {
    places.push_back(
        {body_of_contacts(data, constraints, stage.first_contact_chunk + i), stage.joint_chunk_count + i});
  }
  if (!stage.serial) sort(places);
}

}  // namespace

void order_chunks(const WorldData& data, Constraints& constraints) {
  Column<ChunkPlace>&places = constraints.chunk_places, &shares = constraints.chunk_shares;
  const auto joint_chunks = static_cast<std::int32_t>(constraints.joint_chunks.size());
  constraints.chunk_order.clear();
  constraints.share_order.clear();
  shares.clear();
  for (const ColorStage& stage : constraints.stages) {
    place_chunks(data, constraints, stage, places);
    const auto count = static_cast<std::int64_t>(places.size());
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int32_t chunk = places[i].chunk, contact_chunk = chunk - stage.joint_chunk_count;
      constraints.chunk_order.push_back(chunk);
      // In parts of 2^30 of the stage. What one thread runs is that of the calling thread, the first one.
      const auto share = stage.serial ? 0 : static_cast<std::int32_t>((i << 30) / count);
      shares.push_back({share, contact_chunk < 0 ? stage.first_joint_chunk + chunk
                                                 : joint_chunks + stage.first_contact_chunk + contact_chunk});
    }
  }
  sort(shares);
  for (const ChunkPlace& share : shares) constraints.share_order.push_back(share.chunk);
}

}  // namespace scree
