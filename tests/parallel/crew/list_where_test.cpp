// Laws of lists made in parallel: they hold what is kept, in order, and each is asked about once.
#include <gtest/gtest.h>
#include <parallel/crew/list_where.h>
#include <tbb/global_control.h>

#include <atomic>
#include <random>
#include <vector>

namespace scree {
namespace {

TEST(ListWhere, ListsWhatIsKeptInOrderAndAsksOnce) {
  // TBB lends one thread per core unless told otherwise.
  const tbb::global_control more_threads(tbb::global_control::max_allowed_parallelism, 4);
  std::mt19937 random(1);
  for (const int threads : {1, 3}) {
    Workers workers(threads);
    Crew crew(workers);
    Column<std::int32_t> places, list;
    for (const int count : {0, 1, 31, 32, 33, 4095, 4096, 4097, 20'000, 8192}) {
      for (const unsigned share : {0u, 1u, 50u, 99u, 100u}) {
        std::vector<std::uint8_t> kept(static_cast<std::size_t>(count));
        std::vector<std::int32_t> expected;
        for (int i = 0; i < count; ++i) {
          kept[static_cast<std::size_t>(i)] = random() % 100 < share ? 1 : 0;
          if (kept[static_cast<std::size_t>(i)] != 0) expected.push_back(3 * i);
        }
        std::vector<std::atomic<int>> asked(static_cast<std::size_t>(count));
        list_where(
            crew, kept.size(), places, list,
            [&](std::int32_t i) {
              ++asked[static_cast<std::size_t>(i)];
              return kept[static_cast<std::size_t>(i)] != 0;
            },
            [](std::int32_t i) { return 3 * i; });
        EXPECT_EQ(std::vector<std::int32_t>(list.begin(), list.end()), expected) << count << " " << share;
        for (const std::atomic<int>& times : asked) EXPECT_EQ(times, 1);
      }
    }
  }
}

}  // namespace
}  // namespace scree
