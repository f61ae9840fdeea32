// What travels with a body to a rank that comes to have it: all columns of its rows and of its shapes' rows,
// but those that are on all ranks, and scratch that says nothing between two stages.
#pragma once

#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <core/world/wake.h>
#include <parallel/distributed/local_columns.h>
#include <parallel/distributed/messages.h>
#include <parallel/islands/islands.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

namespace scree {

// What is known of a joint where it is solved.
struct SentJoint {
  JointImpulses impulses;
  std::int32_t joint;
  std::uint8_t color;
  std::uint8_t unused[alignof(JointImpulses) - 5];  // no gap, as files hold it
};
static_assert(sizeof(SentJoint) == sizeof(JointImpulses) + alignof(JointImpulses));

inline SentJoint sent_joint(const Joints& joints, std::int32_t joint) {
  return {joints.impulses[joint], joint, joints.color[joint], {}};
}

inline void take_joint(Joints& joints, const SentJoint& sent) {
  joints.color[sent.joint] = sent.color;
  joints.impulses[sent.joint] = sent.impulses;
  joints.marks.mark(sent.joint);
}

// Whether calls have destroyed the shape or made another one in its slot, since pairs were listed.
inline bool has_changed(const Shapes& shapes, std::int32_t shape) {
  return (shapes.flags[shape] & (kShapeAlive | kShapeNew)) != kShapeAlive;
}

inline std::vector<std::int32_t> shapes_of(const WorldData& data, std::span<const std::int32_t> bodies) {
  std::vector<std::int32_t> shapes;
  for (const std::int32_t body : bodies) {
    for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape])
      shapes.push_back(shape);
  }
  return shapes;
}

template <class Store>
std::size_t bytes_of_row(const Store& store) {
  std::size_t bytes = 0;
  for_each_local_column(store, LocalColumns::travelling,
                        [&](const auto& column) { bytes += sizeof *column.data(); });
  return bytes;
}

// Column by column.
template <class Store>
void append_rows(const Store& store, std::span<const std::int32_t> rows, std::byte*& to) {
  for_each_local_column(store, LocalColumns::travelling, [&](const auto& column) {
    for (const std::int32_t row : rows) {
      std::memcpy(to, &column[row], sizeof column[row]);
      to += sizeof column[row];
    }
  });
}

// Of rows that is_taken(row) holds for.
template <class Store, class IsTaken>
void take_rows(Store& store, std::span<const std::int32_t> rows, const std::byte*& from, IsTaken&& is_taken) {
  for_each_local_column(store, LocalColumns::travelling, [&](auto& column) {
    for (const std::int32_t row : rows) {
      if (is_taken(row)) std::memcpy(static_cast<void*>(&column[row]), from, sizeof column[row]);
      from += sizeof column[row];
    }
  });
  for (const std::int32_t row : rows) store.marks.mark(row);
}

// For each body whether it sleeps, for each shape whether it is dirty; then the rows.
inline std::size_t message_bytes(const WorldData& data, std::size_t bodies, std::size_t shapes) {
  return bodies * (1 + bytes_of_row(data.bodies)) + shapes * (1 + bytes_of_row(data.shapes));
}

// What calls have left to do must have been done, see place_matter().
inline void send_bodies(Transport& transport, std::int32_t to, const WorldData& data,
                        std::span<const std::int32_t> sent) {
  const std::vector<std::int32_t> shapes = shapes_of(data, sent);
  std::vector<std::byte> message(message_bytes(data, sent.size(), shapes.size()));
  std::byte* end = message.data();
  for (const std::int32_t body : sent) *end++ = std::byte{is_asleep(data.bodies, body)};
  for (const std::int32_t shape : shapes) *end++ = std::byte{(data.shapes.flags[shape] & kShapeDirty) != 0};
  append_rows(data.bodies, sent, end);
  append_rows(data.shapes, shapes, end);
  transport.send(to, message);
}

// Notes for refresh_lists that the body comes or goes; the trees of its shapes follow. A body that is absent
// does not count as asleep.
inline void set_absent(WorldData& data, std::int32_t body, bool absent, bool asleep = false) {
  Bodies& bodies = data.bodies;
  bodies.asleep += (asleep ? 1 : 0) - (is_asleep(bodies, body) ? 1 : 0);
  bodies.flags[body] = static_cast<std::uint8_t>(bodies.flags[body] & ~kBodyAsleep);
  if (asleep) bodies.flags[body] |= std::uint8_t{kBodyAsleep};
  bodies.is_absent[body] = absent ? 1 : 0;
  if (absent) bodies.moments.erase(body);
  note_change(bodies, body);
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.tree[shape] = absent ? TreeKind::none : tree_of(data.bodies, body);
    note_change(data.shapes, shape);
  }
}

inline void receive_bodies(Transport& transport, std::int32_t from, WorldData& data,
                           std::span<const std::int32_t> received) {
  const FpEnvironment environment;
  Bodies& bodies = data.bodies;
  const std::vector<std::int32_t> shapes = shapes_of(data, received);
  const std::span<const std::byte> message = transport.receive(from);
  if (message.size() != message_bytes(data, received.size(), shapes.size())) refuse_world_of(from);
  const std::byte* next = message.data();
  for (const std::int32_t body : received) {
    const bool asleep = *next++ != std::byte{0};
    if (is_absent(bodies, body)) {
      zero_row(bodies, body, LocalColumns::staying);
      set_absent(data, body, false, asleep);
    } else if (!asleep) {
      wake_body(data, body);
    } else if (!is_asleep(bodies, body)) {
      refuse_world_of(from);  // owners do not put bodies to sleep by themselves
    }
  }
  for (const std::int32_t shape : shapes) {
    if (*next++ != std::byte{0}) mark_dirty(data.shapes, shape);
  }
  const auto all = [](std::int32_t) { return true; };
  take_rows(bodies, received, next, all);
  take_rows(data.shapes, shapes, next, all);
  for (const std::int32_t body : received) place_joints_of(data, body);
}

}  // namespace scree
