// Laws of recordings that were cut off, damaged, changed on purpose, or could not be written.
#include <core/recorded_calls.h>
#include <core/value_bytes.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tests/parallel/recording_fixture.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <thread>

namespace scree::test {
namespace {

constexpr RecorderOptions kOften{.keyframe_spacing = 15, .flush_interval = 0.01f};
#ifdef SCREE_SANITIZED
constexpr int kTrials = 80;
#else
constexpr int kTrials = 400;
#endif

Bytes cut(const Bytes& bytes, std::size_t length) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)};
}

// Small, and of many chunks: the file is made here, without a clock.
Bytes small_recording(bool finished = true) {
  const TemporaryFile file;
  Heap heap(5);
  Recorder recorder(heap.world, file.path(), kOften);
  for (int i = 0; i < 40; ++i) {
    if (i % 8 == 3) heap.add({.position = {0, 3, 0.1f * static_cast<float>(i)}}, ConvexHull{wedge()});
    heap.world.add_force(heap.bodies[3], {0.5f, 0.0f, static_cast<float>(i)});
    heap.run(1);
    if (i % 10 == 9) std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  recorder.finish();
  const Bytes bytes = file.bytes();
  return finished ? bytes : cut(bytes, bytes.size() - kChunkHeadBytes);
}

// Plays all of it: the error if there is one.
std::string error_of_playing(const Bytes& bytes, Workers& workers) {
  return error_of_call([&] {
    Player player(bytes);
    player.verify(player.info().first_step, player.info().last_step, workers);
  });
}

TEST(RecordingDamage, OfAnEndThatIsMissingLeavesTheWholeSteps) {
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
    // What should be left: the chunks that end by then.
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
  wrong[8] = std::byte{9};
  EXPECT_EQ(error_of_playing(wrong, workers),
            "Player: byte 8: the recording has version 9, this is version 1");
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
  // What was recorded after the next keyframe agrees, whatever has been played before.
  EXPECT_FALSE(player.verify(30, 40, heap.workers));
  ASSERT_TRUE(player.verify(0, 25, heap.workers));
  player.seek(31, heap.workers);
  EXPECT_FALSE(player.verify(player.position(), 40, heap.workers));
}

TEST(RecordingDamage, OfWhatNoHashCoversIsFoundAtAKeyframe) {
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

TEST(RecordingDamage, OfACallThatNoWorldWouldTakeIsAnError) {
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

TEST(RecordingDamage, OfBlocksThatWereNeverWrittenIsAnEndThatIsMissing) {
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

TEST(RecordingDamage, CanNotMakeAReaderTakeMoreThanAShareOfTheFile) {
  // Hulls, each of which takes many times its bytes when it is built: one of them very often.
  TakenApart parts(small_recording());
  TakenApart::Chunk& hulls = *parts.find(ChunkKind::hulls);
  Bytes one(hulls.content.begin() + 4, hulls.content.end());
  hulls.content.resize(4 + 2000 * one.size());
  for (int i = 0; i < 2000; ++i) {
    std::copy(one.begin(), one.end(),
              hulls.content.begin() + 4 + i * static_cast<std::ptrdiff_t>(one.size()));
  }
  Bytes bytes = parts.put_together();
  std::size_t at = parts.head.size();
  while (read_chunk_head(std::span(bytes).subspan(at)).kind != ChunkKind::hulls) {
    at += kChunkHeadBytes +
          static_cast<std::size_t>(read_chunk_head(std::span(bytes).subspan(at)).stored_bytes);
  }
  const ChunkHead packed = read_chunk_head(std::span(bytes).subspan(at));
  EXPECT_GE(packed.stored_bytes, (packed.content_bytes - 4096) / 16);
  // With fewer stored bytes and all checksums right it is refused before anything is unpacked.
  constexpr std::size_t kStored = 40, kHash = 56;
  const std::uint64_t fewer = packed.stored_bytes / 2;
  std::memcpy(bytes.data() + at + kStored, &fewer, sizeof fewer);
  const std::uint64_t hash = hash_of_bytes(std::span(bytes).subspan(at, kHash));
  std::memcpy(bytes.data() + at + kHash, &hash, sizeof hash);
  Workers workers(1);
  EXPECT_NE(error_of_playing(bytes, workers).find("the chunk has a wrong number of bytes"),
            std::string::npos);
}

TEST(RecordingDamage, AnUnknownChunkIsSkippedWhereItMayBe) {
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

TEST(RecordingDamage, TellsAnUnfinishedRecordingFromAFinishedOne) {
  EXPECT_TRUE(Player(small_recording(true)).info().finished);
  const Bytes open = small_recording(false);
  const Player player(open);
  EXPECT_FALSE(player.info().finished);
  EXPECT_EQ(player.info().lost_bytes, 0u);
  EXPECT_EQ(player.info().last_step, 40u);
  EXPECT_EQ(player.info().file_bytes, open.size());
}

// --- files that can not be written ---

TEST(RecordingDamage, OfAFullDiskIsToldAtOnceWhereItIsFullAtTheBeginning) {
  Heap heap;
  const std::string error = error_of_call([&] { Recorder(heap.world, "/dev/full"); });
  EXPECT_NE(error.find("/dev/full: can not be written: No space left on device"), std::string::npos) << error;
  heap.run(3);
}

TEST(RecordingDamage, OfADiskThatFillsUpEndsTheRecordingAndLeavesTheWorldAlone) {
  const TemporaryFile file;
  Heap heap, twin;
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  rlimit small = limit;
  small.rlim_cur = 40'000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  Recorder recorder(heap.world, file.path(), kOften);
  for (int i = 0; i < 400 && recorder.is_recording(); ++i) {
    heap.run(1);
    twin.run(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_FALSE(recorder.is_recording());
  EXPECT_NE(recorder.error().find("File too large"), std::string::npos) << recorder.error();
  EXPECT_NE(error_of_call([&] { recorder.finish(); }).find(file.path()), std::string::npos);
  EXPECT_EQ(error_of_call([&] { recorder.finish(); }), "") << "told once";
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  heap.run(10);
  twin.run(10);
  EXPECT_EQ(heap.world.hash(), twin.world.hash());
  Player player(file.path());
  EXPECT_FALSE(player.info().finished);
  EXPECT_GT(player.info().last_step, 0u);
  EXPECT_EQ(verified(player, heap.workers), "");
}

// --- processes that die ---

TEST(RecordingDamage, OfAKilledProcessIsLessThanASecond) {
  const TemporaryFile file;
  int out[2];
  ASSERT_EQ(pipe(out), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    close(out[0]);
    execl(SCREE_RECORDING_CHILD, SCREE_RECORDING_CHILD, file.path().c_str(), static_cast<char*>(nullptr));
    _exit(1);
  }
  close(out[1]);
  // What the child tells, with the time at which it did.
  using Clock = std::chrono::steady_clock;
  std::vector<std::pair<Clock::time_point, std::uint64_t>> told;
  std::FILE* const lines = fdopen(out[0], "r");
  char line[256];
  const auto start = Clock::now();
  while (std::fgets(line, sizeof line, lines) != nullptr) {
    char* end = line;
    const std::uint64_t steps = std::strtoull(line, &end, 10);
    if (end != line && *end == '\n') told.push_back({Clock::now(), steps});
    if (!told.empty() && Clock::now() - told.front().first > std::chrono::milliseconds(2500)) break;
    if (Clock::now() - start > std::chrono::seconds(60)) break;
  }
  const auto killed = Clock::now();
  ::kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  std::fclose(lines);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_FALSE(told.empty());
  std::uint64_t steps_before = 0;  // a second before the end
  for (const auto& [time, steps] : told) {
    if (killed - time > std::chrono::seconds(1)) steps_before = steps;
  }
  ASSERT_GT(steps_before, 10u);
  Player player(file.path());
  Workers workers(1);
  EXPECT_FALSE(player.info().finished);
  EXPECT_GE(player.info().last_step, steps_before);
  EXPECT_EQ(verified(player, workers), "");
  EXPECT_EQ(player.position(), player.info().last_step);
}

// --- two recordings ---

TEST(RecordingComparison, FindsWhereTwoPart) {
  const TemporaryFile first, second, third, early;
  const auto record = [](const TemporaryFile& file, int kick_at, int begin, int end) {
    Heap heap(6);
    heap.run(begin);
    Recorder recorder(heap.world, file.path(), kOften);
    for (int i = begin; i < end; ++i) {
      if (i == kick_at) heap.world.add_impulse(heap.bodies[4], {0, 1, 0});
      heap.run(1);
    }
    recorder.finish();
  };
  record(first, 22, 0, 40);
  record(second, 22, 8, 37);
  record(third, 27, 3, 50);
  record(early, -1, 0, 3);
  Workers workers(1);
  Player a(first.path()), b(second.path()), c(third.path()), d(early.path());
  EXPECT_FALSE(compare(a, b, workers));
  const std::optional<Divergence> found = compare(a, c, workers);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->step, 23u);
  EXPECT_EQ(found->compared_at, 23u);
  EXPECT_NE(found->expected_hash, found->actual_hash);
  EXPECT_EQ(found->difference.find("body "), 0u) << found->difference;
  EXPECT_EQ(error_of_call([&] { compare(d, b, workers); }), "compare: the recordings have no step in common");
}

TEST(RecordingComparison, FindsWhatNoStepShows) {
  // Worlds that move alike: one of them would fall asleep later, has another number for its user, or rubs
  // harder against what it never meets.
  const auto record = [](const auto& change) {
    const TemporaryFile file;
    Heap heap(4);
    heap.add({.position = {8, 5, 0}}, Sphere{0.2f});
    Recorder recorder(heap.world, file.path(), kOften);
    for (int i = 0; i < 40; ++i) {
      change(heap, i);
      heap.run(1);
    }
    recorder.finish();
    return file.bytes();
  };
  const auto nothing = [](Heap&, int) {};
  Workers workers(1);
  const auto found = [&](const Bytes& left, const Bytes& right) {
    Player a(left), b(right);
    return compare(a, b, workers);
  };
  const Bytes plain = record(nothing);
  EXPECT_FALSE(found(plain, record(nothing)));

  const std::optional<Divergence> sleepless = found(plain, record([](Heap& heap, int step) {
                                                      WorldSettings settings = heap.world.settings();
                                                      settings.sleep_time = 2.0f;
                                                      if (step == 3) heap.world.set_settings(settings);
                                                    }));
  ASSERT_TRUE(sleepless);
  EXPECT_EQ(sleepless->step, 15u);
  EXPECT_EQ(sleepless->compared_at, 15u);
  EXPECT_NE(sleepless->expected_hash, sleepless->actual_hash);
  EXPECT_EQ(sleepless->difference.find("the settings"), 0u) << sleepless->difference;

  const std::optional<Divergence> named = found(plain, record([](Heap& heap, int step) {
                                                  if (step == 15) heap.world.set_user_data(heap.bodies[2], 7);
                                                }));
  ASSERT_TRUE(named);
  EXPECT_EQ(named->step, 30u) << "calls after the keyframe's step come with the next one";
  EXPECT_EQ(named->difference,
            "bodies.user_data, row " + std::to_string(Heap(4).bodies[2].index) + ", byte 0 of 8");

  const std::optional<Divergence> rough =
      found(plain, record([](Heap& heap, int step) {
              if (step == 0) heap.world.set_material(heap.shapes.back(), {.friction = 0.9f});
            }));
  ASSERT_TRUE(rough);
  EXPECT_EQ(rough->step, 15u);
  EXPECT_EQ(rough->difference.find("shapes.material, row "), 0u) << rough->difference;
}

TEST(RecordingComparison, TakesTheBeginningOfALaterRecordingAsItIs) {
  // Its first state holds a call that the other recording makes after the keyframe of that step.
  const TemporaryFile early, late;
  for (const TemporaryFile* file : {&early, &late}) {
    Heap heap(4);
    std::optional<Recorder> recorder;
    if (file == &early) recorder.emplace(heap.world, file->path(), kOften);
    heap.run(15);
    heap.world.set_user_data(heap.bodies[2], 7);
    if (file == &late) recorder.emplace(heap.world, file->path(), kOften);
    heap.run(30);
    recorder->finish();
  }
  Workers workers(1);
  Player a(early.path()), b(late.path());
  EXPECT_EQ(a.info().keyframe_steps, (std::vector<std::uint64_t>{0, 15, 30, 45}));
  EXPECT_EQ(b.info().keyframe_steps, (std::vector<std::uint64_t>{15, 30, 45}));
  EXPECT_FALSE(compare(a, b, workers));
}

TEST(RecordingComparison, LooksAtKeyframesWhereReplaysAgree) {
  const Bytes bytes = small_recording();
  TakenApart parts(bytes);
  int changed = 0;
  for (TakenApart::Chunk& chunk : parts.chunks) changed += change_hash(chunk, 17) ? 1 : 0;
  ASSERT_EQ(changed, 1);
  Workers workers(1);
  Player a(bytes), b(parts.put_together());
  const std::optional<Divergence> found = compare(a, b, workers);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->step, 17u);
  EXPECT_EQ(found->compared_at, 30u);
  EXPECT_EQ(found->difference, "") << "the keyframes are the same";
}

TEST(RecordingComparison, TellsWhatKeyframesDifferIn) {
  // The calls of one run with the hashes and keyframes of another.
  const auto record = [](bool kicked) {
    const TemporaryFile file;
    Heap heap(5);
    Recorder recorder(heap.world, file.path(), kOften);
    heap.run(20);
    if (kicked) heap.world.set_linear_velocity(heap.bodies[6], {1, 0, 0});
    heap.run(20);
    recorder.finish();
    return file.bytes();
  };
  const Bytes bytes = record(false);
  TakenApart parts(bytes), kicked(record(true));
  const auto keyframe_at = [](TakenApart& recording, std::uint64_t step) -> TakenApart::Chunk* {
    for (TakenApart::Chunk& chunk : recording.chunks) {
      if (chunk.head.kind == ChunkKind::keyframe && chunk.head.step == step) return &chunk;
    }
    return nullptr;
  };
  for (TakenApart::Chunk& chunk : parts.chunks) {
    const std::uint64_t end = chunk.head.step + chunk.head.steps;
    if (chunk.head.kind == ChunkKind::calls && end > 20 && end <= 30) chunk.content.back() ^= std::byte{1};
  }
  ASSERT_TRUE(keyframe_at(parts, 30) != nullptr && keyframe_at(kicked, 30) != nullptr);
  keyframe_at(parts, 30)->content = keyframe_at(kicked, 30)->content;
  Workers workers(1);
  Player a(bytes), b(parts.put_together());
  const std::optional<Divergence> found = compare(a, b, workers);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->compared_at, 30u);
  EXPECT_EQ(found->difference.find("body "), 0u) << found->difference;
}

}  // namespace
}  // namespace scree::test
