// Laws of the file that a recorder writes: no other recorder can write it, under any name, and it is no
// standard stream of the process.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <optional>
#include <set>

namespace scree::test {
namespace {

namespace fs = std::filesystem;

// Tries to record into a file that is being recorded to, which must be refused without harm to either
// recording.
void expect_refusal_without_harm(Heap& heap, Recorder& first, const std::string& other_name) {
  const std::uint64_t steps = first.steps();
  Heap other;
  EXPECT_EQ(error_of_call([&] { Recorder(other.world, other_name); }),
            other_name + ": another recorder is writing to this file");
  EXPECT_TRUE(first.is_recording());
  heap.run(5);
  other.run(5);
  EXPECT_EQ(first.steps(), steps + 5);
}

void expect_sound(const TemporaryFile& file, std::uint64_t steps) {
  Player player(file.path());
  Workers workers(1);
  EXPECT_TRUE(player.info().finished);
  EXPECT_EQ(player.info().last_step, steps);
  EXPECT_EQ(verified(player, workers), "");
}

TEST(RecordingOutput, BelongsToOneRecorderUnderEveryNameOfTheFile) {
  const TemporaryFile file, hard_link, symbolic_link;
  Heap heap;
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(5);
  fs::create_hard_link(file.path(), hard_link.path());
  fs::create_symlink(file.path(), symbolic_link.path());
  expect_refusal_without_harm(heap, recorder, file.path());
  expect_refusal_without_harm(heap, recorder, hard_link.path());
  expect_refusal_without_harm(heap, recorder, symbolic_link.path());
  recorder.finish();
  expect_sound(file, 20);
}

TEST(RecordingOutput, BelongsToOneRecorderAmongAllProcesses) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(5);
  // This is the only way to pass the name to the process.
  setenv("SCREE_RECORDED_FILE", file.path().c_str(), 0);
  const auto record = [] {
    World world;
    const std::string error = error_of_call([&] { Recorder(world, std::getenv("SCREE_RECORDED_FILE")); });
    _exit(error.find("another recorder is writing to this file") != std::string::npos ? 0 : 1);
  };
  EXPECT_EXIT(record(), testing::ExitedWithCode(0), "");
  unsetenv("SCREE_RECORDED_FILE");
  heap.run(5);
  recorder.finish();
  expect_sound(file, 10);
}

TEST(RecordingOutput, IsFreeAgainOnceTheRecordingHasEnded) {
  const TemporaryFile file;
  const auto record_again = [&file] {
    Heap again;
    Recorder recorder(again.world, file.path());
    again.run(2);
    recorder.finish();
    expect_sound(file, 2);
  };
  Heap heap;
  Recorder finished(heap.world, file.path());
  heap.run(3);
  finished.finish();
  record_again();
  auto mortal = std::make_unique<Heap>();
  const Recorder widowed(mortal->world, file.path());
  mortal.reset();
  record_again();
}

// A host may have forked while it recorded, and its child may live on.
TEST(RecordingOutput, IsFreeAgainThoughAChildOfTheProcessHasTheFileOpen) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path());
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    pause();
    _exit(0);
  }
  recorder.finish();
  EXPECT_EQ(error_of_call([&] { Recorder(heap.world, file.path()); }), "");
  ::kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST(RecordingOutput, IsReadByPlayersWhileItIsWritten) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path(), kOften);
  std::uint64_t played = 0;
  for (int i = 0; i < 100 && played < 10; ++i) {
    heap.run(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    Player player(file.path());
    EXPECT_FALSE(player.info().finished);
    EXPECT_EQ(verified(player, heap.workers), "");
    played = player.position();
  }
  EXPECT_GE(played, 10u);
  recorder.finish();
  expect_sound(file, recorder.steps());
}

TEST(RecordingOutput, ThatIsADeviceMayBeShared) {
  Heap heap, other;
  Recorder first(heap.world, "/dev/null"), second(other.world, "/dev/null");
  heap.run(2);
  other.run(2);
  EXPECT_EQ(error_of_call([&] { first.finish(); }), "");
  EXPECT_EQ(error_of_call([&] { second.finish(); }), "");
}

TEST(RecordingOutput, KeepsNothingOfALongerFileThatWasThereBefore) {
  const TemporaryFile file;
  std::ofstream(file.path(), std::ios::binary) << std::string(1 << 20, 'x');
  Heap heap;
  Recorder recorder(heap.world, file.path());
  heap.run(3);
  recorder.finish();
  expect_sound(file, 3);
}

TEST(RecordingOutput, IsUnchangedByARecorderThatIsRefused) {
  const TemporaryFile file;
  std::ofstream(file.path(), std::ios::binary) << "an old recording";
  Heap heap;
  EXPECT_NE(error_of_call([&] { Recorder(heap.world, file.path(), {.keyframe_spacing = 0}); }), "");
  World gone = std::move(heap.world);
  EXPECT_NE(error_of_call([&] { Recorder(heap.world, file.path()); }), "");
  EXPECT_EQ(file.bytes().size(), 16u);
}

// A host prints to descriptors 0 to 2, whether these are open streams or have been closed.
TEST(RecordingOutput, IsNoStandardStreamOfAProcessThatHasClosedThem) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto record = [] {
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
      const TemporaryFile file;
      Heap heap;
      close(stream);
      Recorder recorder(heap.world, file.path());
      heap.run(2);
      if (fcntl(stream, F_GETFD) >= 0) _exit(1);
      recorder.finish();
      if (!Player(file.path()).info().finished) _exit(2);
    }
    _exit(0);
  };
  EXPECT_EXIT(record(), testing::ExitedWithCode(0), "");
}

TEST(RecordingOutput, IsNotOpenInProgramsThatTheProcessRuns) {
  const TemporaryFile file;
  World world;
  const Recorder recorder(world, file.path());
  std::set<int> found;
  for (int descriptor = 0; descriptor < 1024; ++descriptor) {
    std::error_code none;
    const fs::path link = fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor), none);
    if (link != file.path()) continue;
    found.insert(descriptor);
    EXPECT_NE(fcntl(descriptor, F_GETFD) & FD_CLOEXEC, 0);
  }
  EXPECT_EQ(found.size(), 1u);
}

}  // namespace
}  // namespace scree::test
