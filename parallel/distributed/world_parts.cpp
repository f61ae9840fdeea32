// See world_parts.h.
#include <core/geometry/balls.h>
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/world/edit.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/local_columns.h>
#include <parallel/distributed/world_parts.h>
#include <scree/error.h>

#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <utility>

namespace scree {

std::uint64_t layout_of_parts() {
  const WorldData none;
  std::vector<std::uint64_t> layout{layout_of_columns(), kMessageLayout};
  const auto note = [&](const auto& column) { layout.push_back(sizeof *column.data()); };
  for_each_local_column(none.bodies, LocalColumns::travelling, note);
  for_each_local_column(none.shapes, LocalColumns::travelling, note);
  return hash_of_bytes(std::as_bytes(std::span(layout)));
}

namespace {

// Keeps what is sent, whoever it is for.
class MessageWriter final : public Transport {
 public:
  MessageWriter(int rank, int ranks) : rank_(rank), ranks_(ranks) {}
  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }
  void send(int, std::span<const std::byte> message) override {
    bytes_.put(std::uint64_t{message.size()});
    bytes_.put_bytes(message.data(), message.size());
  }
  std::span<const std::byte> receive(int) override { throw Error("MessageWriter: there is nobody to hear"); }
  std::vector<std::byte> take() { return bytes_.take(); }

 private:
  int rank_, ranks_;
  ByteWriter bytes_;
};

// Plays the messages of parts.
class MessageReader final : public Transport {
 public:
  explicit MessageReader(PartSource& source) : source_(source) {}
  int rank() const override { return 0; }
  int ranks() const override { return source_.ranks(); }
  void send(int, std::span<const std::byte>) override {
    throw Error("MessageReader: there is nobody to hear");
  }
  // One rank's messages after those of the rank before.
  std::span<const std::byte> receive(int from) override {
    if (from != from_) {
      check_end();
      part_ = source_.part(from);
      from_ = from;
      at_ = 0;
    }
    std::uint64_t bytes = 0;
    if (part_.size() - at_ < sizeof bytes) source_.refuse(from, at_, "the part of a rank ends too early");
    std::memcpy(&bytes, part_.data() + at_, sizeof bytes);
    if (bytes > part_.size() - at_ - sizeof bytes)
      source_.refuse(from, at_, "a message is longer than its part");
    const std::span<const std::byte> message =
        std::span(part_).subspan(at_ + sizeof bytes, static_cast<std::size_t>(bytes));
    at_ += sizeof bytes + message.size();
    return message;
  }
  // All messages of the part have been read.
  void check_end() const {
    if (at_ != part_.size()) source_.refuse(from_, at_, "more follows than the part should have");
  }

 private:
  PartSource& source_;
  std::vector<std::byte> part_;
  std::size_t at_ = 0;
  int from_ = -1;
};

// Of the type that a shape has; hulls are those that they are.
Geometry plain_geometry(const WorldData& data, std::int32_t shape) {
  switch (data.shapes.type[shape]) {
    case ShapeType::sphere:
      return Sphere{};
    case ShapeType::capsule:
      return Capsule{};
    case ShapeType::cylinder:
      return Cylinder{};
    case ShapeType::cone:
      return Cone{};
    case ShapeType::box:
      return Box{};
    case ShapeType::rounded_box:
      return Box{.rounding = 0.1f};
    case ShapeType::hull:
    case ShapeType::rounded_hull:
    case ShapeType::mesh:
    case ShapeType::half_space:
      break;
  }
  return geometry_of(data, shape);
}

// A snapshot must be that of some world, in which all bodies are there. Those that are absent are plain ones
// until other ranks' parts are read.
void write_plain_body(Bodies& bodies, std::int32_t body) {
  zero_row(bodies, body, LocalColumns::all);
  bodies.pose[body].rotation[3] = 1.0f;
  bodies.transform[body] = {};
  const bool jointed = bodies.first_joint[body] >= 0;
  bodies.motion[body] = {0.0f, 0.0f, 1.0f, jointed ? std::uint32_t{kMotionJointed} : 0u};
  bodies.local_mass[body].inverse_mass = 1.0f;
  bodies.marks.mark(body);
}

void write_plain_shape(WorldData& data, std::int32_t shape) {
  Shapes& shapes = data.shapes;
  const Geometry geometry = plain_geometry(data, shape);
  zero_row(shapes, shape, LocalColumns::all);
  write_extent(data, shape, geometry, slots_of(shapes, shape));
  write_material(shapes, shape, Material{});
  shapes.given_pose[shape] = {};
  place_shape_in_body(data, shape);
  shapes.pose[shape].rotation[3] = 1.0f;
  shapes.tree[shape] = tree_of(data.bodies, shapes.body[shape]);
}

void show_absent_bodies(WorldData& data) {
  for (std::size_t row = kFirstBody; row < data.bodies.flags.size(); ++row) {
    const auto body = static_cast<std::int32_t>(row);
    if ((data.bodies.flags[row] & kBodyAlive) == 0 || !is_absent(data.bodies, body)) continue;
    write_plain_body(data.bodies, body);
    for (std::int32_t shape = data.bodies.first_shape[row]; shape >= 0; shape = data.shapes.next[shape])
      write_plain_shape(data, shape);
    measure_core(data, body);
  }
}

void hide_absent_bodies(WorldData& data, Border& border) {
  for (std::size_t row = 0; row < data.shapes.flags.size(); ++row) {
    if ((data.shapes.flags[row] & kShapeAlive) == 0 || !is_absent(data.bodies, data.shapes.body[row]))
      continue;
    data.shapes.tree[row] = TreeKind::none;
    data.shapes.marks.mark(static_cast<std::int32_t>(row));
  }
  border.gone = data.bodies.flags.size();  // the memory of plain ones
}

}  // namespace

void save_first_part(World& world, SnapshotData& snapshot) {
  WorldData& data = internals(world);
  Border* const border = border_of(data);
  place_matter(data);
  std::exception_ptr problem;
  try {
    if (border != nullptr) show_absent_bodies(data);
    save_world(data, snapshot, false);
  } catch (...) {
    problem = std::current_exception();
  }
  if (border != nullptr) hide_absent_bodies(data, *border);
  if (problem != nullptr) std::rethrow_exception(problem);
}

std::vector<std::byte> messages_of_part(World& world, Crew& crew) {
  WorldData& data = internals(world);
  const Border& border = *border_of(data);
  MessageWriter messages(border.here, border.transport.ranks());
  send_all_bodies(data, messages, crew);
  return messages.take();
}

// Holds no more than two copies of the world at a time.
Snapshot add_parts(Snapshot first, PartSource& source) {
  std::optional<World> world(std::in_place);
  restore(*world, first);
  first = {};
  WorldData& data = internals(*world);
  MessageReader messages(source);
  Workers workers(1);
  Crew crew(workers);
  divide_world(data, messages, std::vector<std::int32_t>(data.bodies.flags.size(), 0));
  receive_all_bodies(data, messages, crew);
  messages.check_end();
  data.border.reset();
  Snapshot whole;
  save(*world, whole);
  world.reset();
  const std::vector<std::byte> bytes = write_snapshot(whole);
  whole = {};
  return read_snapshot(bytes);  // what ranks have sent was not checked so far
}

}  // namespace scree
