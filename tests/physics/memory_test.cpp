// Laws of memory: the layout of rows bounds the memory of a settled pile.
#include <core/world/state_table.h>
#include <parallel/narrow_phase/narrow_phase.h>
#include <simd/dispatch/kernels.h>
#include <tests/physics/lab.h>

#include <map>
#include <string>

namespace scree::physics {
namespace {

// Bytes of a row: of all columns of a store together.
template <class Rows>
std::size_t row_bytes(Rows rows = {}) {
  std::size_t bytes = 0;
  rows.for_each_column([&](ColumnKind, const char*, auto& column) { bytes += sizeof(*column.data()); });
  return bytes;
}

// Slack of columns beyond their rows: small columns grow by half.
constexpr double kSlack = 1.5;
// Free rows of contacts that have been lost.
constexpr double kLostContacts = 500;
// Rows that collide has for a round of pairs that are no contacts yet.
constexpr double kRoundRows = kRoundChunks * simd::kCollideChunk;

class SettledPile : public ::testing::Test {
 protected:
  static constexpr std::size_t kBodies = 4000;
  SettledPile() : pile_("pile", {{"bodies", kBodies}}) {
    pile_.lab.run(280);
    for_each_member_size(data(), [&](ColumnKind, const char* store, const char*, std::size_t,
                                     std::size_t held) { held_[store] += static_cast<double>(held); });
  }
  WorldData& data() { return internals(pile_.lab.world); }
  double held(const std::string& store) const {  // and stores within it
    double sum = held_.at(store);
    for (const auto& [name, bytes] : held_) sum += name.rfind(store + ".", 0) == 0 ? bytes : 0.0;
    return sum;
  }
  double pairs() const { return static_cast<double>(pile_.lab.world.stats().pairs); }
  double contacts() const { return static_cast<double>(pile_.lab.world.stats().contacts); }

  SceneLab pile_;
  std::map<std::string, double> held_;
};

TEST_F(SettledPile, HasRowsForContactsAndNotForPairs) {
  EXPECT_GT(pairs(), 1.8 * contacts());
  EXPECT_GT(contacts(), 2.5 * kBodies);
  EXPECT_LE(row_bytes<ContactRows>(), 256u);
  EXPECT_LE(static_cast<double>(data().contacts.now.pair.size()), contacts() + kLostContacts);
  EXPECT_LE(held("contacts.now"),
            kSlack * (contacts() + kLostContacts) * static_cast<double>(row_bytes<ContactRows>()));
}

TEST_F(SettledPile, TakesLittleMemoryPerPair) {
  EXPECT_LE(row_bytes<PairRows>(), 28u);
  // The lists of this step and the last one, how far apart their shapes are, the former place of each pair,
  // its kind and its place by kind.
  // In the broad phase the pairs as found, in buckets and sorted, and some 150 bytes a body for its trees.
  const double pair_bytes = 2.0 * static_cast<double>(row_bytes<PairRows>() + sizeof(PairClearance)) + 4 + 5;
  const double round_bytes = kRoundRows * static_cast<double>(row_bytes<ContactRows>());
  EXPECT_LE(held("contacts.pairs") + held("contacts.pairs_before") + held("narrow_phase"),
            kSlack * pairs() * pair_bytes + round_bytes + 65536);
  EXPECT_LE(held("broad_phase"), kSlack * (pairs() * (3 * sizeof(ShapePair) + 4) + 150.0 * kBodies));
}

TEST_F(SettledPile, TakesOneSolverLaneAndAFewNumbersPerContact) {
  const simd::Kernels& kernels = simd::widest_kernels();
  const double lane =
      static_cast<double>(kernels.contact.block_bytes[simd::contact_variant(2, false, false)]) /
      static_cast<double>(kernels.lanes);
  // Edge, key, lane order, list of uncolored constraints; for each body its colors, its energy and its place.
  EXPECT_LE(held("constraints"), kSlack * (contacts() * (lane + 24) + 48.0 * kBodies));
}

// Such bodies are all hubs, and no contact between hubs has a color.
TEST(BodiesInOnePlace, TakeAsMuchMemoryPerContactAsAPile) {
  Lab lab;
  constexpr int kBodies = 250;
  for (int i = 0; i < kBodies; ++i) {
    lab.add({.position = {0.001f * static_cast<float>(i % 7), 0.001f * static_cast<float>(i % 11), 0}},
            Box{{0.5f, 0.5f, 0.5f}});
  }
  lab.run(2);
  const auto contacts = static_cast<double>(lab.world.stats().contacts);
  EXPECT_EQ(contacts, kBodies * (kBodies - 1) / 2);
  const simd::Kernels& kernels = simd::widest_kernels();
  const double lane =
      static_cast<double>(kernels.contact.block_bytes[simd::contact_variant(2, false, false)]) /
      static_cast<double>(kernels.lanes);
  double held = 0.0;
  for_each_member_size(internals(lab.world),
                       [&](ColumnKind, const char* store, const char*, std::size_t, std::size_t bytes) {
                         if (std::string(store).rfind("constraints", 0) == 0)
                           held += static_cast<double>(bytes);
                       });
  // As for a pile, and in the overflow its edge before and after sorting by level, and its level.
  EXPECT_LE(held, kSlack * contacts * (lane + 24 + 12));
}

TEST(Sleepers, MemoryIsTheirPairsAndTheListsOfThem) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  for (int i = 0; i < 2500; ++i) {
    lab.add({.position = {static_cast<float>(i % 50), 0.5f, static_cast<float>(i / 50)}}, Box{});
  }
  lab.run(60);
  ASSERT_EQ(lab.world.stats().awake_bodies, 0);
  lab.run(1);
  const double pairs = static_cast<double>(internals(lab.world).contacts.resting.pair.size());
  EXPECT_GE(pairs, 4.0 * 2500 - 200);
  double held = 0.0;
  for_each_member_size(internals(lab.world),
                       [&](ColumnKind, const char* store, const char* name, std::size_t, std::size_t bytes) {
                         const std::string list = name;
                         if (std::string(store) == "contacts.resting" || list.rfind("resting", 0) == 0)
                           held += static_cast<double>(bytes);
                       });
  EXPECT_GE(held, pairs * (12 + sizeof(RestingLinks)));
  EXPECT_LE(held, kSlack * pairs * (12 + sizeof(RestingLinks)));  // no axes without hulls, no events
}

TEST_F(SettledPile, TakesLessThanAKilobytePerBodyBesideItsContacts) {
  EXPECT_LE(held("bodies") + held("shapes") + held("islands"), 1000.0 * kBodies);
}

}  // namespace
}  // namespace scree::physics
