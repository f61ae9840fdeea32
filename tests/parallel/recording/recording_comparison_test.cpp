// Comparing two recordings.
#include <core/state/recording_format/recorded_calls.h>
#include <core/state/recording_format/value_bytes.h>
#include <tests/parallel/recording/recording_fixture.h>

namespace scree::test {
namespace {

TEST(RecordingComparison, FindsWhereTwoRecordingsDiverge) {
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

TEST(RecordingComparison, FindsDifferencesThatNoStepHashShows) {
  // Worlds that move alike: one of them would fall asleep later, has other user data, or has more friction
  // with a body that it never meets.
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
  EXPECT_EQ(sleepless->difference.find("world.settings"), 0u) << sleepless->difference;

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

TEST(RecordingComparison, AcceptsTheStartOfALaterRecording) {
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
  EXPECT_EQ(keyframe_steps(a), (std::vector<std::uint64_t>{0, 15, 30, 45}));
  EXPECT_EQ(keyframe_steps(b), (std::vector<std::uint64_t>{15, 30, 45}));
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

TEST(RecordingComparison, NamesWhatKeyframesDifferIn) {
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
