// Laws of keyframes of which each rank writes a part: a player has them as a whole or not at all, and refuses
// damage.
#include <scree/distributed_world.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/parallel/recording/recording_fixture.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace scree::test {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

constexpr int kRanks = 3;

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
    for (std::size_t rank = 1; rank < kRanks; ++rank) {
      ASSERT_LT(i + rank, parts.chunks.size());
      const TakenApart::Chunk& part = parts.chunks[i + rank];
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
