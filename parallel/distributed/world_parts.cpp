// See world_parts.h.
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/absent_rows.h>
#include <core/state/snapshot/saved_columns.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/world/edit.h>
#include <parallel/distributed/agree.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/give_events.h>
#include <parallel/distributed/local_columns.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/world_parts.h>
#include <scree/error.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

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

// Sheets of pairs and their contacts, in which dynamic bodies take part.
constexpr bool is_of_pairs(SheetId sheet) {
  switch (sheet) {
    case SheetId::pairs:
    case SheetId::pair_axes:
    case SheetId::resting:
    case SheetId::resting_axes:
    case SheetId::contacts_moving:
    case SheetId::contacts:
    case SheetId::free_contacts:
    case SheetId::contact_forces:
    case SheetId::events_resting:
      return true;
    default:
      return false;
  }
}

// Copies runs of the rows that do not travel; the others stay zero.
template <class Row>
void copy_staying(const WorldData& data, SheetId store, const Row* from, Column<Row>& to) {
  const auto stays = [&](std::size_t row) {
    if (store == SheetId::bodies) return !is_shared_out(data.bodies, row);
    return (data.shapes.flags[row] & kShapeAlive) == 0 || !is_shared_out(data.bodies, data.shapes.body[row]);
  };
  for (std::size_t first = 0; first < to.size();) {
    std::size_t end = first;
    while (end < to.size() && stays(end)) ++end;
    if (end > first)
      std::memcpy(static_cast<void*>(to.data() + first), from + first, (end - first) * sizeof(Row));
    first = end + 1;
  }
}

void copy_common_columns(WorldData& data, WorldData& common) {
  struct Rows {
    const void* first;
    std::size_t count;
  };
  std::vector<Rows> sources;
  for_each_saved_column(data, [&](const Member&, auto& column) {
    sources.push_back({column.data(), column.size()});
  });
  const Rows* next = sources.data();
  for_each_saved_column(common, [&](const Member& member, auto& column) {
    using Row = std::remove_cvref_t<decltype(column[0])>;
    const Rows from = *next++;
    if (is_of_pairs(member.sheet)) return;
    column.resize(from.count);
    if (is_of_present(member)) {
      copy_staying(data, member.rows, static_cast<const Row*>(from.first), column);
    } else if (from.count > 0) {
      std::memcpy(static_cast<void*>(column.data()), from.first, from.count * sizeof(Row));
    }
  });
}

// What is said of dynamic bodies outside of their rows; the messages have that, too.
void leave_out_travelling(WorldData& common) {
  for (std::size_t row = 0; row < common.bodies.flags.size(); ++row) {
    if (is_shared_out(common.bodies, row))
      common.bodies.flags[row] = static_cast<std::uint8_t>(common.bodies.flags[row] & ~kBodyAsleep);
  }
  for (std::size_t row = 0; row < common.shapes.flags.size(); ++row) {
    if ((common.shapes.flags[row] & kShapeAlive) != 0 &&
        is_shared_out(common.bodies, common.shapes.body[row]))
      common.shapes.tree[row] = TreeKind::none;
  }
  const auto is_told = [&](const SlotName& body) {
    const auto row = static_cast<std::int32_t>(body.index);
    return is_shared_out(common.bodies, row) && common.bodies.generation[row] == body.generation;
  };
  const auto leave_out = [](auto& list, auto&& is_left_out) {
    const auto* const end = std::remove_if(list.begin(), list.end(), is_left_out);
    list.drop_back(list.end() - end);
  };
  const auto is_told_pair = [&](const TouchingPair& pair) {
    return !is_there(common, pair) || is_told(pair.body_a) || is_told(pair.body_b);
  };
  leave_out(common.events.touching, [&](const TouchRow& row) { return is_told_pair(row.pair); });
  leave_out(common.events.sensed, is_told_pair);
  leave_out(common.events.woken, is_told);
}

}  // namespace

bool has_parts(const World& world) {
  const Border* const border = border_of(internals(world, "has_parts"));
  return border != nullptr && border->transport.ranks() > 1;
}

void save_common(World& world, SnapshotData& snapshot) {
  WorldData& data = internals(world);
  place_matter(data);
  if (!has_parts(world)) return save_world(data, snapshot, false);
  WorldData common;
  copy_common_columns(data, common);
  common.hulls.shared = data.hulls.shared;
  common.meshes.shared = data.meshes.shared;
  leave_out_travelling(common);
  save_world(common, snapshot, false);
  data.save_values(snapshot.world);
  snapshot.is_part = true;
}

std::vector<std::byte> messages_of_part(World& world, Crew& crew) {
  WorldData& data = internals(world);
  MessageWriter messages(border_of(data)->here, border_of(data)->transport.ranks());
  send_all_bodies(data, messages, crew);
  return messages.take();
}

namespace {

// All messages -> the world, of which nothing is shared out any more.
void receive_whole(WorldData& data, PartSource& source) {
  MessageReader messages(source);
  Workers workers(1);
  Crew crew(workers);
  divide_world(data, messages, std::vector<std::int32_t>(data.bodies.flags.size(), 0));
  std::vector<std::int32_t> all(static_cast<std::size_t>(source.ranks()));
  std::iota(all.begin(), all.end(), 0);
  receive_all_bodies(data, messages, all, crew);
  messages.check_end();
  data.border.reset();
}

// What ranks send to rank 0 now, one after the other.
class SentParts final : public PartSource {
 public:
  SentParts(Transport& transport, std::vector<std::byte> own) : transport_(transport), own_(std::move(own)) {}
  // Where the work has ended too early, nothing that was sent may stay on its way.
  ~SentParts() {
    try {
      while (next_ < ranks()) receive();
    } catch (...) {  // the rank has left, and its next message is missed
    }
  }
  SentParts(const SentParts&) = delete;
  SentParts& operator=(const SentParts&) = delete;
  int ranks() const override { return transport_.ranks(); }
  std::vector<std::byte> part(int rank) override {
    if (rank == 0) return std::move(own_);
    const std::span<const std::byte> message = receive();
    return {message.begin(), message.end()};
  }
  void refuse(int rank, std::size_t, const std::string&) const override { refuse_world_of(rank); }

 private:
  std::span<const std::byte> receive() { return transport_.receive(next_++); }
  Transport& transport_;
  std::vector<std::byte> own_;
  int next_ = 1;
};

World world_of_common(World& world) {
  Snapshot common;
  SnapshotAccess::data(common) = std::make_unique<SnapshotData>();
  save_common(world, *SnapshotAccess::data(common));
  World copy;
  restore(copy, common);
  return copy;
}

}  // namespace

std::optional<Error> save_whole(World& world, Snapshot& snapshot, Crew& crew) {
  WorldData& data = internals(world);
  Transport& transport = border_of(data)->transport;
  std::vector<std::byte> own;
  if (std::optional<Error> problem = agree(transport, attempt([&] {
                                             if (has_parts(world)) own = messages_of_part(world, crew);
                                           })))
    return problem;
  if (transport.rank() != 0) {
    send_list<std::byte>(transport, 0, std::exchange(own, {}));
    return tell_all(transport, std::optional<Error>{});
  }
  return tell_all(transport, attempt([&] {
                    SentParts parts(transport, std::move(own));
                    std::unique_ptr<SnapshotData>& saved = SnapshotAccess::data(snapshot);
                    if (!has_parts(world)) {
                      if (saved == nullptr) saved = std::make_unique<SnapshotData>();
                      return save_common(world, *saved);
                    }
                    World whole = world_of_common(world);
                    receive_whole(internals(whole), parts);
                    save(whole, snapshot);
                    saved->handle_tag = data.handle_tags.given;
                  }));
}

namespace {

// One rank's messages, as if a second rank had all else.
class OwnPart final : public PartSource {
 public:
  explicit OwnPart(std::vector<std::byte> part) : part_(std::move(part)) {}
  int ranks() const override { return 2; }
  std::vector<std::byte> part(int) override { return std::move(part_); }
  void refuse(int rank, std::size_t, const std::string&) const override { refuse_world_of(rank); }

 private:
  std::vector<std::byte> part_;
};

}  // namespace

World copy_part(World& world, Crew& crew) {
  World copy = world_of_common(world);
  if (!has_parts(world)) return copy;
  const Border& border = *border_of(internals(world));
  WorldData& data = internals(copy);
  OwnPart own(messages_of_part(world, crew));
  MessageReader messages(own);
  std::vector<std::int32_t> owners;
  for (const std::int32_t owner : border.owner)
    owners.push_back(owner == kEveryRank ? owner : owner == border.here ? 0 : 1);
  divide_world(data, messages, std::move(owners));
  constexpr std::int32_t kFrom[] = {0};
  receive_all_bodies(data, messages, kFrom, crew);
  messages.check_end();
  // Of joints, all ranks have what calls have said, and the owners of their bodies all else.
  for (std::size_t joint = 0; joint < data.joints.flags.size(); ++joint) {
    const JointBodies ends = data.joints.bodies[joint];
    if ((data.joints.flags[joint] & kJointAlive) == 0 || tells_of(border_of(data), ends.a, ends.b)) continue;
    data.joints.impulses[joint] = {};
    data.joints.color[joint] = kNoColor;
  }
  data.border.reset();
  return copy;
}

// Holds the world, a snapshot of it, and what that takes to check.
Snapshot add_parts(World world, PartSource& source) {
  receive_whole(internals(world), source);
  Snapshot whole;
  save(world, whole);
  world = World{};
  SnapshotData& saved = *SnapshotAccess::data(whole);
  check_saved(saved);
  saved.handle_tag = 0;  // of no world that anybody knows
  return whole;
}

namespace {

// The parts that a reader takes.
std::vector<std::int32_t> parts_of(const PartSource& source, const Transport& transport) {
  std::vector<std::int32_t> parts;
  for (int part = 0; part < source.ranks(); ++part) {
    if (reader_of(part, source.ranks(), transport.ranks()) == transport.rank()) parts.push_back(part);
  }
  return parts;
}

}  // namespace

std::vector<std::int32_t> find_owners(const World& common, PartSource& source, Transport& transport) {
  const Bodies& bodies = internals(common, "find_owners").bodies;
  std::vector<GivenBody> own;
  const std::optional<Error> problem =
      agree(transport, attempt([&] {
              for (const std::int32_t part : parts_of(source, transport)) {
                MessageReader messages(source);  // bodies come first
                for (const std::int32_t body : receive_list<std::int32_t>(messages, part))
                  own.push_back({body, part});
              }
            }));
  if (problem) throw *problem;
  std::vector<std::int32_t> owners(bodies.flags.size(), kEveryRank);
  for (const auto& [body, part] :
       gather_lists<GivenBody>(transport, own, [](const GivenBody&) { return true; })) {
    const bool is_expected = body >= 0 && std::cmp_less(body, owners.size()) && is_absent(bodies, body);
    if (!is_expected || std::exchange(owners[static_cast<std::size_t>(body)], part) != kEveryRank)
      refuse_world_of(part);
  }
  for (std::size_t row = 0; row < owners.size(); ++row) {
    if (bodies.is_absent[row] != 0 && owners[row] == kEveryRank)
      throw Error("no rank has sent body " + std::to_string(row));
  }
  return owners;
}

World read_share(World world, PartSource& source, std::span<const std::int32_t> part_of, Transport& transport,
                 Crew& crew) {
  WorldData& data = internals(world);
  const int parts = source.ranks(), readers = transport.ranks();
  std::vector<std::int32_t> owners(part_of.begin(), part_of.end());
  for (std::int32_t& owner : owners) owner = owner < 0 ? kEveryRank : reader_of(owner, parts, readers);
  divide_world(data, transport, std::move(owners));
  {
    MessageReader messages(source);
    receive_all_bodies(data, messages, parts_of(source, transport), crew);
    messages.check_end();
  }
  SnapshotData share;
  save_world(data, share, false);
  share.is_part = true;
  check_saved(share);
  return world;
}

}  // namespace scree
