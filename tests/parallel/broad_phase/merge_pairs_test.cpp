// Laws of the merge of two lists of pairs: each pair once, at its place, however the lists are cut.
#include <gtest/gtest.h>
#include <parallel/broad_phase/merge_pairs.h>
#include <tests/parallel/hand_made_world.h>

#include <set>

namespace scree::testing {
namespace {

struct Lists {
  Column<ShapePair> first, second;
  std::vector<ShapePair> all;
};

Lists random_lists(std::uint32_t first, std::uint32_t second, Random& random) {
  std::set<std::pair<std::int32_t, std::int32_t>> keys;
  while (keys.size() < first + second) {
    const auto a = static_cast<std::int32_t>(random.below(3000));
    keys.insert({a, a + 1 + static_cast<std::int32_t>(random.below(3000))});
  }
  Lists lists;
  std::uint32_t left = first + second;
  for (const auto& [a, b] : keys) {
    const ShapePair pair{a, b};
    lists.all.push_back(pair);
    const bool to_first = random.below(left--) < first;
    (to_first ? lists.first : lists.second).push_back(pair);
    if (to_first) --first;
  }
  return lists;
}

TEST(MergePairs, PutsEachPairOnceAtItsPlace) {
  Random random(3);
  const std::pair<std::uint32_t, std::uint32_t> sizes[] = {
      {0, 0}, {0, 9}, {9, 0}, {0, 9000}, {9000, 0}, {30000, 1}, {1, 30000}, {20000, 20000}, {4096, 4096}};
  for (const auto& [first, second] : sizes) {
    const Lists lists = random_lists(first, second, random);
    for (const int threads : {1, 4}) {
      Workers workers(threads);
      Crew crew(workers);
      std::vector<ShapePair> merged(lists.all.size());
      std::vector<int> puts(lists.all.size());
      merge_pairs(lists.first, lists.second, crew,
                  [&](std::size_t place, bool is_of_second, std::size_t row) {
                    merged[place] = (is_of_second ? lists.second : lists.first)[row];
                    ++puts[place];
                  });
      EXPECT_TRUE(std::equal(merged.begin(), merged.end(), lists.all.begin(),
                             [](ShapePair a, ShapePair b) { return a.a == b.a && a.b == b.b; }))
          << first << " and " << second;
      EXPECT_EQ(puts, std::vector<int>(lists.all.size(), 1));
    }
  }
}

}  // namespace
}  // namespace scree::testing
