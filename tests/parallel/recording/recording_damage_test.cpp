// Laws of recordings that were truncated, damaged or changed on purpose.
#include <core/state/recording_format/recorded_calls.h>
#include <core/state/recording_format/value_bytes.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

namespace scree::test {
namespace {

#ifdef SCREE_SANITIZED
constexpr int kTrials = 80;
#else
constexpr int kTrials = 400;
#endif

// Plays all of the recording; returns the error if there is one.
std::string error_of_playing(const Bytes& bytes, Workers& workers) {
  return error_of_call([&] {
    Player player(bytes);
    player.verify(player.info().first_step, player.info().last_step, workers);
  });
}

TEST(RecordingDamage, OfAMissingEndLeavesTheCompleteSteps) {
  const Bytes bytes = small_recording();
  const TakenApart parts(bytes);
  ASSERT_GT(parts.chunks.size(), 7u);
  Workers workers(1);
  std::vector<std::size_t> lengths;
  for (const TakenApart::Chunk& chunk : parts.chunks) {
    for (const std::size_t more : {0u, 1u, 63u, 64u, 65u}) lengths.push_back(chunk.offset + more);
  }
  std::mt19937 random(7);
  for (int i = 0; i < kTrials / 8; ++i) lengths.push_back(random() % bytes.size());
  for (std::size_t length : lengths) {
    length = std::min(length, bytes.size() - 1);
    // The expected remainder: the chunks that end by then.
    std::uint64_t steps = 0, keyframes = 0;
    std::size_t end = parts.head.size();
    for (std::size_t i = 0; i < parts.chunks.size(); ++i) {
      const std::size_t next = i + 1 < parts.chunks.size() ? parts.chunks[i + 1].offset : bytes.size();
      if (next > length) break;
      end = next;
      steps += parts.chunks[i].head.steps;
      keyframes += parts.chunks[i].head.kind == ChunkKind::keyframe ? 1 : 0;
    }
    if (keyframes == 0) {
      EXPECT_NE(error_of_call([&] { Player player(cut(bytes, length)); }), "") << length;
      continue;
    }
    Player player(cut(bytes, length));
    ASSERT_FALSE(player.info().finished);
    ASSERT_EQ(player.info().lost_bytes, length - end) << length;
    ASSERT_EQ(player.info().last_step, steps) << length;
    ASSERT_EQ(player.info().keyframes, keyframes);
    ASSERT_EQ(verified(player, workers), "");
    ASSERT_EQ(player.position(), steps);
  }
}

TEST(RecordingDamage, OfAnyBitIsRefusedWithItsPlace) {
  const Bytes bytes = small_recording();
  Workers workers(1);
  std::mt19937 random(8);
  for (int i = 0; i < kTrials; ++i) {
    Bytes wrong = bytes;
    wrong[random() % bytes.size()] ^= static_cast<std::byte>(1u << random() % 8);
    const std::string error = error_of_playing(wrong, workers);
    ASSERT_EQ(error.find("Player: byte "), 0u) << error;
  }
  EXPECT_EQ(error_of_playing({}, workers), "Player: byte 0: the recording ends too early");
  Bytes wrong = bytes;
  wrong[0] = {};
  EXPECT_EQ(error_of_playing(wrong, workers), "Player: byte 0: this is no recording");
  wrong = bytes;
  wrong[8] = std::byte{12};
  EXPECT_EQ(error_of_playing(wrong, workers),
            "Player: byte 8: the recording has version 12, this is version 11");
  wrong = bytes;
  wrong.push_back({});
  EXPECT_NE(error_of_playing(wrong, workers), "") << "something follows the end";
}

TEST(RecordingDamage, OfAHashIsFoundAtItsStep) {
  TakenApart parts(small_recording());
  Workers workers(1);
  constexpr std::uint64_t kStep = 20;
  int changed = 0;
  for (TakenApart::Chunk& chunk : parts.chunks) changed += change_hash(chunk, kStep) ? 1 : 0;
  ASSERT_EQ(changed, 1);
  Player player(parts.put_together());
  const std::optional<Divergence> found = player.verify(0, 40, workers);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->step, kStep);
  EXPECT_EQ(found->expected_hash ^ found->actual_hash, std::uint64_t{1} << 56);
  EXPECT_EQ(found->compared_at, 30u) << "the next keyframe";
  EXPECT_EQ(found->difference, "") << "only the hash was wrong";
  EXPECT_FALSE(player.verify(0, kStep - 1, workers));
}

// Changes a call and seals the recording again.
TEST(RecordingDamage, OfACallIsFoundAtItsStepAndByBodyAndField) {
  const TemporaryFile file;
  Heap heap(5);
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(20);
  const float speed = 1.25f;
  heap.world.set_linear_velocity(heap.bodies[6], {speed, 5.0f, 0.0f});
  heap.run(20);
  recorder.finish();
  TakenApart parts(file.bytes());
  const auto* from = reinterpret_cast<const std::byte*>(&speed);
  int changed = 0;
  for (TakenApart::Chunk& chunk : parts.chunks) {
    if (chunk.head.kind != ChunkKind::calls) continue;
    const auto place = std::search(chunk.content.begin(), chunk.content.end(), from, from + sizeof speed);
    if (place == chunk.content.end()) continue;
    const float other = 1.5f;
    std::memcpy(&*place, &other, sizeof other);
    ++changed;
  }
  ASSERT_EQ(changed, 1);
  Player player(parts.put_together());
  const std::optional<Divergence> found = player.verify(0, 40, heap.workers);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->step, 21u);
  EXPECT_EQ(found->compared_at, 30u);
  const std::string body = "body " + std::to_string(heap.bodies[6].index) + ", position.x is ";
  EXPECT_EQ(found->difference.find(body), 0u) << found->difference;
  // After the next keyframe the recording agrees, whatever was played before.
  EXPECT_FALSE(player.verify(30, 40, heap.workers));
  ASSERT_TRUE(player.verify(0, 25, heap.workers));
  player.seek(31, heap.workers);
  EXPECT_FALSE(player.verify(player.position(), 40, heap.workers));
}

// Puts a call that no world accepts, or a hash that no world has, into the chunk of calls, before or after
// the record of a step.
void add_impossible_call(TakenApart& parts, std::uint64_t step, bool before) {
  TakenApart::Chunk& calls = *parts.find(ChunkKind::calls);
  ASSERT_TRUE(change_hash(calls, step));
  const std::vector<std::size_t> places = places_of_steps(calls.content, [](RecordedCall) {});
  const std::size_t place =
      places[static_cast<std::size_t>(step - calls.head.step - 1)] + (before ? 0 : kStepRecordBytes);
  ByteWriter call;
  write_value(call, RecordedCall::wake);
  write_value(call, BodyId{5, 77});
  calls.content.insert(calls.content.begin() + static_cast<std::ptrdiff_t>(place), call.bytes().begin(),
                       call.bytes().end());
  ++calls.head.count;
}

TEST(RecordingDamage, ThatEndsAReplayBeforeStatesAreComparedIsReported) {
  const TemporaryFile file;
  Heap heap(5);
  Recorder recorder(heap.world, file.path(), {.flush_interval = 60.0f});
  heap.run(20);
  recorder.finish();
  const TakenApart sound(file.bytes());
  const auto expect_told = [](const std::optional<Divergence>& found) {
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 5u);
    EXPECT_EQ(found->compared_at, 0u);
    EXPECT_NE(found->difference.find("the world refuses the call: World::wake"), std::string::npos)
        << found->difference;
  };
  TakenApart parts = sound;
  add_impossible_call(parts, 5, false);
  Player player(parts.put_together());
  expect_told(player.verify(0, 20, heap.workers));

  // Without the keyframe at the end, at which both are the same.
  TakenApart open = sound, other = sound;
  add_impossible_call(other, 5, true);
  for (TakenApart* recording : {&open, &other}) recording->chunks.resize(recording->chunks.size() - 2);
  Player a(open.put_together()), b(other.put_together());
  expect_told(compare(a, b, heap.workers));
  expect_told(compare(b, a, heap.workers));
}

TEST(RecordingDamage, OfAKeyframeLeavesThePlayerWhereItIs) {
  TakenApart parts(small_recording());
  int changed = 0;
  for (TakenApart::Chunk& chunk : parts.chunks) changed += change_hash(chunk, 35) ? 1 : 0;
  ASSERT_EQ(changed, 1);
  Bytes bytes = parts.put_together();
  for (const TakenApart::Chunk& chunk : TakenApart(bytes).chunks) {
    if (chunk.head.kind == ChunkKind::keyframe && chunk.head.step == 15) {
      bytes[chunk.offset + kChunkHeadBytes + 10] ^= std::byte{1};
    }
  }
  Workers workers(1);
  Player player(bytes);
  ASSERT_TRUE(player.verify(31, 40, workers));  // after which only a keyframe brings the player back
  const std::uint64_t position = player.position(), hash = player.world().hash();
  const std::size_t bodies = player.world().body_count();
  ASSERT_GT(bodies, 5u);
  EXPECT_NE(error_of_call([&] { player.seek(17, workers); }).find("checksum"), std::string::npos);
  EXPECT_EQ(player.world().body_count(), bodies);
  EXPECT_EQ(player.world().hash(), hash);
  EXPECT_EQ(player.position(), position);
  player.seek(3, workers);
  EXPECT_EQ(player.position(), 3u);
  EXPECT_FALSE(player.verify(3, 14, workers));
}

TEST(RecordingDamage, OfStateThatNoHashCoversIsFoundAtAKeyframe) {
  const TemporaryFile file;
  Heap heap(5);
  Recorder recorder(heap.world, file.path(), kOften);
  heap.world.set_user_data(heap.bodies[3], 0x1122334455667788u);
  heap.run(20);
  recorder.finish();
  TakenApart parts(file.bytes());
  for (TakenApart::Chunk& chunk : parts.chunks) {
    if (chunk.head.kind != ChunkKind::calls) continue;
    chunk.content[9] = std::byte{0};  // the number's first byte: the call is the first of all
    break;
  }
  Player player(parts.put_together());
  const std::optional<Divergence> found = player.verify(0, 20, heap.workers);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->step, 15u);
  EXPECT_EQ(found->compared_at, 15u);
  EXPECT_EQ(found->difference,
            "bodies.user_data, row " + std::to_string(heap.bodies[3].index) + ", byte 0 of 8");
}

TEST(RecordingDamage, OfACallThatNoWorldAcceptsIsAnError) {
  Workers workers(1);
  const auto error_with = [&](auto write) {
    TakenApart parts(small_recording());
    TakenApart::Chunk* calls = parts.find(ChunkKind::calls);
    ByteWriter bytes;
    write(bytes);
    const Bytes call = bytes.take();
    calls->content.insert(calls->content.begin(), call.begin(), call.end());
    ++calls->head.count;
    return error_of_playing(parts.put_together(), workers);
  };
  const auto number = [](ByteWriter& bytes, RecordedCall call) { write_value(bytes, call); };
  EXPECT_EQ(
      error_with([&](ByteWriter&) {}).find("says another number of steps or calls") != std::string::npos,
      true);
  const std::string dead = error_with([&](ByteWriter& bytes) {
    number(bytes, RecordedCall::wake);
    write_value(bytes, BodyId{5, 77});
  });
  EXPECT_NE(dead.find("the world refuses the call: World::wake: no body lives under index 5"),
            std::string::npos)
      << dead;
  EXPECT_EQ(dead.find("Player: byte "), 0u);
  const std::string endless = error_with([&](ByteWriter& bytes) {
    number(bytes, RecordedCall::create_bodies);
    bytes.put(std::uint64_t{1} << 40);
  });
  EXPECT_NE(endless.find("a list is longer than what follows"), std::string::npos) << endless;
  const std::string unknown =
      error_with([&](ByteWriter& bytes) { bytes.put(static_cast<std::uint8_t>(RecordedCall::count)); });
  EXPECT_NE(unknown.find("there is no call "), std::string::npos) << unknown;
  const std::string geometry = error_with([&](ByteWriter& bytes) {
    number(bytes, RecordedCall::set_geometry);
    write_value(bytes, ShapeId{1, 1});
    bytes.put(std::uint8_t{9});
  });
  EXPECT_NE(geometry.find("there is no geometry of kind 9"), std::string::npos) << geometry;
  const std::string hull = error_with([&](ByteWriter& bytes) {
    number(bytes, RecordedCall::set_geometry);
    write_value(bytes, ShapeId{1, 1});
    bytes.put(std::uint8_t{3});
    bytes.put(std::int32_t{1000});
    write_value(bytes, Vec3{1, 1, 1});
  });
  EXPECT_NE(hull.find("there is no hull 1000"), std::string::npos) << hull;
}

TEST(RecordingDamage, MadeOnPurposeNeverBreaksAPlayer) {
  const TakenApart sound(small_recording());
  Workers workers(1);
  std::mt19937 random(9);
  int played = 0;
  for (int i = 0; i < kTrials; ++i) {
    TakenApart parts = sound;
    Bytes& content = parts.chunks[random() % parts.chunks.size()].content;
    if (content.empty()) continue;
    for (auto flips = 1 + random() % 3; flips > 0; --flips) {
      content[random() % content.size()] ^= static_cast<std::byte>(1u << random() % 8);
    }
    const std::string error = error_of_playing(parts.put_together(), workers);
    if (error.empty()) {
      ++played;
    } else {
      ASSERT_EQ(error.find("Player: byte "), 0u) << error;
    }
  }
  EXPECT_GT(played, kTrials / 20);
  EXPECT_LT(played, kTrials - kTrials / 20);
}

TEST(RecordingDamage, OfBlocksThatWereNeverWrittenCountsAsAMissingEnd) {
  Bytes bytes = small_recording(false);
  const std::size_t whole = bytes.size();
  bytes.resize(whole + 100'000);
  Workers workers(1);
  Player player(bytes);
  EXPECT_EQ(player.info().lost_bytes, 100'000u);
  EXPECT_EQ(player.info().last_step, 40u);
  EXPECT_EQ(verified(player, workers), "");
  bytes.back() = std::byte{1};
  EXPECT_NE(error_of_playing(bytes, workers).find("byte " + std::to_string(whole) + ": no chunk begins here"),
            std::string::npos);
}

// 100 steps with a chunk of calls for every 10.
Bytes recording_of_tens() {
  const TemporaryFile file;
  Heap heap(5);
  Recorder recorder(heap.world, file.path(), {.keyframe_spacing = 10, .flush_interval = 60.0f});
  heap.run(100);
  recorder.finish();
  return file.bytes();
}

TEST(RecordingDamage, OfBlocksThatWereNeverWrittenMayBeginWithinAChunk) {
  const Bytes bytes = recording_of_tens();
  const TakenApart parts(bytes);
  const auto last = std::find_if(parts.chunks.rbegin(), parts.chunks.rend(),
                                 [](const auto& chunk) { return chunk.head.kind == ChunkKind::calls; });
  ASSERT_NE(last, parts.chunks.rend());
  ASSERT_EQ(last->head.step, 90u);
  Workers workers(1);
  const std::size_t content = last->offset + kChunkHeadBytes;
  for (const std::size_t torn :
       {last->offset, last->offset + 1, last->offset + 20, last->offset + 63, content, content + 6}) {
    for (const std::size_t zeros : {std::size_t{4096}, std::size_t{1'000'000}}) {
      Bytes left = cut(bytes, torn);
      left.resize(torn + zeros);
      Player player(left);
      EXPECT_EQ(player.info().last_step, 90u) << torn - last->offset;
      EXPECT_EQ(player.info().lost_bytes, left.size() - last->offset);
      EXPECT_FALSE(player.info().finished);
      EXPECT_EQ(verified(player, workers), "");
    }
  }
  // One that is damaged in front of others was written.
  Bytes damaged = bytes;
  damaged[last->offset + 20] ^= std::byte{1};
  EXPECT_NE(error_of_playing(damaged, workers).find("the checksum of the chunk's head is wrong"),
            std::string::npos);
}

TEST(RecordingDamage, SparesAChunkWhoseOwnBytesEndInZeros) {
  TakenApart parts(recording_of_tens());
  parts.chunks.resize(parts.chunks.size() - 2);  // the end, and the last keyframe
  ASSERT_EQ(parts.chunks.back().head.kind, ChunkKind::calls);
  // The bytes of zstd's frames that are filled up are zeros: here of many equal calls.
  TakenApart::Chunk& calls = parts.chunks.back();
  ByteWriter more;
  for (int i = 0; i < 10'000; ++i) {
    write_value(more, RecordedCall::wake);
    write_value(more, BodyId{5, 1});
  }
  calls.content.insert(calls.content.begin(), more.bytes().begin(), more.bytes().end());
  calls.head.count += 10'000;
  const Bytes bytes = parts.put_together();
  ASSERT_EQ(bytes.back(), std::byte{});
  Workers workers(1);
  for (const std::size_t zeros : {std::size_t{0}, std::size_t{4096}}) {
    Bytes longer = bytes;
    longer.resize(bytes.size() + zeros);
    Player player(longer);
    EXPECT_EQ(player.info().last_step, 100u);
    EXPECT_EQ(player.info().lost_bytes, zeros);
    EXPECT_EQ(verified(player, workers), "");
  }
}

// Reading all of it would take an hour. The file is sparse, because not all file systems have room for it.
TEST(RecordingDamage, OfATerabyteOfZerosIsRefusedSoon) {
  const TemporaryFile file;
  const Bytes bytes = small_recording(false);
  std::ofstream(file.path(), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  std::error_code no_room;
  for (int size = 40; size >= 36; --size) {
    std::filesystem::resize_file(file.path(), std::uintmax_t{1} << size, no_room);
    if (!no_room) break;
  }
  ASSERT_FALSE(no_room) << "no sparse file of 64 GiB: " << no_room.message();
  const std::string error = error_of_call([&] { Player player(file.path()); });
  EXPECT_EQ(error, "Player: byte " + std::to_string(bytes.size()) + ": no chunk begins here");
}

// The largest chunk of a kind has no fewer bytes than a share of its content, and with fewer, and all
// checksums right, it is refused before anything is unpacked.
void expect_share(Bytes bytes, ChunkKind kind, std::uint64_t share) {
  std::size_t at = 0;
  ChunkHead largest;
  for (std::size_t next = read_recording_head(bytes).bytes; next < bytes.size();) {
    const ChunkHead head = read_chunk_head(std::span(bytes).subspan(next));
    if (head.kind == kind && head.content_bytes > largest.content_bytes) largest = head, at = next;
    next += kChunkHeadBytes + static_cast<std::size_t>(head.stored_bytes);
  }
  ASSERT_GT(largest.content_bytes, 100'000u);
  EXPECT_GE(largest.stored_bytes, (largest.content_bytes - 4096) / share);
  EXPECT_LE(largest.stored_bytes, largest.content_bytes / share + 8) << "else it proves nothing";
  constexpr std::size_t kStored = 40, kHash = 56;
  const std::uint64_t fewer = largest.stored_bytes / 2;
  std::memcpy(bytes.data() + at + kStored, &fewer, sizeof fewer);
  const std::uint64_t hash = hash_of_bytes(std::span(bytes).subspan(at, kHash));
  std::memcpy(bytes.data() + at + kHash, &hash, sizeof hash);
  Workers workers(1);
  EXPECT_NE(error_of_playing(bytes, workers).find("the chunk has a wrong number of bytes"),
            std::string::npos);
}

TEST(RecordingDamage, CannotMakeAReaderTakeMoreThanAShareOfTheFile) {
  // Hulls, each of which takes many times its bytes when it is built: one of them very often.
  TakenApart parts(small_recording());
  TakenApart::Chunk& hulls = *parts.find(ChunkKind::hulls);
  Bytes one(hulls.content.begin() + 4, hulls.content.end());
  hulls.content.resize(4 + 2000 * one.size());
  for (int i = 0; i < 2000; ++i) {
    std::copy(one.begin(), one.end(),
              hulls.content.begin() + 4 + i * static_cast<std::ptrdiff_t>(one.size()));
  }
  expect_share(parts.put_together(), ChunkKind::hulls, 16);
  // Rows of bodies that are all alike, in a keyframe and in a state that is restored.
  const TemporaryFile file;
  World world;
  std::vector<BodyId> ids(50'000);
  world.create_bodies(std::vector<BodyDef>(ids.size()), ids);
  {
    const Recorder recorder(world, file.path());
    Snapshot snapshot;
    save(world, snapshot);
    restore(world, snapshot);
  }
  for (const ChunkKind kind : {ChunkKind::keyframe, ChunkKind::restored})
    expect_share(file.bytes(), kind, 32);
}

TEST(RecordingDamage, AnUnknownChunkIsSkippedIfItMayBe) {
  TakenApart parts(small_recording());
  Workers workers(1);
  TakenApart::Chunk later = parts.chunks[2];
  later.head = {.kind = static_cast<ChunkKind>(99), .flags = kChunkMayBeSkipped, .step = 5};
  parts.chunks.insert(parts.chunks.begin() + 2, later);
  Player player(parts.put_together());
  EXPECT_EQ(verified(player, workers), "");
  parts.chunks[2].head.flags = 0;
  EXPECT_NE(error_of_playing(parts.put_together(), workers).find("a later version"), std::string::npos);
}

TEST(RecordingDamage, UnfinishedRecordingsAreDistinguishedFromFinishedOnes) {
  EXPECT_TRUE(Player(small_recording(true)).info().finished);
  const Bytes open = small_recording(false);
  const Player player(open);
  EXPECT_FALSE(player.info().finished);
  EXPECT_EQ(player.info().lost_bytes, 0u);
  EXPECT_EQ(player.info().last_step, 40u);
  EXPECT_EQ(player.info().file_bytes, open.size());
}

}  // namespace
}  // namespace scree::test
