// Feeds the corpus of fuzzing, and the inputs that once broke a law, to their targets in every build.
#include <gtest/gtest.h>
#include <scree/recording.h>
#include <scree/scree.h>
#include <tests/fuzz/laws.h>
#include <tests/fuzz/memory_watch.h>
#include <tests/fuzz/targets.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

namespace scree::fuzz {
namespace {

namespace fs = std::filesystem;

// Throws for a folder that does not exist: a law about no files would hold.
std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> inputs_of(const Target& target) {
  std::vector<fs::path> files = files_of(fs::path(SCREE_FUZZ_FOLDER) / "corpus" / target.name);
  const fs::path regressions = fs::path(SCREE_FUZZ_FOLDER) / "regressions" / target.name;
  if (!fs::is_directory(regressions)) return files;  // nothing has been found yet
  const std::vector<fs::path> mended = files_of(regressions);
  files.insert(files.end(), mended.begin(), mended.end());
  return files;
}

std::string read_file(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

Input input_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

class Corpus : public ::testing::TestWithParam<Target> {};

TEST_P(Corpus, SatisfiesTheLaws) {
  int inputs = 0;
  for (const fs::path& file : inputs_of(GetParam())) {
    EXPECT_NO_THROW(GetParam().run(input_of(read_file(file)))) << file;
    ++inputs;
  }
  EXPECT_GT(inputs, 5) << "of " << GetParam().name;
}

// Half of a file, and a file with extra bytes at its end, as any disk may produce.
TEST_P(Corpus, SatisfiesTheLawsAlsoTruncatedOrExtended) {
  for (const fs::path& file : inputs_of(GetParam())) {
    const std::string whole = read_file(file);
    EXPECT_NO_THROW(GetParam().run(input_of(whole.substr(0, whole.size() / 2)))) << file;
    EXPECT_NO_THROW(GetParam().run(input_of(whole + "0"))) << file;
  }
}

std::string target_name(const ::testing::TestParamInfo<Target>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Targets, Corpus, ::testing::ValuesIn(kTargets), target_name);

TEST(CorpusFiles, AreSmallAndDistinct) {
  constexpr std::size_t kMostBytes = 200 << 10;
  std::size_t bytes = 0;
  for (const Target& target : kTargets) {
    std::map<std::string, fs::path> seen;
    for (const fs::path& file : inputs_of(target)) {
      const std::string content = read_file(file);
      bytes += content.size();
      const auto [other, is_new] = seen.emplace(content, file);
      EXPECT_TRUE(is_new) << file << " is " << other->second;
    }
  }
  EXPECT_LT(bytes, kMostBytes);
}

TEST(CorpusFiles, AreReadWithTheirOriginalContent) {
  for (const fs::path& file : files_of(fs::path(SCREE_FUZZ_FOLDER) / "corpus" / "snapshot")) {
    const std::string content = read_file(file);
    EXPECT_NO_THROW(read_snapshot(std::as_bytes(input_of(content))))
        << file << ": the format has changed; run scree_make_corpus " SCREE_FUZZ_FOLDER "/corpus";
  }
}

TEST(CorpusFiles, RecordingsStillVerify) {
  for (const fs::path& file : files_of(fs::path(SCREE_FUZZ_FOLDER) / "corpus" / "recording")) {
    Player player(file.string());
    const RecordingInfo info = player.info();
    EXPECT_GT(info.last_step, info.first_step) << file;
    EXPECT_FALSE(player.verify(info.first_step, info.last_step, wide_workers()))
        << file << ": results have changed; run scree_make_corpus " SCREE_FUZZ_FOLDER "/corpus";
  }
}

TEST(CorpusFiles, ExampleScenesSatisfyTheLaws) {
  for (const fs::path& file : files_of(SCREE_EXAMPLES)) {
    EXPECT_NO_THROW(scene_target(input_of(read_file(file)))) << file;
  }
}

TEST(Laws, OffsetsAreFoundInErrors) {
  EXPECT_TRUE(names_offset("read: byte 12: it ends", "read: byte ", ": ", 12));
  EXPECT_FALSE(names_offset("read: byte 13: it ends", "read: byte ", ": ", 12)) << "behind the end";
  EXPECT_FALSE(names_offset("read: byte : it ends", "read: byte ", ": ", 12));
  EXPECT_FALSE(names_offset("read: byte 12: ", "read: byte ", ": ", 12)) << "no reason";
  EXPECT_FALSE(names_offset("read: byte 99999999999999999999999: x", "read: byte ", ": ", 12));
  EXPECT_FALSE(names_offset("write: byte 12: it ends", "read: byte ", ": ", 12));
}

#if defined(SCREE_SANITIZED)  // only sanitizers report every allocation
TEST(Laws, TooMuchMemoryIsDetected) {
  ASSERT_TRUE(memory_is_watched());
  const MemoryWatch watch;
  EXPECT_EQ(watch.peak(), 0u);
  { const std::vector<char> some(300000), others(200000); }
  { const std::vector<char> more(400000); }
  EXPECT_GE(watch.peak(), 500000u);
  EXPECT_LT(watch.peak(), 600000u);
  EXPECT_NO_THROW(watch.require_within({500000, 100}, 1000, "the test"));
  EXPECT_THROW(watch.require_within({100000, 100}, 1000, "the test"), BrokenLaw);
}
#endif

}  // namespace
}  // namespace scree::fuzz
