// Laws of assertions: builds with assertions check them, builds without do not evaluate them.
#include <core/plain/assert.h>

#include <gtest/gtest.h>

namespace scree::test {
namespace {

#ifdef SCREE_ASSERTIONS

TEST(AssertDeathTest, AFailureNamesTheConditionAndItsPlace) {
  EXPECT_DEATH(SCREE_ASSERT(1 + 1 == 3), "assert_test\\.cpp:[0-9]+: assertion failed: 1 \\+ 1 == 3");
}

TEST(Assert, AConditionThatHoldsIsEvaluatedOnceAndHasNoEffect) {
  int evaluations = 0;
  SCREE_ASSERT(++evaluations > 0);
  EXPECT_EQ(evaluations, 1);
}

#else

TEST(Assert, ABuildWithoutAssertionsNeverEvaluatesTheCondition) {
  int looked = 0;
  const auto look = [&] { return ++looked > 0; };
  SCREE_ASSERT(look());
  SCREE_ASSERT(!look());
  EXPECT_EQ(looked, 0);
}

#endif

}  // namespace
}  // namespace scree::test
