// Laws of the forced instruction set, seen from a whole step: the requested lanes do the work, and SCREE_ISA
// decides for a program that requests no set. (tests/simd/dispatch/dispatch_test.cpp proves that a table
// holds its own set's code, tests/parallel/crew/workers_test.cpp that workers use the requested table.)
#include <gtest/gtest.h>
#include <simd/dispatch/kernels.h>
#include <tests/determinism/backends.h>

#include <cstdio>
#include <memory>

namespace scree::determinism {
namespace {

// A sphere that rests on the ground: one contact, alone in its block.
double lane_fill_of_one_contact(Isa isa) {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}});
  world.add_shape(ground, Box{{10.0f, 1.0f, 10.0f}});
  const BodyId ball = world.create_body({.position = {0.0f, 0.499f, 0.0f}});
  world.add_shape(ball, Sphere{0.5f});
  Workers workers(WorkersOptions{.threads = 1, .isa = isa});
  step(world, 1.0f / 60.0f, workers);
  EXPECT_EQ(world.stats().contacts, 1);
  return world.stats().lane_fill;
}

TEST(ForcedSet, OneContactFillsOneOfTheSetsLanes) {
  report_unsupported_isas();
  for (const Isa isa : supported_isas()) {
    const auto set = static_cast<simd::InstructionSet>(static_cast<int>(isa) - static_cast<int>(Isa::scalar));
    const simd::Kernels* kernels = simd::find_kernels(set);
    ASSERT_NE(kernels, nullptr);
    EXPECT_STREQ(kernels->name, isa_name(isa));
    EXPECT_DOUBLE_EQ(lane_fill_of_one_contact(isa), 1.0 / kernels->lanes) << isa_name(isa);
  }
}

// What a child process prints.
std::string output_of(const std::string& command) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  char part[256];
  while (pipe && std::fgets(part, sizeof part, pipe.get()) != nullptr) output += part;
  return output;
}

TEST(ForcedSet, TheEnvironmentDecidesForAProgramThatRequestsNoSet) {
  std::string hash;
  for (const Isa isa : supported_isas()) {
    const std::string name = isa_name(isa);
    const std::string output = output_of("SCREE_ISA=" + name + " '" SCREE_GOLDEN_PROGRAM "' backend 2>&1");
    ASSERT_EQ(output.substr(0, name.size() + 1), name + " ") << output;
    if (hash.empty()) hash = output.substr(name.size());
    EXPECT_EQ(output.substr(name.size()), hash) << "another hash with " << name;
  }
}

TEST(ForcedSet, AnUnknownSetInTheEnvironmentIsAnErrorThatNamesIt) {
  const std::string output = output_of("SCREE_ISA=mmx '" SCREE_GOLDEN_PROGRAM "' backend 2>&1");
  EXPECT_NE(output.find("mmx"), std::string::npos) << output;
  EXPECT_EQ(output.find("hash"), std::string::npos) << output;
}

}  // namespace
}  // namespace scree::determinism
