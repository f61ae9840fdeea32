// Laws of `scree export`, run as a program.
#include <tests/run_program.h>
#include <tests/tools/recordings.h>

#include <nlohmann/json.hpp>
#include <string>

namespace {

using scree::testing::Outcome;
using scree::testing::read_file;

class ExportCommand : public scree::testing::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    scree::testing::record_stack(path("stack.scree"), 50);
  }
  Outcome scree(const std::string& arguments) { return run("'" SCREE_COMMAND "' export " + arguments); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
};

TEST_F(ExportCommand, WritesAnimationsOfEachFormat) {
  for (const auto& [name, beginning] :
       {std::pair{"a.gltf", "{\"asset\""}, {"a.glb", "glTF"}, {"a.mcap", "\x89MCAP0"}}) {
    const Outcome outcome =
        scree(path("stack.scree") + " --every 5 --to 40 --quiet --json - --out " + path(name));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const nlohmann::json figures = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(figures.at("samples"), 9);
    EXPECT_EQ(figures.at("bodies"), 7);
    const std::string bytes = read_file(folder_ / name);
    EXPECT_EQ(figures.at("output").at("bytes"), bytes.size());
    EXPECT_TRUE(bytes.starts_with(beginning)) << name;
  }
}

TEST_F(ExportCommand, RefusesWhatMakesNoSense) {
  const auto expect_refusal = [&](const std::string& arguments, const std::string& reason) {
    const Outcome outcome = scree(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  };
  expect_refusal(path("stack.scree") + " --out " + path("a.obj"), "must end in .html, .gltf, .glb or .mcap");
  expect_refusal(path("stack.scree") + " --every 0 --out " + path("a.glb"), "--every 0 must be at least 1");
  expect_refusal(path("stack.scree") + " --to 51 --out " + path("a.glb"), "--to 51 must be from 0 to 50");
  expect_refusal(path("none.scree") + " --out " + path("a.glb"), "none.scree");
  expect_refusal(path("stack.scree") + " --out " + path("nowhere/a.glb"), "nowhere");
}

}  // namespace
