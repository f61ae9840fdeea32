// Laws of checkpoints: whoever reads one goes on with the same bits; damage is refused.
#include <core/state/recording_format/recording_chunks.h>
#include <gtest/gtest.h>
#include <parallel/recording/rows_in_order.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <scree/step.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

// A file that goes with its test.
struct TemporaryFile {
  explicit TemporaryFile(const std::string& of)
      : name((std::filesystem::temp_directory_path() / ("scree_test_" + std::to_string(getpid()) + "_" + of))
                 .string()) {}
  ~TemporaryFile() {
    std::remove(name.c_str());
    std::remove((name + ".draft").c_str());
  }
  std::string read() const {
    std::ifstream in(name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& bytes) const { std::ofstream(name, std::ios::binary) << bytes; }
  std::string name;
};

// Some sleep, some fall, some are jointed.
World make_mixture() {
  scenes::Scene scene = scenes::build("pile", {{"bodies", 70}}).front();
  scene.settings.contact_events = ContactEvents::all;
  World world(scene.settings);
  const std::vector<BodyId> bodies = scenes::populate(world, scene);
  BodyId last = world.create_body({.type = BodyType::fixed});
  for (int i = 0; i < 12; ++i) {
    const BodyId link = world.create_body({.position = {-3.0f + 0.5f * static_cast<float>(i), 9, 0}});
    world.add_shape(link, Box{{0.22f, 0.1f, 0.1f}});
    world.create_joint({.body_a = last,
                        .body_b = link,
                        .frame_a = {i == 0 ? Vec3{-3.25f, 9, 0} : Vec3{0.25f, 0, 0}, {}},
                        .frame_b = {{-0.25f, 0, 0}, {}}},
                       BallJoint{});
    last = link;
  }
  return world;
}

std::vector<std::uint64_t> hashes_of_steps(World& world, int steps) {
  Workers workers(1);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < steps; ++i) {
    step(world, kStep, workers);
    hashes.push_back(world.hash());
  }
  return hashes;
}

void write_on_ranks(const std::string& file, int ranks, int steps) {
  const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
    DistributedWorld world(make_mixture(), transport, {.steps_per_look = 9, .imbalance = 1.0f});
    Workers workers(1);
    for (int i = 0; i < steps; ++i) {
      if (i % 50 == 20) world.checkpoint(file, workers);  // which changes nothing
      world.step(kStep, workers);
    }
    world.checkpoint(file, workers);
  });
  EXPECT_EQ(all_of(errors), "");
}

TEST(Checkpoint, AnyNumberOfRanksGoesOnWithTheSameBits) {
  const TemporaryFile file("checkpoint_any");
  constexpr int kMore = 60;
  for (const int before : {30, 400}) {  // most fall; most sleep
    World expected = make_mixture();
    hashes_of_steps(expected, before);
    World as_written = clone(expected);
    const std::vector<std::uint64_t> future = hashes_of_steps(expected, kMore);
    for (const int ranks : {1, 4}) {
      write_on_ranks(file.name, ranks, before);
      World alone = read_checkpoint(file.name);
      EXPECT_EQ(first_difference_but_for_order(as_written, alone), "") << ranks << " ranks";
      EXPECT_EQ(hashes_of_steps(alone, kMore), future) << "1 process after " << ranks << " ranks";
    }
    const auto errors = run_ranks(3, [&](int, Transport& transport) {
      DistributedWorld world(read_checkpoint(file.name), transport);
      Workers workers(1);
      for (int i = 0; i < kMore; ++i) {
        world.step(kStep, workers);
        ASSERT_EQ(world.hash(), future[static_cast<std::size_t>(i)]) << "3 ranks after 4, step " << i;
      }
    });
    EXPECT_EQ(all_of(errors), "");
  }
}

TEST(Checkpoint, ASingleProcessWritesTheSameKind) {
  const TemporaryFile file("checkpoint_single");
  World world = make_mixture();
  hashes_of_steps(world, 20);
  write_checkpoint(world, file.name);
  World read = read_checkpoint(file.name);
  EXPECT_EQ(first_difference(world, read), "");
  EXPECT_FALSE(std::filesystem::exists(file.name + ".draft"));
}

std::string refusal(const TemporaryFile& file) {
  try {
    read_checkpoint(file.name);
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(CheckpointDamage, IsRefusedWithTheReason) {
  const TemporaryFile file("checkpoint_damage");
  EXPECT_NE(refusal(file).find("cannot be opened"), std::string::npos);
  write_on_ranks(file.name, 3, 25);
  const std::string whole = file.read();
  EXPECT_EQ(refusal(file), "none");
  const auto expect_refused = [&](const std::string& bytes, const std::string& reason) {
    file.write(bytes);
    const std::string told = refusal(file);
    EXPECT_NE(told.find(reason), std::string::npos) << told;
    EXPECT_NE(told.find(file.name), std::string::npos) << told;
  };
  expect_refused("", "ends too early");
  for (const std::size_t length : {std::size_t{8}, std::size_t{60}, whole.size() / 2, whole.size() - 1})
    expect_refused(whole.substr(0, length), "ends too early");
  expect_refused(whole + "x", "more follows");
  expect_refused("SCREESNP" + whole.substr(8), "no checkpoint");
  physics::Random random(5);
  for (int i = 0; i < 60; ++i) {
    std::string changed = whole;
    const auto place = static_cast<std::size_t>(random.uniform(0, static_cast<float>(whole.size()) - 0.5f));
    changed[place] = static_cast<char>(changed[place] ^ (1 << i % 8));
    file.write(changed);
    EXPECT_NE(refusal(file), "none") << "byte " << place;
  }
}

// Writes the checksums anew, as somebody would who wants the damage to be read.
void seal(std::string& bytes) {
  constexpr std::size_t kTable = 32;
  const auto number_at = [&](std::size_t at) {
    std::uint64_t number = 0;
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
  };
  const auto hash_at = [&](std::size_t begin, std::size_t count, std::size_t to) {
    const std::uint64_t hash = hash_of_bytes(std::as_bytes(std::span(bytes.data() + begin, count)));
    std::memcpy(bytes.data() + to, &hash, sizeof hash);
  };
  const auto ranks = static_cast<std::size_t>(number_at(24));
  const std::size_t table_end = kTable + 16 * ranks;
  std::size_t begin = table_end + 8;
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    const auto count = static_cast<std::size_t>(number_at(kTable + 16 * rank));
    hash_at(begin, count, kTable + 16 * rank + 8);
    begin += count;
  }
  hash_at(0, table_end, table_end);
}

// What other ranks have sent is checked, too: it is refused, or is some world.
TEST(CheckpointDamage, WithChecksumsThatFitNeverCorruptsAWorld) {
  const TemporaryFile file("checkpoint_sealed");
  write_on_ranks(file.name, 3, 45);
  const std::string whole = file.read();
  const std::size_t head = 32 + 3 * 16 + 8;
  std::uint64_t first_part = 0;
  std::memcpy(&first_part, whole.data() + 32, sizeof first_part);
  const std::size_t begin = head + static_cast<std::size_t>(first_part);  // of the messages of ranks 1 and 2
  physics::Random random(11);
  int refused = 0;
  constexpr int kTries = 150;
  for (int i = 0; i < kTries; ++i) {
    std::string changed = whole;
    const auto left = static_cast<float>(whole.size() - begin) - 8.5f;
    const std::size_t place = begin + static_cast<std::size_t>(random.uniform(0, left));
    const std::uint32_t values[] = {0u, 1u, 0xffffffffu, 0x7fffffffu, 0x7fc00000u, 1u << (i % 32)};
    const std::uint32_t value = values[i % 6];
    std::memcpy(changed.data() + (i % 2 == 0 ? place / 4 * 4 : place), &value, sizeof value);
    seal(changed);
    file.write(changed);
    try {
      World world = read_checkpoint(file.name);
      hashes_of_steps(world, 2);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(file.name), std::string::npos) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, kTries);
}

TEST(CheckpointDamage, NoRankGoesOnWhereTheFileCannotBeWritten) {
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    DistributedWorld world(make_mixture(), transport);
    Workers workers(1);
    EXPECT_THROW(world.checkpoint("/no/such/folder/world.scree", workers), Error);
    EXPECT_THROW(world.record("/no/such/folder/run.scree", workers), Error);
    EXPECT_THROW(world.record("unused.scree", workers, {.keyframe_spacing = 0}), Error);
    world.step(kStep, workers);
    world.finish_recording(workers);  // nothing was recorded
  });
  EXPECT_EQ(all_of(errors), "");
}

}  // namespace
}  // namespace scree
