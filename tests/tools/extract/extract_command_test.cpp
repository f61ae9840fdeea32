// Laws of `scree extract`, run as a program: NumPy reads its arrays, and bad options are refused.
#include <tests/run_program.h>
#include <tests/tools/recordings.h>

#include <nlohmann/json.hpp>
#include <string>

namespace {

using scree::testing::Outcome;
using scree::testing::read_file;

class ExtractCommand : public scree::testing::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    scree::testing::record_stack(recording(), 50);
  }
  Outcome scree(const std::string& arguments) { return run("'" SCREE_COMMAND "' " + arguments); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string recording() const { return path("stack.scree"); }

  void expect_refusal(const std::string& arguments, const std::string& reason) {
    const Outcome outcome = scree("extract " + recording() + " " + arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  }
};

TEST_F(ExtractCommand, WritesWhatNumpyReads) {
  const Outcome outcome = scree(
      "extract " + recording() +
      " --signal pose,contact_force,contacts,events --every 5 --quiet --json - --out " + path("stack.npz"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json figures = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(figures.at("samples"), 11);
  EXPECT_EQ(figures.at("bodies"), 7);  // five boxes, the floor, and a ball from the tenth step on
  const Outcome python =
      run("/usr/bin/python3 -c \"\nimport numpy\nf = numpy.load('" + path("stack.npz") +
          "')\nprint(sorted(f.files))\nprint(f['step'].tolist(), f['position'].shape, f['rotation'].dtype, "
          "f['contacts'].shape, f['event_kind'].dtype)\n"
          "print(numpy.isnan(f['position'][:, -1, 0]).tolist())\n"
          "print(numpy.isfinite(f['position'][-1]).all(), b'contact_begin' in f['event_kind'])\"");
  ASSERT_EQ(python.exit_code, 0) << python.err;
  EXPECT_EQ(
      python.out,
      "['body', 'contact_force', 'contacts', 'event_body_a', 'event_body_b', 'event_joint', 'event_kind', "
      "'event_shape_a', 'event_shape_b', 'event_step', 'event_time', 'event_value', 'position', 'rotation', "
      "'step', 'time']\n"
      "[0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50] (11, 7, 3) float32 (11,) |S16\n"
      "[True, True, False, False, False, False, False, False, False, False, False]\n"
      "True True\n");
}

TEST_F(ExtractCommand, WritesTables) {
  ASSERT_EQ(scree("extract " + recording() +
                  " --signal total_kinetic_energy --quiet --from 10 --to 20 --out " + path("e.csv"))
                .exit_code,
            0);
  const std::string table = read_file(folder_ / "e.csv");
  EXPECT_TRUE(table.starts_with("step,time,total_kinetic_energy\n10,0,")) << table;
}

TEST_F(ExtractCommand, RefusesWhatMakesNoSense) {
  const std::string output = " --quiet --out " + path("x.npz");
  expect_refusal("--signal charm" + output, "--signal charm: unknown signal; there are: position, rotation");
  expect_refusal("--signal pose --every 0" + output, "--every 0 must be at least 1");
  expect_refusal("--signal pose --from 60" + output, "--from 60 must be from 0 to 50");
  expect_refusal("--signal pose --from 9 --to 4" + output, "--from 9 must not be beyond --to 4");
  expect_refusal("--signal pose --bodies 3-" + output,
                 "--bodies 3-: expected all, or indices and spans of them");
  expect_refusal("--signal pose --bodies 7-3" + output, "--bodies 7-3: expected");
  expect_refusal("--signal pose --bodies 3,,4" + output, "--bodies 3,,4: expected");
  expect_refusal("--signal pose --bodies 99999999999" + output, "--bodies 99999999999: expected");
  expect_refusal("--signal pose,contacts --out " + path("x.csv"),
                 "position (of bodies), contacts (of the world) do not fit into one table");
  expect_refusal("--signal pose --every -1" + output, "--every: -1 must be at least 0");
  expect_refusal("--signal pose --out " + path("x.txt"), "must end in .npz or .csv");
  expect_refusal("--signal pose --out " + recording(), "stack.scree");
  expect_refusal("--out " + path("x.npz"), "--signal is required");
  const Outcome outcome = scree("extract " + path("none.scree") + " --signal pose" + output);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("none.scree"), std::string::npos) << outcome.err;
}

}  // namespace
