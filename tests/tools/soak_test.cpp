// Laws of the soak: valid worlds pass; a recording that no world repeats stops the soak, which names the
// file.
#include <tests/run_program.h>
#include <tests/tools/recordings.h>
#include <tools/soak_program/golden.h>
#include <tools/soak_program/mischief.h>
#include <tools/soak_program/plan.h>

#include <filesystem>
#include <fstream>

namespace scree::soak {
namespace {

TEST(SoakPlan, EverySceneOfTheCatalogHasSizesThatItsBuilderTakes) {
  for (const scenes::SceneInfo& info : scenes::catalog()) {
    scenes::Random random(1);
    for (int i = 0; i < 200; ++i) {
      EXPECT_NO_THROW(scenes::check(info.name, draw_parameters(info.name, random))) << info.name;
    }
  }
  scenes::Random random(1);
  EXPECT_THROW(draw_parameters("nowhere", random), Error);
}

TEST(SoakPlan, IsTheSameForTheSameSeed) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    scenes::Random left(seed), right(seed);
    const Plan a = draw_plan(left), b = draw_plan(right);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.steps, b.steps);
    EXPECT_EQ(a.dt, b.dt);
    EXPECT_EQ(left.next(), right.next());
  }
}

TEST(SoakMischief, MakesTheSameCallsForTheSameSeedAndLeavesWorldsThatStep) {
  const auto play = [](std::uint64_t seed) {
    const scenes::Scene scene = scenes::build("pile", {{"bodies", 30}}).front();
    World world(scene.settings);
    scenes::populate(world, scene);
    Workers workers(1);
    Mischief mischief(seed, 1);
    for (int i = 0; i < 150; ++i) {
      mischief.before_step(world);
      step(world, 1.0f / 60.0f, workers);
    }
    EXPECT_GT(mischief.calls(), 150);
    return world.hash();
  };
  const std::uint64_t expected = play(3);
  EXPECT_EQ(play(3), expected);
  EXPECT_NE(play(4), expected);
}

TEST(SoakGolden, TheMatrixCoversEveryBuiltInScene) {
  const std::vector<scenes::Golden> goldens = scenes::read_goldens(SCREE_SOAK_GOLDEN);
  for (const scenes::SceneInfo& info : scenes::catalog()) {
    EXPECT_TRUE(std::any_of(goldens.begin(), goldens.end(), [&](const scenes::Golden& golden) {
      return golden.what.scene == info.name;
    })) << info.name;
  }
  for (const scenes::Golden& golden : goldens) {
    EXPECT_NO_THROW(scenes::check(golden.what.scene, golden.what.parameters)) << golden;
    EXPECT_NE(golden.digest.all, 0u) << golden << " has no hash yet";
  }
}

#ifdef SCREE_SOAK
class SoakProgram : public scree::testing::ProgramTest {
 protected:
  scree::testing::Outcome soak(const std::string& arguments) {
    return run("'" SCREE_SOAK "' --keep '" + (folder_ / "keep").string() + "' " + arguments);
  }
  std::size_t kept() const {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_ / "keep")) ++count;
    return count;
  }
};

// Seeds of small scenes.
TEST_F(SoakProgram, RoundsPassAndNothingIsKept) {
  const scree::testing::Outcome outcome = soak("--minutes 10 --rounds 3 --seed 23");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  for (const char* text : {"seed 23: ", "seed 24: ", "seed 25: ", "the same everywhere", "3 rounds in "}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << "\n" << outcome.out;
  }
  EXPECT_EQ(kept(), 0u);
}

TEST_F(SoakProgram, TheLastRoundIsFinishedWhenTimeIsUp) {
  const scree::testing::Outcome outcome = soak("--minutes 0.0001 --seed 25");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("1 round in "), std::string::npos) << outcome.out;
}

TEST_F(SoakProgram, StopsAtARecordingThatDivergesAndNamesIt) {
  const std::string sound = (folder_ / "sound.scree").string(), broken = (folder_ / "broken.scree").string();
  testing::record_stack(sound, 60);
  testing::record_stack(broken, 60, {.step = 31});
  const scree::testing::Outcome outcome = soak("--minutes 1 --seed 7 " + sound + " " + broken);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find(sound + ": verified"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("DIFFERENT: " + broken), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("step 31 comes to hash"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("scree replay " + broken + " --verify --isa "), std::string::npos)
      << outcome.out;
  EXPECT_EQ(outcome.out.find("seed 7: "), std::string::npos) << "it went on\n" << outcome.out;
}

TEST_F(SoakProgram, StopsAtAFileThatIsNoRecordingAndNamesIt) {
  const std::string file = (folder_ / "text.scree").string();
  std::ofstream(file) << "no recording\n";
  const scree::testing::Outcome outcome = soak("--minutes 1 " + file);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("DIFFERENT: " + file), std::string::npos) << outcome.out;
}

TEST_F(SoakProgram, AWrongGoldenHashIsADifference) {
  const std::string file = (folder_ / "golden.txt").string();
  std::ofstream(file) << "# a comment stays\nstack bodies=3 30 0 0\n";
  const scree::testing::Outcome wrong = soak("--minutes 0 --golden --golden-file " + file);
  EXPECT_EQ(wrong.exit_code, 1) << wrong.out << wrong.err;
  EXPECT_NE(wrong.out.find("not with the golden hash in " + file), std::string::npos) << wrong.out;
  EXPECT_EQ(soak("--update-golden --golden-file " + file).exit_code, 0);
  EXPECT_EQ(scree::testing::read_file(file).rfind("# a comment stays\n", 0), 0u);
  const scree::testing::Outcome right = soak("--minutes 0 --golden --golden-file " + file);
  EXPECT_EQ(right.exit_code, 0) << right.out << right.err;
  EXPECT_NE(right.out.find("golden stack bodies=3: "), std::string::npos) << right.out;
}

TEST_F(SoakProgram, RefusesBadInputWithExitCodeTwo) {
  for (const char* arguments : {"--minutes -1", "--minutes nan", "--rounds -1", "--fly",
                                "--minutes 0 --golden --golden-file /no/such/file"}) {
    const scree::testing::Outcome outcome = soak(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << outcome.out;
  }
}
#endif

}  // namespace
}  // namespace scree::soak
