// Validation of colors after color_constraints and of blocks after pack_blocks; see validate_stages.h.
#ifdef SCREE_ASSERTIONS

#include <parallel/constraints/coloring.h>
#include <parallel/constraints/sort_constraints.h>
#include <parallel/validate/validate_stages.h>

#include <algorithm>
#include <span>
#include <utility>

namespace scree {

namespace {

const Constraints& constraints_of(const WorldData& data) {
  return static_cast<const Constraints&>(*data.constraints);
}

// A contact or joint and where it is listed agree with the edge.
void validate_edge(const WorldData& data, const Edge& edge, std::size_t place) {
  const std::size_t contacts = data.contacts.active.size();
  if (place < contacts) {
    const std::int32_t row = data.contacts.active[place];
    const Manifold& manifold = data.contacts.now.manifold[row];
    SCREE_ASSERT(edge.body_a == manifold.row_a && edge.body_b == manifold.row_b);
    SCREE_ASSERT(edge.color == data.contacts.now.color[row]);
    SCREE_ASSERT((edge.kind == EdgeKind::pushed_b) == ((manifold.info & kManifoldStatic) != 0));
    return;
  }
  const std::int32_t row = data.joints.active[place - contacts];
  const JointBodies ends = data.joints.bodies[row];
  SCREE_ASSERT((edge.body_a == ends.a && edge.body_b == ends.b) ||
               (edge.body_a == ends.b && edge.body_b == ends.a));
  SCREE_ASSERT(edge.color == data.joints.color[row]);
}

// Contacts or joints, packed.
struct Family {
  const Column<std::int32_t>& list;
  const Column<std::int32_t>& rows;  // in lane order
  const Column<simd::ConstraintChunk>& chunks;
  std::size_t store_rows;
  std::span<const std::uint16_t> keys;  // by place in the list
};

// Each has one lane, but those that another rank solves have none.
void validate_lanes(const Family& family, int lanes) {
  std::vector<std::uint8_t>& has_lane = validation_marks(family.store_rows);
  std::size_t count = 0;
  for (const simd::ConstraintChunk& chunk : family.chunks) {
    const std::int32_t end = chunk.first_lane + chunk.blocks * lanes;
    SCREE_ASSERT(chunk.first_lane >= 0 && chunk.lanes > 0);
    SCREE_ASSERT(chunk.blocks == (chunk.lanes + lanes - 1) / lanes);
    SCREE_ASSERT(std::cmp_less_equal(end, family.rows.size()));
    for (std::int32_t lane = chunk.first_lane; lane < chunk.first_lane + chunk.lanes; ++lane) {
      const auto row = static_cast<std::size_t>(family.rows[lane]);
      SCREE_ASSERT(row < family.store_rows);
      SCREE_ASSERT(has_lane[row] == 0);
      has_lane[row] = 1;
      ++count;
    }
    for (std::int32_t pad = chunk.first_lane + chunk.lanes; pad < end; ++pad) {
      SCREE_ASSERT(family.rows[pad] == family.rows[chunk.first_lane + chunk.lanes - 1]);
    }
  }
  SCREE_ASSERT(family.keys.size() == family.list.size());
  for (std::size_t i = 0; i < family.list.size(); ++i) {
    const bool is_here = family.keys[i] != kNotHere;
    SCREE_ASSERT((has_lane[static_cast<std::size_t>(family.list[i])] != 0) == is_here);
    count -= is_here ? 1 : 0;
  }
  SCREE_ASSERT(count == 0);
}

// Chunks of both families by their numbers, one behind the other in the blocks.
void validate_places(const Constraints& constraints, const simd::Kernels& kernels) {
  std::size_t offset = 0, contact = 0, joint = 0;
  const std::size_t count = constraints.contact_chunks.size() + constraints.joint_chunks.size();
  for (std::size_t number = 0; number < count; ++number) {
    const bool is_contact = contact < constraints.contact_chunks.size() &&
                            std::cmp_equal(constraints.contact_chunks[contact].number, number);
    SCREE_ASSERT(is_contact || joint < constraints.joint_chunks.size());
    const simd::ConstraintChunk& chunk =
        is_contact ? constraints.contact_chunks[contact] : constraints.joint_chunks[joint];
    SCREE_ASSERT(std::cmp_equal(chunk.number, number));
    SCREE_ASSERT(chunk.offset == offset);
    offset += static_cast<std::size_t>(chunk.blocks) *
              (is_contact ? kernels.contact.block_bytes[chunk.variant]
                          : kernels.joint.variant[chunk.variant].block_bytes);
    ++(is_contact ? contact : joint);
  }
  SCREE_ASSERT(offset == constraints.blocks.size());
}

// The number of the chunk that last wrote to each body.
class Writers {
 public:
  explicit Writers(std::size_t bodies) : last_(memory()) { last_.assign(bodies, -1); }

  void begin_stage(std::int32_t first_number) { first_number_ = first_number; }
  // `side` of the constraint in a lane of the chunk.
  void write(const simd::ConstraintChunk& chunk, simd::BodySide side, std::int32_t body, bool is_serial) {
    std::int32_t& last = last_.at(static_cast<std::size_t>(body));
    SCREE_ASSERT(last != chunk.number || chunk.hub == side);  // twice within a chunk: only a hub
    SCREE_ASSERT(is_serial || last < first_number_ || last == chunk.number);
    last = chunk.number;
  }

 private:
  static std::vector<std::int32_t>& memory() {
    thread_local std::vector<std::int32_t> last;
    return last;
  }
  std::vector<std::int32_t>& last_;
  std::int32_t first_number_ = 0;
};

struct BlockEnds {
  std::int32_t a, b;
  bool a_moves, b_moves;
};

BlockEnds ends_of_contact(const WorldData& data, std::int32_t row, const simd::ConstraintChunk&) {
  const Manifold& manifold = data.contacts.now.manifold[row];
  return {manifold.row_a, manifold.row_b, (manifold.info & kManifoldStatic) == 0, true};
}

BlockEnds ends_of_joint(const WorldData& data, std::int32_t row, const simd::ConstraintChunk& chunk) {
  const JointBodies ends = data.joints.bodies[row];
  return {ends.a, ends.b, chunk.fixed != simd::BodySide::a, chunk.fixed != simd::BodySide::b};
}

template <class EndsOf>
void validate_chunk(const WorldData& data, const simd::ConstraintChunk& chunk,
                    const Column<std::int32_t>& rows, Writers& writers, bool is_serial, EndsOf&& ends_of) {
  std::int32_t hub = -1;
  for (std::int32_t lane = chunk.first_lane; lane < chunk.first_lane + chunk.lanes; ++lane) {
    const BlockEnds ends = ends_of(data, rows[lane], chunk);
    for (const simd::BodySide side : {simd::BodySide::a, simd::BodySide::b}) {
      const bool is_a = side == simd::BodySide::a;
      const std::int32_t body = is_a ? ends.a : ends.b;
      const bool moves = is_a ? ends.a_moves : ends.b_moves;
      SCREE_ASSERT(moves == (data.bodies.type[body] == BodyType::dynamic));
      if (moves) writers.write(chunk, side, body, is_serial);
      if (chunk.hub != side) continue;
      SCREE_ASSERT(hub == -1 || hub == body);
      hub = body;
    }
  }
}

void validate_stages_of(const WorldData& data, const Constraints& constraints) {
  Writers writers(data.bodies.flags.size());
  std::size_t contact = 0, joint = 0, number = 0;
  for (const ColorStage& stage : constraints.stages) {
    SCREE_ASSERT(std::cmp_equal(stage.first_contact_chunk, contact));
    SCREE_ASSERT(std::cmp_equal(stage.first_joint_chunk, joint));
    writers.begin_stage(static_cast<std::int32_t>(number));
    for (std::int32_t i = 0; i < stage.joint_chunk_count; ++i, ++joint, ++number) {
      validate_chunk(data, constraints.joint_chunks[joint], constraints.joint_lanes, writers, stage.serial,
                     ends_of_joint);
    }
    for (std::int32_t i = 0; i < stage.contact_chunk_count; ++i, ++contact, ++number) {
      validate_chunk(data, constraints.contact_chunks[contact], constraints.contact_lanes, writers,
                     stage.serial, ends_of_contact);
    }
  }
  SCREE_ASSERT(contact == constraints.contact_chunks.size());
  SCREE_ASSERT(joint == constraints.joint_chunks.size());
}

// Whether each of [0, numbers.size()) comes once.
bool is_permutation(std::span<const std::int32_t> numbers) {
  thread_local Column<std::uint8_t> seen;
  seen.resize_discarding(numbers.size());
  std::fill(seen.begin(), seen.end(), std::uint8_t{0});
  return std::all_of(numbers.begin(), numbers.end(), [&](std::int32_t number) {
    return number >= 0 && std::cmp_less(number, numbers.size()) &&
           std::exchange(seen[number], std::uint8_t{1}) == 0;
  });
}

void validate_chunk_orders(const Constraints& constraints) {
  std::span<const std::int32_t> order = constraints.chunk_order.span();
  for (const ColorStage& stage : constraints.stages) {
    const auto count = static_cast<std::size_t>(stage.joint_chunk_count + stage.contact_chunk_count);
    SCREE_ASSERT(order.size() >= count);
    SCREE_ASSERT(is_permutation(order.first(count)));
    order = order.subspan(count);
  }
  SCREE_ASSERT(order.empty());
  SCREE_ASSERT(constraints.share_order.size() ==
               constraints.contact_chunks.size() + constraints.joint_chunks.size());
  SCREE_ASSERT(is_permutation(constraints.share_order.span()));
}

}  // namespace

void validate_colors(const WorldData& data) {
  if (!is_validated(data)) return;
  const Constraints& constraints = constraints_of(data);
  thread_local Column<BodyColors> bodies;
  bodies.resize_discarding(data.bodies.flags.size());
  for (BodyColors& colors : bodies) colors = {};
  SCREE_ASSERT(constraints.edges.size() == data.contacts.active.size() + data.joints.active.size());
  for (std::size_t place = 0; place < constraints.edges.size(); ++place) {
    const Edge& edge = constraints.edges[place];
    validate_edge(data, edge, place);
    if (edge.kind == EdgeKind::pushed_b ? edge.color == kStaticHubColor : edge.color == kOverflowColor)
      continue;
    SCREE_ASSERT(edge.color < color_limit(edge.kind));
    const Masks masks = masks_of(bodies, edge);
    const std::uint64_t bit = std::uint64_t{1} << edge.color;
    SCREE_ASSERT(((masks.a | masks.b) & bit) == 0);
    masks.a |= bit;
    masks.b |= bit;
  }
}

void validate_blocks(const WorldData& data, const Crew& crew) {
  if (!is_validated(data)) return;
  const Constraints& constraints = constraints_of(data);
  const int lanes = crew.kernels().lanes;
  const std::span<const std::uint16_t> keys = constraints.keys.span();
  const std::size_t contacts = data.contacts.active.size();
  validate_lanes({data.contacts.active, constraints.contact_lanes, constraints.contact_chunks,
                  data.contacts.now.pair.size(), keys.first(contacts)},
                 lanes);
  validate_lanes({data.joints.active, constraints.joint_lanes, constraints.joint_chunks,
                  data.joints.flags.size(), keys.subspan(contacts)},
                 lanes);
  validate_places(constraints, crew.kernels());
  validate_stages_of(data, constraints);
  validate_chunk_orders(constraints);
}

}  // namespace scree

#endif
