// Laws of golden files: reading returns the file's content, and writing changes only the hashes.
#include <tests/run_program.h>
#include <tools/scenes/golden_file.h>

#include <cstddef>

namespace scree::scenes {
namespace {

class GoldenFile : public scree::testing::ProgramTest {
 protected:
  std::string write(const std::string& text) {
    const std::filesystem::path path = folder_ / "golden.txt";
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
  void expect_refusal(const std::string& text, const std::string& reason) {
    const std::string file = write(text);
    try {
      read_goldens(file);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.what(), file + reason);
    }
  }
};

TEST_F(GoldenFile, HoldsRunsAndTheirHashes) {
  const std::vector<Golden> goldens = read_goldens(write(
      "# a comment\n\nslope angle=20.5,boxes=9  240 00000000000000ff 0000000000000010\nstack - 3 0 0\n"));
  ASSERT_EQ(goldens.size(), 2u);
  EXPECT_EQ(goldens[0].name(), "slope angle=20.5,boxes=9");
  EXPECT_EQ(goldens[0].what.parameters, (Parameters{{"angle", 20.5}, {"boxes", 9.0}}));
  EXPECT_EQ(goldens[0].what.steps, 240);
  EXPECT_EQ(goldens[0].digest, (RunHashes{255, 16}));
  EXPECT_EQ(goldens[1].name(), "stack -");
  EXPECT_TRUE(goldens[1].what.parameters.empty());
}

TEST_F(GoldenFile, KeepsEveryByteWhereTheHashesStayTheSame) {
  for (const char* original : {SCREE_SOAK_GOLDEN, SCREE_TEST_GOLDEN}) {
    const std::string before = scree::testing::read_file(original), file = write(before);
    const std::vector<Golden> goldens = read_goldens(file);
    EXPECT_GT(goldens.size(), 10u) << original;
    write_goldens(file, goldens);
    EXPECT_EQ(scree::testing::read_file(file), before) << original;
  }
}

TEST_F(GoldenFile, WritingReplacesOnlyTheHashes) {
  const std::string file =
      write("# 0 0 stays\nstack\tbodies=3   30 0 0  \n\nwall columns=1,rows=10 10 0 \t00\n");
  std::vector<Golden> goldens = read_goldens(file);
  ASSERT_EQ(goldens.size(), 2u);
  goldens[0].digest = {1, 2};
  goldens[1].digest = {0xfedcba9876543210u, 3};
  write_goldens(file, goldens);
  EXPECT_EQ(scree::testing::read_file(file),
            "# 0 0 stays\nstack\tbodies=3   30  0000000000000001  0000000000000002\n\n"
            "wall columns=1,rows=10 10  fedcba9876543210  0000000000000003\n");
}

TEST_F(GoldenFile, IsRefusedWithItsNameLineAndReason) {
  constexpr const char* kExpected =
      ": expected scene, parameters, steps and two hashes of 16 hexadecimal digits";
  for (const char* line : {"stack - 3 0", "stack - 3 0 0 0", "stack - three 0 0", "stack - 3 0 x"}) {
    expect_refusal(std::string("# comment\n") + line + "\n", std::string(":2") + kExpected);
  }
  expect_refusal("stack - 0 0 0\n", ":1: the number of steps must be positive");
  expect_refusal("stack bodies 3 0 0\n", ":1: 'bodies' is not key=number");
  expect_refusal("stack bodies=1x 3 0 0\n", ":1: 'bodies=1x' is not key=number");
  EXPECT_THROW(read_goldens((folder_ / "missing.txt").string()), Error);
}

}  // namespace
}  // namespace scree::scenes
