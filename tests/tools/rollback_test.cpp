// Laws of rollback networking, held by the example: late, lost and reordered packets cost time, never a bit.
#include <gtest/gtest.h>
#include <tests/run_program.h>
#include <tools/rollback/session.h>

#include <algorithm>
#include <string>

namespace scree::rollback {
namespace {

SessionOptions small_session(int delay, int jitter, double loss, std::uint64_t seed) {
  SessionOptions options;
  options.steps = 240;
  options.boxes = 40;
  options.threads = 2;
  options.link = {.delay = delay, .jitter = jitter, .loss = loss, .seed = seed};
  return options;
}

std::string name_of(const LinkOptions& link) {
  return "delay " + std::to_string(link.delay) + ", jitter " + std::to_string(link.jitter) + ", loss " +
         std::to_string(link.loss) + ", seed " + std::to_string(link.seed);
}

TEST(Rollback, BothPeersEndInTheStateOfARunWithAllInputsKnown) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    for (const double loss : {0.0, 20.0, 50.0}) {
      for (const int delay : {0, 1, 5, kWindow}) {
        const SessionOptions options = small_session(delay, static_cast<int>(seed) - 1, loss, seed);
        const SessionReport report = run_session(options);
        const std::string name = name_of(options.link);
        EXPECT_TRUE(report.is_sound()) << name;
        EXPECT_EQ(report.first_difference, -1) << name;
        for (std::size_t peer = 0; peer < kPlayers; ++peer) {
          EXPECT_EQ(report.hashes[peer], report.expected_hash) << name;
          EXPECT_EQ(report.peers[peer].step.count, options.steps) << name;
          EXPECT_LE(report.peers[peer].longest_rollback, kWindow) << name;
          EXPECT_GT(report.peers[peer].hashes_compared, 0) << name;
          EXPECT_TRUE(delay <= 1 || report.peers[peer].rollbacks > 0) << name;
        }
      }
    }
  }
}

TEST(Rollback, ALinkAsSlowAsTheWindowRollsBackTheWholeWindow) {
  const SessionReport report = run_session(small_session(kWindow, 4, 30.0, 5));
  EXPECT_TRUE(report.is_sound());
  EXPECT_EQ(std::max(report.peers[0].longest_rollback, report.peers[1].longest_rollback), kWindow);
}

TEST(Rollback, ALinkWithinTheWindowStallsNoPeer) {
  for (const int delay : {0, 6, kWindow}) {
    const SessionOptions options = small_session(delay, 0, 0.0, 4);
    const SessionReport report = run_session(options);
    for (const PeerFigures& peer : report.peers) EXPECT_EQ(peer.stalls, 0) << delay;
    // The last input must arrive; without delay, after the tick of the peer that ticks first.
    EXPECT_EQ(report.ticks, options.steps + std::max(delay, 1));
  }
}

TEST(Rollback, PeersStallWhereTheLinkIsSlowerThanTheWindowAndEndInTheSameState) {
  const SessionReport report = run_session(small_session(3 * kWindow, 3, 10.0, 6));
  EXPECT_TRUE(report.is_sound());
  for (const PeerFigures& peer : report.peers) EXPECT_GT(peer.stalls, 0);
}

TEST(Rollback, SavesBeforeEveryStepAndRestoresOncePerRollback) {
  const SessionReport report = run_session(small_session(5, 2, 20.0, 7));
  for (const PeerFigures& peer : report.peers) {
    EXPECT_EQ(peer.save.count, peer.step.count + peer.resimulated_step.count);
    EXPECT_EQ(peer.restore.count, peer.rollbacks);
    EXPECT_GE(peer.resimulated_step.count, peer.rollbacks);
    EXPECT_GT(peer.window_bytes, 0u);
  }
}

// Without this law the others would hold for a game that ignores its inputs.
TEST(Rollback, OneInputThatIsPredictedWrongAndNotCorrectedChangesTheHash) {
  Workers workers(1);
  Hands left(1), right(2);
  std::vector<Inputs> inputs;
  for (int i = 0; i < 120; ++i) inputs.push_back({left.next(), right.next()});
  const std::vector<std::uint64_t> expected = play_with_perfect_knowledge(40, inputs, workers);
  for (const std::size_t step : {0u, 60u, 119u}) {
    std::vector<Inputs> wrong = inputs;
    wrong[step][1].right = static_cast<std::int8_t>(wrong[step][1].right == 1 ? 0 : 1);
    const std::vector<std::uint64_t> actual = play_with_perfect_knowledge(40, wrong, workers);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(actual[i] == expected[i], i <= step) << "input " << step << ", state " << i;
    }
  }
}

TEST(Link, DelaysLosesAndReordersAsItsOptionsSay) {
  Link link(LinkOptions{.delay = 3, .jitter = 4, .loss = 25.0, .seed = 9});
  constexpr int kPackets = 4000;
  int received = 0, latest = -1;
  bool overtaken = false;
  for (int tick = 0; tick < kPackets + 10; ++tick) {
    for (const Packet& packet : link.receive(tick)) {
      EXPECT_GE(tick - packet.received, 3);
      EXPECT_LE(tick - packet.received, 3 + 4);
      if (packet.received < latest) overtaken = true;
      latest = std::max(latest, packet.received);
      ++received;
    }
    Packet packet;
    packet.received = tick;  // says when it was sent
    if (tick < kPackets) link.send(tick, packet);
  }
  EXPECT_EQ(link.sent(), kPackets);
  EXPECT_EQ(received, kPackets - link.lost());
  EXPECT_NEAR(static_cast<double>(link.lost()) / kPackets, 0.25, 0.03);
  EXPECT_TRUE(overtaken);
}

TEST(Session, RefusesOptionsOutsideTheirRanges) {
  const auto refuses = [](auto change, const std::string& reason) {
    SessionOptions options;
    change(options);
    try {
      run_session(options);
      ADD_FAILURE() << reason;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
    }
  };
  refuses([](SessionOptions& o) { o.steps = 0; }, "--steps 0 must be from 1 to 1000000");
  refuses([](SessionOptions& o) { o.boxes = -1; }, "--bodies -1 must be from 0 to 20000");
  refuses([](SessionOptions& o) { o.link.delay = -1; }, "--delay -1 must be from 0 to 1000");
  refuses([](SessionOptions& o) { o.link.jitter = 1001; }, "--jitter 1001 must be from 0 to 1000");
  refuses([](SessionOptions& o) { o.link.loss = 99.5; }, "--loss 99.5 must be from 0 to 95");
  refuses([](SessionOptions& o) { o.threads = -2; }, "--threads -2 must be from 0 to 1024");
}

#ifdef SCREE_ROLLBACK
class RollbackProgram : public scree::testing::ProgramTest {};

TEST_F(RollbackProgram, PrintsWhatItTookAndEndsWithZeroIfAllAgree) {
  const scree::testing::Outcome outcome =
      run("'" SCREE_ROLLBACK "' --steps 120 --bodies 30 --delay 6 --jitter 3 --loss 25 --seed 3 --threads 2");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* text :
       {"rollbacks", "stalled", "re-simulated step", "save", "restore", "ms mean", "hash", "all agree"}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << "\n" << outcome.out;
  }
}

TEST_F(RollbackProgram, RefusesBadInputWithExitCodeTwo) {
  for (const char* arguments : {"--steps 0", "--loss 100", "--delay many", "--fly"}) {
    const scree::testing::Outcome outcome = run("'" SCREE_ROLLBACK "' " + std::string(arguments));
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_FALSE(outcome.err.empty()) << arguments;
  }
}
#endif

}  // namespace
}  // namespace scree::rollback
