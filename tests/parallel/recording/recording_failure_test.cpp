// Laws of recordings that could not be written to their end: files that accept no more data, memory that runs
// out, and processes that die.
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <fcntl.h>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <set>
#include <thread>

#include <tests/parallel/allocations.h>

namespace scree::test {
namespace {

// --- files that cannot be written ---

TEST(RecordingFailure, OfADiskThatIsFullAtTheBeginningIsReportedAtOnce) {
  Heap heap;
  const std::string error = error_of_call([&] { Recorder(heap.world, "/dev/full"); });
  EXPECT_NE(error.find("/dev/full: cannot be written: No space left on device"), std::string::npos) << error;
  heap.run(3);
}

TEST(RecordingFailure, OfADiskThatFillsUpEndsTheRecordingAndLeavesTheWorldAlone) {
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

// The other tests run in processes of their own, which a signal would end.

TEST(RecordingFailure, OfAFileWithASizeLimitOfZeroIsAnError) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const TemporaryFile file;
  const auto record = [&file] {
    const rlimit nothing{0, 0};
    if (setrlimit(RLIMIT_FSIZE, &nothing) != 0) _exit(1);
    World world;
    const std::string error = error_of_call([&] { Recorder(world, file.path()); });
    _exit(error.find(": cannot be written: File too large") != std::string::npos ? 0 : 2);
  };
  EXPECT_EXIT(record(), testing::ExitedWithCode(0), "");
}

TEST(RecordingFailure, OfAPipeWithoutReadersIsAnError) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto record = [] {
    World world;
    for (int i = 0; i < 50; ++i) {
      const TemporaryFile pipe;
      if (mkfifo(pipe.path().c_str(), 0600) != 0) _exit(1);
      std::thread reader([&pipe] { close(open(pipe.path().c_str(), O_RDONLY)); });
      const std::string error = error_of_call([&] { Recorder(world, pipe.path()); });
      reader.join();
      // The reader may have gone after all that was written.
      if (!error.empty() && error.find(": cannot be written: Broken pipe") == std::string::npos) _exit(2);
    }
    _exit(0);
  };
  EXPECT_EXIT(record(), testing::ExitedWithCode(0), "");
}

// The signals that a thread of this process blocks, as a mask.
std::uint64_t blocked_signals(const std::filesystem::path& task) {
  std::ifstream status(task / "status");
  for (std::string word; status >> word;) {
    if (word == "SigBlk:" && status >> word) return std::stoull(word, nullptr, 16);
  }
  return 0;
}

std::set<std::filesystem::path> tasks() {
  std::set<std::filesystem::path> result;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) result.insert(task.path());
  return result;
}

TEST(RecordingFailure, TheWriterThreadLeavesCrashSignalsToTheirHandlers) {
  std::thread([] {}).join();  // with the first one, a sanitizer may start threads of its own
  const std::set<std::filesystem::path> before = tasks();
  const TemporaryFile file;
  World world;
  const Recorder recorder(world, file.path());
  const auto bit = [](int signal) { return std::uint64_t{1} << (signal - 1); };
  int writers = 0;
  for (const std::filesystem::path& task : tasks()) {
    if (before.contains(task)) continue;
    ++writers;
    const std::uint64_t blocked = blocked_signals(task);
    EXPECT_NE(blocked & bit(SIGXFSZ), 0u);
    EXPECT_NE(blocked & bit(SIGPIPE), 0u);
    EXPECT_NE(blocked & bit(SIGTERM), 0u);
    EXPECT_EQ(blocked & (bit(SIGSEGV) | bit(SIGBUS) | bit(SIGFPE) | bit(SIGILL)), 0u);
  }
  EXPECT_EQ(writers, 1);
}

// --- memory that runs out ---

constexpr const char* kOutOfMemory = "Recorder: memory ran out";

// Steps until the recording has ended, and beyond.
void expect_world_unharmed(Heap& heap, Recorder& recorder, const TemporaryFile& file) {
  EXPECT_FALSE(recorder.is_recording());
  EXPECT_EQ(recorder.error(), "memory ran out");
  try {
    recorder.finish();
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), kOutOfMemory);
    EXPECT_EQ(error.code(), ErrorCode::out_of_memory);
  }
  heap.run(10);
  Heap twin;
  twin.run(static_cast<int>(heap.world.stats().step));
  EXPECT_EQ(heap.world.hash(), twin.world.hash());
  Player player(file.path());
  EXPECT_FALSE(player.info().finished);
  EXPECT_EQ(verified(player, heap.workers), "");
}

TEST(RecordingFailure, OfTheWritersMemoryEndsTheRecordingAndLeavesTheWorldAlone) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(10);
  {
    const FailingAllocations failing(FailingAllocations::Of::others);
    for (int i = 0; i < 400 && recorder.is_recording(); ++i) {
      heap.run(1);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  expect_world_unharmed(heap, recorder, file);
}

TEST(RecordingFailure, OfTheWritersMemoryIsReportedAtOnceAtTheBeginning) {
  const TemporaryFile file;
  Heap heap;
  const std::string error = error_of_call([&] {
    const FailingAllocations failing(FailingAllocations::Of::others);
    Recorder(heap.world, file.path());
  });
  EXPECT_EQ(error, "memory ran out");
  heap.run(3);
  EXPECT_NO_THROW(Recorder(heap.world, file.path()));
}

TEST(RecordingFailure, OfTheCallersMemoryEndsTheRecordingAndLeavesTheWorldAlone) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path(), {.flush_interval = 60.0f});
  heap.run(10);
  {
    const FailingAllocations failing(FailingAllocations::Of::this_thread);
    for (int i = 0; i < 100'000 && recorder.is_recording(); ++i) heap.world.wake(heap.bodies[5]);
  }
  expect_world_unharmed(heap, recorder, file);
}

// A step that has computed its hash, and then has no memory to list the bodies to quarantine.
TEST(RecordingFailure, OfAStepLeavesNoHashToTheNextRecording) {
  const TemporaryFile file;
  World world(WorldSettings{.gravity = {}});
  Workers workers(1);
  BodyId body;
  for (int i = 0; i < 600; ++i) {
    body =
        world.create_body({.position = {3.0f * static_cast<float>(i), 0, 0}, .linear_velocity = {1, 0, 0}});
    world.add_shape(body, Sphere{});
  }
  for (int i = 0; i < 40; ++i) step(world, kDt, workers);
  Snapshot before;
  save(world, before);
  Recorder first(world, file.path());
  world.set_mass_properties(body, {.mass = 1e16f});
  world.add_force(body, {1e30f, 0, 0});
  world.set_mass_properties(body, {.mass = 1e-7f});
  {
    const FailingAllocations failing(FailingAllocations::Of::this_thread);
    EXPECT_THROW(step(world, kDt, workers), std::bad_alloc);
  }
  EXPECT_FALSE(first.is_recording());
  restore(world, before);
  Recorder second(world, file.path());
  step(world, 0.0f, workers);  // moves no body, and does not compute its hash in parallel
  second.finish();
  Player player(file.path());
  EXPECT_EQ(verified(player, workers), "");
}

// Such a world cannot continue, and its recording must not look complete.
TEST(RecordingFailure, OfAStepIsReportedAndLeavesAnUnfinishedRecording) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path());
  heap.run(20);
  for (int i = 0; i < 3000; ++i) heap.add({.position = {3.0f * static_cast<float>(i), 9, 0}}, Sphere{});
  {
    const FailingAllocations failing(FailingAllocations::Of::this_thread);
    EXPECT_THROW(step(heap.world, kDt, heap.workers), std::bad_alloc);
  }
  EXPECT_FALSE(recorder.is_recording());
  EXPECT_EQ(recorder.error(), "memory ran out");
  EXPECT_EQ(error_of_call([&] { recorder.finish(); }), "Recorder: memory ran out");
  Player player(file.path());
  EXPECT_FALSE(player.info().finished);
  EXPECT_EQ(player.info().last_step, 20u);
  EXPECT_EQ(verified(player, heap.workers), "");
}

TEST(RecordingFailure, OfTheRecordingProgramLeavesAnUnfinishedRecording) {
  const TemporaryFile file;
  Heap heap;
  try {
    Recorder recorder(heap.world, file.path(), {.flush_interval = 60.0f});
    heap.run(20);
    throw std::bad_alloc();
  } catch (const std::bad_alloc&) {
  }
  heap.run(1);
  Player player(file.path());
  EXPECT_FALSE(player.info().finished);
  EXPECT_EQ(player.info().last_step, 20u);
  EXPECT_EQ(verified(player, heap.workers), "");
}

// --- processes that die ---

TEST(RecordingFailure, OfAKilledProcessLosesLessThanASecond) {
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
  // Output of the child, with its time.
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

}  // namespace
}  // namespace scree::test
