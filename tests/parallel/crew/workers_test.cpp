// Laws of Workers: errors name impossible options, and SCREE_ISA decides if a program requests no set.
#include <gtest/gtest.h>
#include <parallel/crew/crew.h>
#include <sched.h>
#include <unistd.h>

#include <cstdlib>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace scree {
namespace {

// Sets or unsets SCREE_ISA and puts it back.
class IsaVariable {
 public:
  explicit IsaVariable(const char* value) {
    if (const char* old = std::getenv("SCREE_ISA")) old_ = old;
    set(value);
  }
  ~IsaVariable() { set(old_ ? old_->c_str() : nullptr); }

 private:
  static void set(const char* value) {
    value != nullptr ? ::setenv("SCREE_ISA", value, 1) : ::unsetenv("SCREE_ISA");
  }
  std::optional<std::string> old_;
};

std::string error_of(const WorkersOptions& options) {
  try {
    Workers workers(options);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

constexpr Isa kIsas[] = {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512};

TEST(Workers, AnImpossibleNumberOfThreadsIsNamedWithItsLimit) {
  for (const int threads : {-1, -2147483647, 1025, 2147483647}) {
    const std::string message = error_of({.threads = threads});
    EXPECT_NE(message.find(std::to_string(threads)), std::string::npos) << message;
    EXPECT_NE(message.find("1024"), std::string::npos) << message;
  }
  EXPECT_EQ(Workers(1).threads(), 1);
  EXPECT_EQ(Workers(1024).threads(), 1024);
}

TEST(Workers, ZeroThreadsMeansOnePerCoreOfTheProcess) {
  cpu_set_t cores;
  ASSERT_EQ(sched_getaffinity(0, sizeof(cores), &cores), 0);
  EXPECT_EQ(Workers().threads(), CPU_COUNT(&cores));
  std::thread([&] {
    int first = 0;
    while (!CPU_ISSET(first, &cores)) ++first;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(first, &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
    EXPECT_EQ(Workers().threads(), 1);
  }).join();
}

TEST(Workers, AForcedInstructionSetIsTheOneThatCrewsUse) {
  for (const Isa isa : kIsas) {
    if (!is_supported(isa)) continue;
    Workers workers(WorkersOptions{.threads = 2, .isa = isa});
    EXPECT_EQ(workers.isa(), isa);
    Crew crew(workers);
    EXPECT_STREQ(crew.kernels().name, isa_name(isa));
  }
}

TEST(Workers, TheEnvironmentChoosesIfTheCallDoesNot) {
  for (const Isa isa : kIsas) {
    if (!is_supported(isa)) continue;
    const IsaVariable variable(isa_name(isa));
    EXPECT_EQ(Workers(1).isa(), isa);
    EXPECT_EQ(Workers(WorkersOptions{.threads = 1, .isa = Isa::scalar}).isa(), Isa::scalar)
        << "an explicit choice wins";
  }
}

TEST(Workers, WithoutAnyChoiceTheWidestSupportedSetIsUsed) {
  for (const char* value : {static_cast<const char*>(nullptr), "", "auto"}) {
    const IsaVariable variable(value);
    Isa widest = Isa::scalar;
    for (const Isa isa : kIsas) widest = is_supported(isa) ? isa : widest;
    EXPECT_EQ(Workers(1).isa(), widest);
  }
}

TEST(Workers, AnUnknownInstructionSetIsAnErrorThatListsTheKnownOnes) {
  const IsaVariable variable("avx1024");
  const std::string message = error_of({.threads = 1});
  for (const char* part : {"SCREE_ISA", "'avx1024'", "auto", "scalar", "sse2", "avx2", "avx512"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  EXPECT_NE(error_of({.threads = 1, .isa = static_cast<Isa>(9)}).find("9"), std::string::npos);
  EXPECT_FALSE(is_supported(static_cast<Isa>(9)));
  EXPECT_STREQ(isa_name(static_cast<Isa>(9)), "unknown");
}

TEST(Workers, AnUnsupportedInstructionSetIsAnErrorThatListsTheSupportedOnes) {
  for (const Isa isa : kIsas) {
    if (is_supported(isa)) continue;
    const std::string message = error_of({.threads = 1, .isa = isa});
    EXPECT_NE(message.find(isa_name(isa)), std::string::npos) << message;
    EXPECT_NE(message.find("supported are auto, scalar"), std::string::npos) << message;
    const IsaVariable variable(isa_name(isa));
    EXPECT_NE(error_of({.threads = 1}).find("SCREE_ISA"), std::string::npos);
  }
}

TEST(Workers, RequestNoMoreThreadsThanTbbLends) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto run = [] {
    for (const int threads : {1024, 2, 17}) {
      Workers workers(threads);
      Crew crew(workers);
      EXPECT_LE(crew.threads(), Workers().threads());
      crew.run(100, [](int, int) {});
    }
    _exit(testing::Test::HasFailure() ? 1 : 0);
  };
  EXPECT_EXIT(run(), testing::ExitedWithCode(0), testing::Eq(""));  // TBB would warn on standard error
}

TEST(Workers, MayBeMovedBetweenSteps) {
  Workers first(2);
  Workers second(std::move(first));
  EXPECT_EQ(second.threads(), 2);
  first = Workers(1);
  EXPECT_EQ(first.threads(), 1);
  Crew crew(second);
  int runs = 0;
  crew.run(1, [&](int, int) { ++runs; });
  EXPECT_EQ(runs, 1);
}

}  // namespace
}  // namespace scree
