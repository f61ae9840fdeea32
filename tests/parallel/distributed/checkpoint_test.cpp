// Laws of checkpoints: whoever reads one goes on with the same bits; damage is refused.
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/world/world_data.h>
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
#include <initializer_list>
#include <iterator>
#include <mutex>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <tuple>
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

// Each of so many ranks reads its share.
void expect_future(const std::string& file, int ranks, const std::vector<std::uint64_t>& future) {
  const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
    Workers workers(1);
    DistributedWorld world = read_checkpoint(file, transport, workers);
    for (std::size_t i = 0; i < future.size(); ++i) {
      world.step(kStep, workers);
      ASSERT_EQ(world.hash(), future[i]) << ranks << " ranks, step " << i;
    }
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
    for (const int ranks : {1, 2, 3, 4, 7}) expect_future(file.name, ranks, future);
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
  expect_future(file.name, 3, hashes_of_steps(world, 30));
}

// A rank has no rows of bodies that were in parts which others read.
TEST(Checkpoint, EachRankReadsItsShareAlone) {
  const TemporaryFile file("checkpoint_share");
  constexpr int kWriters = 4, kReaders = 5, kBodies = 70 + 12;
  write_on_ranks(file.name, kWriters, 30);
  std::vector<int> own(kReaders), here(kReaders);
  const auto errors = run_ranks(kReaders, [&](int rank, Transport& transport) {
    Workers workers(1);
    const DistributedWorld world = read_checkpoint(file.name, transport, workers);
    const WorldData& data = internals(world.world(), "test");
    for (std::size_t row = kFirstBody; row < data.bodies.flags.size(); ++row) {
      const auto body = static_cast<std::int32_t>(row);
      if (data.bodies.type[row] != BodyType::dynamic) continue;
      const bool is_own = world.owns(world.world().body_at(static_cast<std::uint32_t>(row)));
      own[static_cast<std::size_t>(rank)] += is_own ? 1 : 0;
      here[static_cast<std::size_t>(rank)] += is_absent(data.bodies, body) ? 0 : 1;
      EXPECT_FALSE(is_own && is_absent(data.bodies, body)) << row;
    }
  });
  EXPECT_EQ(all_of(errors), "");
  EXPECT_EQ(std::accumulate(own.begin(), own.end(), 0), kBodies);
  // What it has read and given to another is there until the next step.
  for (const int of_rank : here) EXPECT_LE(of_rank, 2 * (kBodies / kWriters + 1));
}

// Bodies and joints that have gone leave slots that ranks must agree on; calls made before the checkpoint
// wait for the next step.
TEST(Checkpoint, HoldsWhatCallsHaveLeft) {
  const TemporaryFile file("checkpoint_calls");
  const auto make_calls = [](World& world, int round) {
    const auto body = [&](std::uint32_t place) { return world.body_at(kFirstBody + place); };
    const auto shift = static_cast<std::uint32_t>(10 * round);
    world.destroy_body(body(5 + shift));
    world.set_body_type(body(6 + shift), BodyType::kinematic);
    world.set_linear_velocity(body(7 + shift), {0.3f, 2.0f, 0.1f});
    const BodyId added = world.create_body({.position = {0.1f, 7.0f, static_cast<float>(round)}});
    world.add_shape(added, Sphere{0.3f});
  };
  World expected = make_mixture();
  hashes_of_steps(expected, 25);
  make_calls(expected, 0);
  hashes_of_steps(expected, 5);
  make_calls(expected, 1);
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    DistributedWorld world(make_mixture(), transport);
    Workers workers(1);
    for (int i = 0; i < 25; ++i) world.step(kStep, workers);
    make_calls(world.world(), 0);
    for (int i = 0; i < 5; ++i) world.step(kStep, workers);
    make_calls(world.world(), 1);
    world.checkpoint(file.name, workers);
  });
  EXPECT_EQ(all_of(errors), "");
  World alone = read_checkpoint(file.name);
  const std::vector<std::uint64_t> future = hashes_of_steps(expected, 40);
  EXPECT_EQ(hashes_of_steps(alone, 40), future);
  for (const int ranks : {2, 3}) expect_future(file.name, ranks, future);
}

// What the steps after a checkpoint tell of contacts and sensors, each once whoever tells it.
using Told = std::set<std::tuple<int, int, std::uint32_t, std::uint32_t>>;  // step, kind, shapes

void note_events(const World& world, int step, Told& told) {
  for (const ContactEvent& event : world.contact_begins())
    told.insert({step, 0, event.shape_a.index, event.shape_b.index});
  for (const ContactEnd& event : world.contact_ends())
    told.insert({step, 1, event.shape_a.index, event.shape_b.index});
  for (const SensorEvent& event : world.sensor_begins())
    told.insert({step, 2, event.sensor.index, event.visitor.index});
  for (const SensorEvent& event : world.sensor_ends())
    told.insert({step, 3, event.sensor.index, event.visitor.index});
}

// Of bodies and shapes that go, or become everybody's, right before it.
TEST(Checkpoint, LetsNoEventOfContactsGetLost) {
  const TemporaryFile file("checkpoint_events");
  constexpr int kMore = 3;
  const auto make = [] {
    World world = make_mixture();
    const BodyId gate = world.create_body({.type = BodyType::fixed});
    world.add_shape(gate, Box{{6, 1, 6}}, {}, {.local_pose = {{0, 1.5f, 0}, {}}, .sensor = true});
    return world;
  };
  const auto make_calls = [](World& world) {
    for (std::uint32_t place = 4; place < 70; place += 9) {
      const BodyId body = world.body_at(kFirstBody + place);
      ShapeId shape;
      if (place % 3 == 0) world.destroy_body(body);
      if (place % 3 == 1) world.set_body_type(body, BodyType::kinematic);
      if (place % 3 == 2 && world.shapes_of(body, {&shape, 1}) > 0) world.destroy_shape(shape);
    }
    world.destroy_body(world.body_at(kFirstBody + 20));
    ShapeId shape;
    if (world.shapes_of(world.body_at(kFirstBody + 33), {&shape, 1}) > 0) world.destroy_shape(shape);
  };
  for (const int before : {60, 400}) {
    World expected = make();
    hashes_of_steps(expected, before);
    make_calls(expected);
    Told right;
    for (int i = 0; i < kMore; ++i) {
      hashes_of_steps(expected, 1);
      note_events(expected, i, right);
    }
    EXPECT_GT(right.size(), 8u);
    for (const int writers : {1, 3, 5}) {
      Snapshot saved;
      auto errors = run_ranks(writers, [&](int, Transport& transport) {
        DistributedWorld world(make(), transport, {.steps_per_look = 9, .imbalance = 1.0f});
        Workers workers(1);
        for (int i = 0; i < before; ++i) world.step(kStep, workers);
        make_calls(world.world());
        world.checkpoint(file.name, workers);
        Snapshot own;
        world.save(own, workers);
        if (transport.rank() == 0) saved = std::move(own);
      });
      EXPECT_EQ(all_of(errors), "");
      World read = read_checkpoint(file.name), restored;
      restore(restored, saved);
      for (World* const alone : {&read, &restored}) {
        Told by_one;
        for (int i = 0; i < kMore; ++i) {
          hashes_of_steps(*alone, 1);
          note_events(*alone, i, by_one);
        }
        EXPECT_EQ(by_one, right) << "1 process after " << writers << (alone == &read ? ", file" : ", save");
      }
      for (const int readers : {2, 4, 6}) {
        Told told;
        std::mutex mutex;
        errors = run_ranks(readers, [&](int, Transport& transport) {
          Workers workers(1);
          DistributedWorld world = read_checkpoint(file.name, transport, workers);
          for (int i = 0; i < kMore; ++i) {
            world.step(kStep, workers);
            const std::lock_guard lock(mutex);
            note_events(world.world(), i, told);
          }
        });
        EXPECT_EQ(all_of(errors), "");
        EXPECT_EQ(told, right) << readers << " ranks after " << writers;
      }
    }
  }
}

TEST(Checkpoint, TellsHowManyRanksWroteIt) {
  const TemporaryFile file("checkpoint_ranks");
  EXPECT_THROW(checkpoint_ranks(file.name), Error);
  for (const int ranks : {1, 3}) {
    write_on_ranks(file.name, ranks, 2);
    EXPECT_EQ(checkpoint_ranks(file.name), ranks);
  }
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

// A file taken apart, and put together again with checksums that fit, as by somebody who wants the damage to
// be read.
struct TakenApart {
  static constexpr std::size_t kTable = 32;
  explicit TakenApart(const std::string& bytes) : head(bytes.substr(0, kTable)) {
    const auto number_at = [&](std::size_t at) {
      std::uint64_t number = 0;
      std::memcpy(&number, bytes.data() + at, sizeof number);
      return static_cast<std::size_t>(number);
    };
    const std::size_t count = number_at(24);
    std::size_t begin = kTable + 16 * count + 8;
    for (std::size_t part = 0; part < count; ++part) {
      parts.push_back(bytes.substr(begin, number_at(kTable + 16 * part)));
      begin += parts.back().size();
    }
  }
  std::string put_together() const {
    const auto hash = [](const std::string& of) { return hash_of_bytes(std::as_bytes(std::span(of))); };
    std::string bytes = head;
    const auto put = [&](std::uint64_t number) {
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    for (const std::string& part : parts) {
      put(part.size());
      put(hash(part));
    }
    put(hash(bytes));
    for (const std::string& part : parts) bytes += part;
    return bytes;
  }
  std::string head;
  std::vector<std::string> parts;  // what all have in common, owners, messages by rank
};

// What each of two ranks says that reads its share, and goes on for some steps.
std::vector<std::string> read_on_ranks(const std::string& file) {
  return run_ranks(2, [&](int, Transport& transport) {
    Workers workers(1);
    DistributedWorld world = read_checkpoint(file, transport, workers);
    for (int i = 0; i < 2; ++i) world.step(kStep, workers);
  });
}

// Also the parts that no checksum holds for are checked: they are refused, or are some world.
TEST(CheckpointDamage, WithChecksumsThatFitNeverCorruptsAWorld) {
  const TemporaryFile file("checkpoint_sealed");
  write_on_ranks(file.name, 3, 45);
  const TakenApart whole(file.read());
  ASSERT_EQ(whole.parts.size(), 5u);
  EXPECT_EQ(whole.put_together(), file.read());
  physics::Random random(11);
  int refused = 0;
  constexpr int kTries = 300;
  for (int i = 0; i < kTries; ++i) {
    TakenApart changed = whole;
    std::string& part = changed.parts[static_cast<std::size_t>(i % 5)];
    const auto left = static_cast<float>(part.size()) - 8.5f;
    const std::size_t place = static_cast<std::size_t>(random.uniform(0, left));
    const std::uint32_t values[] = {0u, 1u, 0xffffffffu, 0x7fffffffu, 0x7fc00000u, 1u << (i % 32)};
    const std::uint32_t value = values[i % 6];
    std::memcpy(part.data() + (i % 2 == 0 ? place / 4 * 4 : place), &value, sizeof value);
    if (i % 5 == 0) seal_snapshot(std::as_writable_bytes(std::span(part)));
    file.write(changed.put_together());
    try {
      World world = read_checkpoint(file.name);
      hashes_of_steps(world, 2);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(file.name), std::string::npos) << error.what();
      ++refused;
    }
    const std::vector<std::string> told = read_on_ranks(file.name);
    EXPECT_EQ(told[0].empty(), told[1].empty()) << told[0] << told[1];
    if (!told[0].empty()) {
      EXPECT_NE(told[0].find(file.name), std::string::npos) << told[0];
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, kTries);
}

std::string numbers(std::initializer_list<std::uint64_t> all) {
  std::string bytes;
  for (const std::uint64_t one : all) bytes.append(reinterpret_cast<const char*>(&one), sizeof one);
  return bytes;
}

TEST(CheckpointDamage, OfWhoHasABodyIsRefused) {
  const TemporaryFile file("checkpoint_owners");
  write_on_ranks(file.name, 3, 20);
  const TakenApart whole(file.read());
  const auto expect_refused = [&](const TakenApart& changed, const std::string& reason) {
    file.write(changed.put_together());
    const std::string told = refusal(file);
    EXPECT_NE(told.find(reason), std::string::npos) << told;
    EXPECT_NE(told.find(file.name), std::string::npos) << told;
    const std::vector<std::string> by_rank = read_on_ranks(file.name);
    EXPECT_EQ(by_rank[0], by_rank[1]);
    EXPECT_NE(by_rank[0].find(file.name), std::string::npos) << by_rank[0];
  };
  TakenApart changed = whole;
  std::string& nothing = changed.parts[3];  // nine messages; the second one has a byte
  nothing = numbers({0, 1}) + std::string(1, '\0') + numbers({0, 0, 0, 0, 0, 0, 0});
  expect_refused(changed, "no rank has sent body ");
  changed = whole;
  changed.parts[4] = changed.parts[3];
  expect_refused(changed, "rank 2 has sent what does not fit");
}

// Reads bytes as the shares of ranks are read.
TEST(CheckpointDamage, OfOwnersIsRefused) {
  const TemporaryFile file("checkpoint_owner_table");
  write_on_ranks(file.name, 3, 20);
  const TakenApart whole(file.read());
  const auto expect_refused = [&](const std::string& owners, const std::string& reason) {
    TakenApart changed = whole;
    changed.parts[1] = owners;
    file.write(changed.put_together());
    for (const std::string& told : read_on_ranks(file.name)) {
      EXPECT_NE(told.find(reason), std::string::npos) << told;
      EXPECT_NE(told.find(file.name), std::string::npos) << told;
    }
  };
  const std::string owners = whole.parts[1];
  expect_refused(owners.substr(4), "the owners are not as many as the bodies");
  std::int32_t first = 0;
  std::memcpy(&first, owners.data(), sizeof first);
  EXPECT_EQ(first, -1) << "the first row is the world's own";
  const std::size_t last = owners.size() - sizeof first;  // a link of the chain
  for (const std::int32_t wrong : {3, -1, -2, 0x7fffffff}) {
    std::string changed = owners;
    std::memcpy(changed.data() + last, &wrong, sizeof wrong);
    expect_refused(changed, "is rank " + std::to_string(wrong) + " of 3");
  }
  const std::int32_t other = owners[last] == 2 ? 0 : 2;  // which another reader has
  std::string changed = owners;
  std::memcpy(changed.data() + last, &other, sizeof other);
  expect_refused(changed, "no rank has sent body ");
}

TEST(CheckpointDamage, OfOneRankIsToldByAll) {
  const TemporaryFile file("checkpoint_one"), other("checkpoint_other");
  write_on_ranks(file.name, 3, 20);
  write_on_ranks(other.name, 3, 21);
  const auto read_each = [&](const std::string& last) {
    return run_ranks(3, [&](int rank, Transport& transport) {
      Workers workers(1);
      const DistributedWorld world = read_checkpoint(rank == 2 ? last : file.name, transport, workers);
    });
  };
  for (const std::string& told : read_each("/no/such/file"))
    EXPECT_EQ(told, "rank 2: read_checkpoint: /no/such/file: cannot be opened");
  for (const std::string& told : read_each(other.name))
    EXPECT_EQ(told, "DistributedWorld: the checkpoint of rank 2 is not that of rank 0");
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
