// Laws of the crew: it runs every chunk once, does not wait for absent helpers, and leaves other tasks alone.
#include <gtest/gtest.h>
#include <parallel/crew/crew.h>
#include <parallel/crew/helper_arena.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace scree {
namespace {

// TBB lends one thread per core unless told otherwise; these laws must hold with more threads than cores.
class CrewTest : public ::testing::Test {
 private:
  tbb::global_control more_threads_{tbb::global_control::max_allowed_parallelism, 8};
};

// A step-like sequence of dependent stages: each value depends on all of the stage before.
std::vector<double> run_stages(Workers& workers, int stages, int count, int chunk_size) {
  std::vector<double> values(static_cast<std::size_t>(count), 1.0), next(values.size());
  Crew crew(workers);
  for (int stage = 0; stage < stages; ++stage) {
    crew.run_ranges(count, chunk_size, [&](int begin, int end, int) {
      for (int i = begin; i < end; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const std::size_t mirrored = values.size() - 1 - at;
        next[at] = values[at] / 3 + values[mirrored] / 7 + stage + i;
      }
    });
    std::swap(values, next);
  }
  return values;
}

// Keeps a chunk busy for a moment.
void spin(int loops) {
  static std::atomic<int> sink;
  for (int i = 0; i < loops; ++i) sink.store(i, std::memory_order_relaxed);
}

// Holds the calling thread in a chunk until some helper has claimed one, or a second has passed.
bool helper_arrives(Crew& crew) {
  std::atomic<bool> arrived{false};
  for (int tries = 0; tries < 1000 && !arrived; ++tries) {
    crew.run(2 * crew.threads(), [&](int, int worker) {
      if (worker != 0) arrived = true;
      if (worker == 0 && !arrived) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
  }
  return arrived;
}

TEST_F(CrewTest, RunsEveryChunkExactlyOnce) {
  for (const int threads : {1, 2, 3, 8}) {
    Workers workers(threads);
    for (const int chunks : {0, 1, 2, 3, 7, 8, 9, 1000}) {
      std::vector<std::atomic<int>> runs(static_cast<std::size_t>(chunks));
      Crew crew(workers);
      for (int stage = 0; stage < 20; ++stage) {
        crew.run(chunks, [&](int chunk, int) { ++runs[static_cast<std::size_t>(chunk)]; });
      }
      for (const std::atomic<int>& count : runs) EXPECT_EQ(count, 20);
      EXPECT_EQ(crew.stages(), chunks == 0 ? 0 : 20);
    }
  }
}

TEST_F(CrewTest, RangesCoverTheWholeOnceAndHaveTheRequestedSize) {
  Workers workers(3);
  Crew crew(workers);
  std::vector<std::atomic<int>> touched(1000);
  crew.run_ranges(1000, 64, [&](int begin, int end, int) {
    EXPECT_EQ(begin % 64, 0);
    EXPECT_EQ(end, std::min(begin + 64, 1000));
    for (int i = begin; i < end; ++i) ++touched[static_cast<std::size_t>(i)];
  });
  for (const std::atomic<int>& count : touched) EXPECT_EQ(count, 1);
}

TEST_F(CrewTest, AStageSeesAllThatTheStageBeforeWrote) {
  Workers serial(1);
  const std::vector<double> expected = run_stages(serial, 200, 1000, 10);
  for (const int threads : {2, 3, 4, 8}) {
    Workers workers(threads);
    EXPECT_EQ(run_stages(workers, 200, 1000, 10), expected) << threads << " threads";
  }
}

TEST_F(CrewTest, HelpersRunChunks) {
  Workers workers(2);
  Crew crew(workers);
  EXPECT_TRUE(helper_arrives(crew));
}

TEST_F(CrewTest, WorkersHaveAsManyThreadsAsTbbLendsAtTheTime) {
  auto few = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, 2);
  Workers workers(4);
  {
    Crew crew(workers);
    EXPECT_EQ(crew.threads(), 2);
    EXPECT_TRUE(helper_arrives(crew));
  }
  few.reset();
  Crew crew(workers);
  EXPECT_EQ(crew.threads(), 4);
  std::atomic<int> here{0};
  for (int tries = 0; tries < 1000 && here != 4; ++tries) {
    here = 0;
    crew.run(4, [&](int, int) {
      ++here;
      for (int i = 0; i < 10 && here != 4; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (here != 4) --here;
    });
  }
  EXPECT_EQ(here, 4) << "all at the same time";
}

TEST_F(CrewTest, WorkerNumbersAreBelowThreadsAndNeverUsedTwiceAtOnce) {
  for (const int threads : {1, 2, 4, 8}) {
    Workers workers(threads);
    std::vector<std::atomic<int>> users(static_cast<std::size_t>(threads));
    for (int step = 0; step < 50; ++step) {
      Crew crew(workers);
      EXPECT_EQ(crew.threads(), threads);
      for (int stage = 0; stage < 20; ++stage) {
        crew.run(64, [&](int, int worker) {
          ASSERT_GE(worker, 0);
          ASSERT_LT(worker, threads);
          EXPECT_EQ(users[static_cast<std::size_t>(worker)].fetch_add(1), 0);
          spin(200);
          users[static_cast<std::size_t>(worker)].fetch_sub(1);
        });
      }
    }
  }
}

TEST_F(CrewTest, StagesOfOneChunkRunOnTheCaller) {
  Workers workers(4);
  Crew crew(workers);
  EXPECT_TRUE(helper_arrives(crew));
  const std::thread::id caller = std::this_thread::get_id();
  for (int stage = 0; stage < 1000; ++stage) {
    crew.run(1, [&](int chunk, int worker) {
      EXPECT_EQ(chunk, 0);
      EXPECT_EQ(worker, 0);
      EXPECT_EQ(std::this_thread::get_id(), caller);
    });
  }
}

TEST_F(CrewTest, TheCallerFinishesEveryStageAloneWhileAllHelpersAreBusy) {
  // TBB is held to a single worker, and that worker sits in a task until the stages are done.
  tbb::global_control one_worker(tbb::global_control::max_allowed_parallelism, 2);
  static std::atomic<bool> occupied{false}, release{false};
  HelperArena elsewhere(1);
  elsewhere.enqueue(
      [](void*) {
        occupied = true;
        while (!release) std::this_thread::yield();
        occupied = false;
      },
      nullptr);
  while (!occupied) std::this_thread::yield();
  {
    Workers workers(2);  // dies before its helper begins, which then must find nothing to touch
    for (int step = 0; step < 100; ++step) {
      Crew crew(workers);
      for (int stage = 0; stage < 50; ++stage) {
        crew.run(16, [&](int, int worker) { EXPECT_EQ(worker, 0); });
      }
    }
  }
  release = true;
  while (occupied) std::this_thread::yield();
  release = false;
}

TEST_F(CrewTest, EightCallersShareOneWorkers) {
  Workers serial(1);
  const std::vector<double> expected = run_stages(serial, 50, 500, 10);
  Workers workers(2);
  std::vector<std::thread> callers;
  std::atomic<int> equal{0};
  for (int i = 0; i < 8; ++i) {
    callers.emplace_back([&] {
      for (int step = 0; step < 20; ++step) equal += run_stages(workers, 50, 500, 10) == expected ? 1 : 0;
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(equal, 8 * 20);
}

TEST_F(CrewTest, StepsRunInsideACallersParallelFor) {
  Workers serial(1);
  const std::vector<double> expected = run_stages(serial, 50, 500, 10);
  Workers workers(4);
  std::atomic<int> equal{0};
  tbb::parallel_for(0, 64, [&](int) { equal += run_stages(workers, 50, 500, 10) == expected ? 1 : 0; });
  EXPECT_EQ(equal, 64);
}

TEST_F(CrewTest, StepsRunInsideAnArenaOfOneSlot) {
  Workers serial(1);
  const std::vector<double> expected = run_stages(serial, 50, 500, 10);
  Workers workers(4);
  tbb::task_arena narrow(1);
  narrow.execute([&] { EXPECT_EQ(run_stages(workers, 50, 500, 10), expected); });
}

TEST_F(CrewTest, ACallersTasksNeverRunInsideAStep) {
  // The caller's own tasks mark the threads that run them; no chunk may find itself inside one of them.
  thread_local static int depth = 0;
  Workers workers(4);
  std::atomic<bool> stop{false};
  std::thread busy([&] {
    while (!stop) {
      tbb::parallel_for(0, 100, [&](int) {
        EXPECT_EQ(depth, 0);
        std::this_thread::yield();
      });
    }
  });
  for (int step = 0; step < 200; ++step) {
    Crew crew(workers);
    for (int stage = 0; stage < 20; ++stage) {
      crew.run(32, [&](int, int) {
        ++depth;
        spin(100);
        --depth;
      });
    }
  }
  stop = true;
  busy.join();
}

TEST_F(CrewTest, WorkersMayDieRightAfterAStep) {
  for (int i = 0; i < 300; ++i) {
    auto workers = std::make_unique<Workers>(1 + i % 8);
    auto values = std::make_unique<std::vector<int>>(64);
    {
      Crew crew(*workers);
      crew.run(64, [&](int chunk, int) { (*values)[static_cast<std::size_t>(chunk)] = chunk; });
    }
    EXPECT_EQ(std::accumulate(values->begin(), values->end(), 0), 63 * 64 / 2);
    workers.reset();
  }
}

TEST_F(CrewTest, ExceptionsReachTheCallerAfterTheStageHasEnded) {
  for (const int threads : {1, 2, 8}) {
    Workers workers(threads);
    Crew crew(workers);
    for (int round = 0; round < 50; ++round) {
      std::atomic<int> inside{0};
      EXPECT_THROW(crew.run(40,
                            [&](int chunk, int) {
                              ++inside;
                              std::this_thread::yield();
                              --inside;
                              if (chunk % 2 == 1) throw std::bad_alloc();
                            }),
                   std::bad_alloc);
      EXPECT_EQ(inside, 0);
    }
    std::atomic<int> runs{0};
    crew.run(40, [&](int, int) { ++runs; });
    EXPECT_EQ(runs, 40) << "the crew goes on after an exception";
  }
}

TEST_F(CrewTest, TheLowestFailingChunksExceptionIsThrownForAnyThreadCount) {
  for (const int threads : {1, 2, 8}) {
    Workers workers(threads);
    Crew crew(workers);
    for (int round = 0; round < 50; ++round) {
      try {
        crew.run(64, [](int chunk, int) {
          if (chunk % 10 == 7) throw std::runtime_error(std::to_string(chunk));
        });
        FAIL() << "nothing thrown";
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "7");
      }
    }
  }
}

TEST_F(CrewTest, AnExceptionOnAHelperReachesTheCaller) {
  Workers workers(2);
  Crew crew(workers);
  ASSERT_TRUE(helper_arrives(crew));
  bool thrown = false;
  for (int tries = 0; tries < 10000 && !thrown; ++tries) {
    try {
      crew.run(64, [](int, int worker) {
        if (worker != 0) throw std::bad_alloc();
        std::this_thread::yield();
      });
    } catch (const std::bad_alloc&) {
      thrown = true;
    }
  }
  EXPECT_TRUE(thrown);
}

}  // namespace
}  // namespace scree
