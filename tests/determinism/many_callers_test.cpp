// Laws of concurrent worlds: worlds that are stepped at the same time give the results of worlds stepped
// alone.
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tests/determinism/many_threads.h>
#include <tests/determinism/replay.h>

#include <atomic>
#include <thread>
#include <vector>

namespace scree::determinism {
namespace {

constexpr int kStepsOfCallers = 90;
constexpr int kWorlds = 6;

// Worlds of different sizes, so that their steps interleave in varying ways.
SceneCase case_of(int index) {
  return {"pile", {{"bodies", 60 + 90 * index}, {"seed", 1 + index}}, kStepsOfCallers};
}

std::uint64_t hash_alone(int index) { return play(case_of(index), {kReference}).back(); }

class ManyCallers : public ManyThreads {
 protected:
  static void SetUpTestSuite() {
    expected_.clear();
    for (int i = 0; i < kWorlds; ++i) expected_.push_back(hash_alone(i));
  }
  static void play_all(Playback& playback, Workers& workers) {
    for (int i = 0; i < kStepsOfCallers; ++i) playback.advance(workers);
  }
  static std::vector<Playback> all_worlds() {
    std::vector<Playback> playbacks;
    for (int i = 0; i < kWorlds; ++i) playbacks.emplace_back(case_of(i));
    return playbacks;
  }
  // Calls work(playback) for each playback in the caller's tasks. `handed_over` also synchronizes a playback
  // that moves from thread to thread: ThreadSanitizer does not see TBB's own synchronization, and its
  // suppressions recognize a report by the task's stack, which is lost for old accesses.
  template <class Work>
  void play_in_tasks(std::vector<Playback>& playbacks, Work&& work) {
    handed_over_.fetch_add(1, std::memory_order_release);
    tbb::parallel_for(std::size_t{0}, playbacks.size(), [&](std::size_t i) {
      handed_over_.load(std::memory_order_acquire);
      work(playbacks[i]);
      handed_over_.fetch_add(1, std::memory_order_release);
    });
    handed_over_.load(std::memory_order_acquire);
  }
  static void expect_the_same(const std::vector<Playback>& playbacks) {
    for (std::size_t i = 0; i < playbacks.size(); ++i) EXPECT_EQ(playbacks[i].hash(), expected_[i]) << i;
  }

 private:
  static inline std::vector<std::uint64_t> expected_;
  std::atomic<int> handed_over_{0};
};

TEST_F(ManyCallers, ThreadsThatShareWorkersDoNotDisturbEachOther) {
  std::vector<Playback> playbacks = all_worlds();
  Workers workers(2);
  std::vector<std::thread> callers;
  for (Playback& playback : playbacks) callers.emplace_back([&] { play_all(playback, workers); });
  for (std::thread& caller : callers) caller.join();
  expect_the_same(playbacks);
}

TEST_F(ManyCallers, StepsInsideACallersTasksGiveTheSameResults) {
  std::vector<Playback> playbacks = all_worlds();
  Workers workers(2);
  play_in_tasks(playbacks, [&](Playback& playback) { play_all(playback, workers); });
  expect_the_same(playbacks);
}

TEST_F(ManyCallers, StepsThatMoveFromTaskToTaskGiveTheSameResults) {
  std::vector<Playback> playbacks = all_worlds();
  Workers workers(4);
  for (int step = 0; step < kStepsOfCallers; ++step) {
    play_in_tasks(playbacks, [&](Playback& playback) { playback.advance(workers); });
  }
  expect_the_same(playbacks);
}

TEST_F(ManyCallers, OneThreadMayStepManyWorldsInTurn) {
  std::vector<Playback> playbacks = all_worlds();
  Workers workers(3);
  for (int step = 0; step < kStepsOfCallers; ++step) {
    for (Playback& playback : playbacks) playback.advance(workers);
  }
  expect_the_same(playbacks);
}

TEST_F(ManyCallers, WorldsOfOneListGiveTheSameResults) {
  std::vector<Playback> alone = all_worlds();
  std::vector<scenes::Scene> scenes;
  Workers single(1);
  for (int i = 0; i < kWorlds; ++i) {
    play_all(alone[static_cast<std::size_t>(i)], single);
    scenes.push_back(scenes::build("pile", case_of(i).parameters).front());
  }
  for (const int threads : {1, 2, 4, kWorlds + 2}) {
    Playback list(scenes, kStepsOfCallers);
    Workers workers(threads);
    play_all(list, workers);
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(list.worlds()[i].hash(), alone[i].worlds()[0].hash()) << threads << " threads, world " << i;
    }
  }
}

TEST_F(ManyCallers, AnArenaOfOneSlotIsEnough) {
  std::vector<Playback> playbacks = all_worlds();
  Workers workers(4);
  tbb::task_arena narrow(1);
  narrow.execute([&] {
    for (Playback& playback : playbacks) play_all(playback, workers);
  });
  expect_the_same(playbacks);
}

}  // namespace
}  // namespace scree::determinism
