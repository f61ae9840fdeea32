// Laws of keyframes of which each rank writes a part: a player has them as a whole or not at all, and refuses
// damage.
#include <scree/distributed_world.h>
#include <sys/resource.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/parallel/recording/recording_fixture.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace scree::test {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

constexpr int kRanks = 3;

// Passes all on, until it cannot write.
class FailingTransport final : public Transport {
 public:
  explicit FailingTransport(Transport& through) : through_(through) {}
  int rank() const override { return through_.rank(); }
  int ranks() const override { return through_.ranks(); }
  void send(int to, std::span<const std::byte> message) override { through_.send(to, message); }
  std::span<const std::byte> receive(int from) override { return through_.receive(from); }
  void add_up(std::span<std::int64_t> values) override { through_.add_up(values); }
  void write_together(const std::string& file, std::uint64_t offset,
                      std::span<const std::byte> part) override {
    std::int64_t failures = fails ? 1 : 0;
    through_.add_up({&failures, 1});
    if (failures == 0) return through_.write_together(file, offset, part);
    throw Error(fails ? "the disk of this rank is broken" : "another rank's disk is broken");
  }
  bool fails = false;

 private:
  Transport& through_;
};

// Of a small pile with a hull, which comes late.
Bytes record_on_ranks() {
  const TemporaryFile file;
  const std::string name = file.path();
  const auto errors = run_ranks(kRanks, [&](int, Transport& transport) {
    scenes::Scene scene = scenes::build("pile", {{"bodies", 40}}).front();
    World whole(scene.settings);
    scenes::populate(whole, scene);
    DistributedWorld world(std::move(whole), transport, {.steps_per_look = 3, .imbalance = 1.0f});
    Workers workers(1);
    world.record(name, workers, {.keyframe_spacing = 6, .flush_interval = 0.01f});
    for (int i = 0; i < 20; ++i) {
      if (i == 9)
        world.world().add_shape(world.world().create_body({.position = {0, 6, 0}}), ConvexHull{wedge()});
      world.step(kStep, workers);
    }
    world.finish_recording(workers);
  });
  EXPECT_EQ(all_of(errors), "");
  return file.bytes();
}

TEST(SharedKeyframe, HasAPartOfEachRank) {
  const TakenApart parts(record_on_ranks());
  int keyframes = 0;
  for (std::size_t i = 0; i < parts.chunks.size(); ++i) {
    if (parts.chunks[i].head.kind != ChunkKind::keyframe) continue;
    ++keyframes;
    std::uint64_t bytes = 0;
    for (std::size_t rank = 0; rank < kRanks; ++rank) {
      ASSERT_LT(i + 1 + rank, parts.chunks.size());
      const TakenApart::Chunk& part = parts.chunks[i + 1 + rank];
      EXPECT_EQ(part.head.kind, ChunkKind::part);
      EXPECT_EQ(part.head.step, parts.chunks[i].head.step);
      EXPECT_EQ(part.head.count, std::uint64_t{kRanks});
      EXPECT_GT(part.content.size(), 1000u) << "the rank has no bodies";
      bytes += kChunkHeadBytes + part.head.stored_bytes;
    }
    EXPECT_EQ(parts.chunks[i].head.count, bytes);
  }
  EXPECT_EQ(keyframes, 5);
}

// The chunks that are whole when a file ends at `length`; a keyframe is whole when its parts are.
struct Remainder {
  std::size_t end;
  std::uint64_t steps = 0, keyframes = 0;
};
Remainder remainder_of(const TakenApart& parts, std::size_t length) {
  Remainder remainder{parts.head.size()};
  for (std::size_t i = 0; i < parts.chunks.size(); ++i) {
    const ChunkHead& head = parts.chunks[i].head;
    const bool is_keyframe = head.kind == ChunkKind::keyframe;
    const std::size_t end = parts.chunks[i].offset + kChunkHeadBytes +
                            static_cast<std::size_t>(head.stored_bytes + (is_keyframe ? head.count : 0));
    if (end > length) break;
    remainder.end = std::max(remainder.end, end);
    remainder.steps += head.steps;
    remainder.keyframes += is_keyframe ? 1 : 0;
  }
  return remainder;
}

TEST(SharedKeyframe, IsLostAsAWholeWhereTheFileIsCut) {
  const Bytes bytes = record_on_ranks();
  const TakenApart parts(bytes);
  Workers workers(1);
  std::vector<std::size_t> lengths;
  for (const TakenApart::Chunk& chunk : parts.chunks) {
    for (const std::size_t more : {0u, 1u, 64u, 65u}) lengths.push_back(chunk.offset + more);
  }
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) lengths.push_back(random() % bytes.size());
  for (const std::size_t length : lengths) {
    if (length >= bytes.size()) continue;
    const Remainder expected = remainder_of(parts, length);
    if (expected.keyframes == 0) {
      EXPECT_NE(error_of_call([&] { Player player(cut(bytes, length)); }), "") << length;
      continue;
    }
    Player player(cut(bytes, length));
    ASSERT_EQ(player.info().lost_bytes, length - expected.end) << length;
    ASSERT_EQ(player.info().last_step, expected.steps) << length;
    ASSERT_EQ(player.info().keyframes, expected.keyframes) << length;
    ASSERT_EQ(verified(player, workers), "") << length;
  }
}

// As where a rank has died while the others wrote.
TEST(SharedKeyframe, IsLostAsAWholeWhereAPartWasNotWritten) {
  const Bytes bytes = record_on_ranks();
  const TakenApart parts(bytes);
  Workers workers(1);
  for (std::size_t i = 1; i < parts.chunks.size(); ++i) {
    const TakenApart::Chunk& part = parts.chunks[i];
    if (part.head.kind != ChunkKind::part) continue;
    std::size_t keyframe = i, last = i;
    while (parts.chunks[keyframe].head.kind == ChunkKind::part) --keyframe;
    while (parts.chunks[last + 1].head.kind == ChunkKind::part) ++last;
    if (keyframe < 3) continue;  // without the first one it is no recording
    Bytes holed = cut(bytes, parts.chunks[last + 1].offset);
    const std::size_t stored = static_cast<std::size_t>(part.head.stored_bytes);
    for (const std::size_t written : {std::size_t{0}, kChunkHeadBytes, kChunkHeadBytes + stored / 2}) {
      const auto begin = holed.begin() + static_cast<std::ptrdiff_t>(part.offset);
      std::fill(begin + static_cast<std::ptrdiff_t>(written),
                begin + static_cast<std::ptrdiff_t>(kChunkHeadBytes + stored), std::byte{});
      Player player(holed);
      EXPECT_EQ(player.info().lost_bytes, holed.size() - parts.chunks[keyframe].offset);
      EXPECT_EQ(player.info().last_step, parts.chunks[keyframe].head.step);
      EXPECT_EQ(verified(player, workers), "");
      holed = cut(bytes, parts.chunks[last + 1].offset);
    }
  }
}

TEST(SharedKeyframe, OfWhichAPartIsChangedIsRefused) {
  const Bytes bytes = record_on_ranks();
  const TakenApart parts(bytes);
  Workers workers(1);
  const auto expect_refused = [&](const Bytes& wrong, const std::string& reason) {
    const std::string error = error_of_call([&] {
      Player player(wrong);
      player.verify(player.info().first_step, player.info().last_step, workers);
    });
    EXPECT_NE(error.find(reason), std::string::npos) << error;
    EXPECT_EQ(error.find("Player: byte "), 0u) << error;
  };
  for (const TakenApart::Chunk& chunk : parts.chunks) {
    if (chunk.head.kind != ChunkKind::part) continue;
    Bytes wrong = bytes;
    wrong[chunk.offset + kChunkHeadBytes + 30] ^= std::byte{4};
    expect_refused(wrong, "checksum");
  }
  TakenApart other = parts;
  const auto first_part =
      static_cast<std::size_t>(other.find(ChunkKind::part) - other.chunks.data());  // of the first keyframe
  other.chunks.erase(other.chunks.begin() + static_cast<std::ptrdiff_t>(first_part));
  expect_refused(other.put_together(), "of 3 ranks");
  other = parts;
  other.find(ChunkKind::keyframe)->head.count = 0;
  expect_refused(other.put_together(), "the parts of a keyframe are not those that its head says");
  other = parts;
  std::swap(other.chunks[first_part].content, other.chunks[first_part + 1].content);
  Player swapped(other.put_together());  // who has a body does not matter
  EXPECT_EQ(verified(swapped, workers), "");
  other = parts;
  other.find(ChunkKind::part)->content[0] ^= std::byte{1};
  expect_refused(other.put_together(), "other columns");
  other = parts;
  other.find(ChunkKind::part)->content.pop_back();
  expect_refused(other.put_together(), "ends too early");
  other = parts;
  other.find(ChunkKind::part)->content.push_back({});
  expect_refused(other.put_together(), "more follows");
}

// What other ranks have written is checked, too: it is refused, or is some world.
TEST(SharedKeyframe, WithChecksumsThatFitNeverCorruptsAWorld) {
  const Bytes bytes = record_on_ranks();
  std::mt19937 random(11);
  Workers workers(1);
  int refused = 0;
  constexpr int kTries = 120;
  for (int i = 0; i < kTries; ++i) {
    TakenApart parts(bytes);
    std::vector<TakenApart::Chunk*> of_ranks;
    for (TakenApart::Chunk& chunk : parts.chunks) {
      if (chunk.head.kind == ChunkKind::part) of_ranks.push_back(&chunk);
    }
    Bytes& content = of_ranks[random() % of_ranks.size()]->content;
    const std::uint32_t values[] = {0u, 1u, 0xffffffffu, 0x7fffffffu, 0x7fc00000u, 1u << (i % 32)};
    const std::size_t place = 8 + random() % (content.size() - 12);
    std::memcpy(content.data() + (i % 2 == 0 ? place / 4 * 4 : place), &values[i % 6], 4);
    const Bytes changed = parts.put_together();
    const std::string error = error_of_call([&] {
      Player player(changed);
      for (const std::uint64_t step : player.keyframe_steps()) {
        player.seek(step, workers);
        if (step < player.info().last_step) player.step(workers);
      }
    });
    if (error.empty()) continue;
    EXPECT_EQ(error.find("Player: byte "), 0u) << error;
    ++refused;
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, kTries);
}

// Ranks that play it find a wrong hash at its step, as a single process does, and refuse parts that do not
// fit.
TEST(SharedKeyframe, OfWhichAPartIsChangedIsRefusedByRanks) {
  const TemporaryFile file;
  const auto told = [&](const TakenApart& parts) {
    const Bytes bytes = parts.put_together();
    std::ofstream(file.path(), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const auto errors = run_ranks(2, [&](int, Transport& transport) {
      Workers workers(1);
      play_recording(file.path(), 0, 20, transport, workers);
    });
    EXPECT_EQ(errors[0], errors[1]);
    return errors[0];
  };
  const TakenApart whole(record_on_ranks());
  EXPECT_EQ(told(whole), "");
  TakenApart parts = whole;
  int changed = 0;
  for (TakenApart::Chunk& chunk : parts.chunks) changed += change_hash(chunk, 14) ? 1 : 0;
  ASSERT_EQ(changed, 1);
  EXPECT_NE(told(parts).find("step 14 has another hash than the recorded one"), std::string::npos);
  parts = whole;
  TakenApart::Chunk* const first = parts.find(ChunkKind::part);
  first[1].content = first[0].content;
  EXPECT_NE(told(parts).find("has sent what does not fit"), std::string::npos);
  std::mt19937 random(17);
  int refused = 0;
  for (int i = 0; i < 60; ++i) {  // is refused, or is some world
    parts = whole;
    Bytes& content = parts.find(ChunkKind::part)[random() % kRanks].content;
    const std::uint32_t values[] = {0u, 1u, 0xffffffffu, 0x7fffffffu, 0x7fc00000u, 1u << (i % 32)};
    std::memcpy(content.data() + 8 + random() % (content.size() - 12), &values[i % 6], 4);
    refused += told(parts).empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 0);
}

// No chance bytes are in a file.
TEST(SharedKeyframe, HasTheSameBytesEachTime) {
  EXPECT_EQ(TakenApart(record_on_ranks()).states(), TakenApart(record_on_ranks()).states());
}

TEST(SharedKeyframe, IsNoneWithoutItsParts) {
  TakenApart parts(record_on_ranks());
  TakenApart::Chunk* const first = parts.find(ChunkKind::part);
  for (TakenApart::Chunk* chunk : {first, first + 1, first + 2}) {  // of a kind that readers may skip
    chunk->head.kind = static_cast<ChunkKind>(77);
    chunk->head.flags |= kChunkMayBeSkipped;
  }
  const std::string error = error_of_call([&] { Player player(parts.put_together()); });
  EXPECT_EQ(error.find("Player: byte "), 0u) << error;
}

// A world of two ranks, which is recorded; `disturb(rank, step, transport, world)` comes before each step.
// The world must go on as one that is not recorded.
template <class Disturb>
void record_disturbed(const std::string& name, Disturb&& disturb) {
  constexpr int kSteps = 24;
  const auto make = [] {
    scenes::Scene scene = scenes::build("pile", {{"bodies", 40}}).front();
    World world(scene.settings);
    scenes::populate(world, scene);
    return world;
  };
  World one = make();
  Workers workers(1);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < kSteps; ++i) {
    step(one, kStep, workers);
    hashes.push_back(one.hash());
  }
  const auto errors = run_ranks(2, [&](int rank, Transport& transport) {
    FailingTransport failing(transport);
    DistributedWorld world(make(), failing, {.steps_per_look = 3, .imbalance = 1.0f});
    Workers of_rank(1);
    world.record(name, of_rank, {.keyframe_spacing = 5, .flush_interval = 0.01f});
    for (int i = 0; i < kSteps; ++i) {
      disturb(rank, i, failing, world);
      world.step(kStep, of_rank);
      ASSERT_EQ(world.hash(), hashes[static_cast<std::size_t>(i)]) << "step " << i;
    }
    EXPECT_NE(error_of_call([&] { world.finish_recording(of_rank); }), "");
    EXPECT_EQ(error_of_call([&] { world.finish_recording(of_rank); }), "");
    world.record(name + ".again", of_rank);
    world.step(kStep, of_rank);
    world.finish_recording(of_rank);
  });
  EXPECT_EQ(all_of(errors), "");
  Player again(name + ".again");
  EXPECT_EQ(verified(again, workers), "");
  std::filesystem::remove(name + ".again");
}

TEST(SharedKeyframe, WhichARankCannotWriteEndsTheRecordingAlone) {
  const TemporaryFile file;
  std::string told;
  record_disturbed(file.path(), [&](int rank, int i, FailingTransport& transport, DistributedWorld& world) {
    if (rank == 1) transport.fails = i >= 12 && i < 20;
    if (rank == 0 && i == 23) told = world.recorder()->error();
  });
  EXPECT_NE(told.find("rank 1: the disk of this rank is broken"), std::string::npos) << told;
  Player player(file.path());
  EXPECT_FALSE(player.info().finished);
  EXPECT_EQ(player.info().last_step, 15u);
  Workers workers(1);
  EXPECT_EQ(verified(player, workers), "");
}

// Else other ranks would write into the file that has the name now.
TEST(SharedKeyframe, IsNotWrittenToAnotherFileOfTheName) {
  const TemporaryFile file, moved;
  const std::string others = "of somebody else";
  record_disturbed(file.path(), [&](int rank, int i, FailingTransport&, DistributedWorld&) {
    if (rank != 0 || i != 12) return;
    std::filesystem::rename(file.path(), moved.path());
    std::ofstream(file.path()) << others;
  });
  EXPECT_EQ(file.bytes().size(), others.size());
  Player player(moved.path());
  EXPECT_EQ(player.info().last_step, 15u);
  Workers workers(1);
  EXPECT_EQ(verified(player, workers), "");
}

TEST(SharedKeyframe, BeyondALimitOfTheFilesSizeEndsTheRecordingAlone) {
  const TemporaryFile file;
  struct Limit {
    Limit() { getrlimit(RLIMIT_FSIZE, &before); }
    ~Limit() { setrlimit(RLIMIT_FSIZE, &before); }
    rlimit before{};
  } limit;
  record_disturbed(file.path(), [&](int rank, int i, FailingTransport&, DistributedWorld& world) {
    if (rank != 0) return;
    rlimit small = limit.before;
    if (i == 13) small.rlim_cur = world.recorder()->bytes_written() + 2000;
    if (i == 13 || i == 23) setrlimit(RLIMIT_FSIZE, &small);
  });
  Player player(file.path());
  EXPECT_EQ(player.info().last_step, 15u);
}

TEST(SharedKeyframe, NeedsAFileToWhichManyCanWrite) {
  const auto errors = run_ranks(2, [&](int, Transport& transport) {
    World whole;
    whole.add_shape(whole.create_body({}), Sphere{1});
    DistributedWorld world(std::move(whole), transport);
    Workers workers(1);
    const std::string error = error_of_call([&] { world.record("/dev/null", workers); });
    EXPECT_NE(error.find("regular file"), std::string::npos) << error;
    world.step(kStep, workers);
    EXPECT_EQ(world.recorder(), nullptr);
  });
  EXPECT_EQ(all_of(errors), "");
}

}  // namespace
}  // namespace scree::test
