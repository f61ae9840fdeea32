// Laws of `scree render` and `scree run --picture`, run as a program: which files come, with what in them.
#include <tests/run_program.h>
#include <tests/tools/recordings.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

using scree::testing::Outcome;
using scree::testing::read_file;

class RenderCommand : public scree::testing::ProgramTest {
 protected:
  // Without ffmpeg, whatever is installed.
  Outcome scree(const std::string& arguments) {
    return run("PATH='" + path("programs") + "' '" SCREE_COMMAND "' " + arguments);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string picture(const std::string& name) const { return read_file(folder_ / name); }

  void expect_refusal(const std::string& arguments, const std::string& reason) {
    const Outcome outcome = scree(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
    for (const fs::directory_entry& file : fs::directory_iterator(folder_))
      EXPECT_FALSE(file.path().extension() == ".png" && file.file_size() > 0) << arguments;
  }

  // A program that stands for ffmpeg: it keeps what it reads in the file that is its last argument.
  void install_ffmpeg(const std::string& script) {
    fs::create_directories(folder_ / "programs");
    const fs::path file = folder_ / "programs" / "ffmpeg";
    std::ofstream(file) << "#!/bin/sh\nPATH=/usr/bin:/bin\n" << script;
    fs::permissions(file, fs::perms::owner_all);
  }
};

bool is_png(const std::string& bytes) { return bytes.starts_with("\x89PNG\r\n\x1a\n"); }

TEST_F(RenderCommand, DrawsAStepOfASceneAndOfItsRecordingAlike) {
  ASSERT_EQ(scree("run pile --set bodies=40 --steps 60 --keyframes 25 --quiet --record " +
                  path("pile.scree") + " --picture " + path("end.png") + " --size 160x90")
                .exit_code,
            0);
  ASSERT_TRUE(is_png(picture("end.png")));
  for (const char* const step : {"0", "31", "60"}) {
    const std::string options =
        std::string(" --quiet --size 160x90 --camera 8,6,9,0,1,0 --at ") + step + " --out ";
    ASSERT_EQ(scree("render pile --set bodies=40" + options + path("scene.png")).exit_code, 0);
    ASSERT_EQ(scree("render " + path("pile.scree") + options + path("recording.png")).exit_code, 0);
    EXPECT_TRUE(is_png(picture("scene.png")));
    EXPECT_EQ(picture("scene.png"), picture("recording.png")) << step;
  }
  ASSERT_EQ(
      scree("render " + path("pile.scree") + " --quiet --size 160x90 --out " + path("last.png")).exit_code,
      0);
  EXPECT_EQ(picture("last.png"), picture("end.png"));
}

TEST_F(RenderCommand, SaysWhatItDrew) {
  const Outcome outcome = scree(
      "render stack --set bodies=3 --at 5 --quiet --size 64x48 --view 60 --json - --out " + path("a.png"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json figures = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(figures.at("pictures"), 1);
  EXPECT_EQ(figures.at("last").at("step"), 5);
  EXPECT_EQ(figures.at("last").at("file"), path("a.png"));
  EXPECT_EQ(figures.at("width"), 64);
  EXPECT_EQ(figures.at("height"), 48);
  EXPECT_EQ(figures.at("camera").at("view"), 60.0);
  EXPECT_TRUE(figures.at("film").is_null());
  EXPECT_GT(figures.at("rays"), 64 * 48);
  EXPECT_NE(outcome.err.find("64 x 48 pixels"), std::string::npos) << outcome.err;
}

TEST_F(RenderCommand, SeriesAreNumberedByStep) {
  const Outcome outcome = scree(
      "render stack --set bodies=3 --every 20 --from 10 --to 55 --quiet --size 64x48 --out " + path("s.png"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::vector<std::string> names;
  for (const fs::directory_entry& file : fs::directory_iterator(folder_)) {
    if (file.path().extension() == ".png") names.push_back(file.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"s-000010.png", "s-000030.png", "s-000050.png"}));
  EXPECT_NE(outcome.out.find("none: ffmpeg is not installed"), std::string::npos) << outcome.out;
  // The camera stands still.
  ASSERT_EQ(
      scree("render stack --set bodies=3 --at 10 --quiet --size 64x48 --out " + path("t.png")).exit_code, 0);
  EXPECT_EQ(picture("t.png"), picture("s-000010.png"));
}

TEST_F(RenderCommand, SeriesHaveNoPictureBeyondTheirEnd) {
  ASSERT_EQ(
      scree("render stack --set bodies=3 --every 18446744073709551615 --from 5 --quiet --size 64x48 --out " +
            path("s.png"))
          .exit_code,
      0);
  EXPECT_TRUE(is_png(picture("s-000005.png")));
  EXPECT_FALSE(fs::exists(folder_ / "s-000004.png"));
}

TEST_F(RenderCommand, TakesTheCameraThatItTells) {
  const std::string options = "render stack --set bodies=3 --at 5 --quiet --size 64x48 --view 33 --out ";
  const Outcome outcome = scree(options + path("a.png"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::size_t row = outcome.out.find("camera"), end = outcome.out.find(", view", row);
  const std::size_t begin = outcome.out.find_first_of("-0123456789", row);
  ASSERT_EQ(scree(options + path("b.png") + " --camera=" + outcome.out.substr(begin, end - begin)).exit_code,
            0);
  EXPECT_EQ(picture("a.png"), picture("b.png"));
}

TEST_F(RenderCommand, ReadsScenesFromPipes) {
  const std::string scene = SCREE_EXAMPLES "/dominoes.json";
  const Outcome outcome =
      run("cat '" + scene + "' | '" SCREE_COMMAND "' render /dev/fd/3 --at 1 --quiet --size 64x48 --out " +
          path("p.png") + " 3<&0");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(RenderCommand, FilmsHaveThePicturesInOrder) {
  install_ffmpeg("for last; do :; done\nexec cat > \"${last#file:}\"\n");
  ASSERT_EQ(scree("render stack --set bodies=3 --every 5 --to 10 --quiet --size 64x48 --out " + path("s.png"))
                .exit_code,
            0);
  EXPECT_EQ(picture("s.mp4"), picture("s-000000.png") + picture("s-000005.png") + picture("s-000010.png"));
}

TEST_F(RenderCommand, FailsWithFfmpegsStatus) {
  install_ffmpeg("cat > /dev/null\necho 'no such codec' >&2\nexit 7\n");
  const Outcome late =
      scree("render stack --set bodies=3 --every 5 --to 10 --quiet --size 64x48 --out " + path("s.png"));
  EXPECT_EQ(late.exit_code, 1);
  EXPECT_NE(late.err.find("no such codec"), std::string::npos) << late.err;
  EXPECT_NE(late.err.find("s.mp4: ffmpeg: it ended with status 7"), std::string::npos) << late.err;
  EXPECT_TRUE(is_png(picture("s-000010.png")));
  install_ffmpeg("exit 3\n");  // its end of the line is gone: no signal kills the command
  const Outcome early =
      scree("render stack --set bodies=3 --every 1 --to 40 --quiet --size 64x48 --out " + path("s.png"));
  EXPECT_EQ(early.exit_code, 1);
  EXPECT_NE(early.err.find("s.mp4: ffmpeg: "), std::string::npos) << early.err;
}

TEST_F(RenderCommand, RefusesWhatItCannotDraw) {
  const std::string stack = "render stack --set bodies=3 --quiet --out " + path("p.png");
  expect_refusal(stack + " --size 64", "--size 64: expected WIDTHxHEIGHT");
  expect_refusal(stack + " --size 64x", "expected WIDTHxHEIGHT");
  expect_refusal(stack + " --size 64x-48", "--size 64x-48: -48 must be from 16 to 16384");
  expect_refusal(stack + " --size 16384x16384", "at most 33554432 pixels");
  expect_refusal(stack + " --camera 1,2", "--camera 1,2: expected corner, front, side, top");
  expect_refusal(stack + " --camera nan,0,0", "must be within +-1e7 m");
  expect_refusal(stack + " --camera 1,2,3,1,2,3", "the eye is where its target is");
  expect_refusal(stack + " --camera 0,0,0,1e-30,0,0", "the eye is where its target is");
  expect_refusal(stack + " --camera 2e7,0,0", "must be within +-1e7 m");
  expect_refusal(stack + " --every -1", "--every: -1 must be at least 0");
  expect_refusal(stack + " --at -5", "--at: -5 must be at least 0");
  expect_refusal("render stack --out " + path(".png"), "must end in .png");
  expect_refusal("run stack --picture " + path("p.jpg"),
                 "--picture " + path("p.jpg") + ": the name of the file must");
  expect_refusal("render " + std::string(300, 'x') + " --out " + path("p.png"), "unknown scene");
  expect_refusal(stack + " --view 180", "--view 180 must be from 1 to 170 degrees");
  expect_refusal(stack + " --color-by charm", "unknown quantity; there are: body, part, speed, sleep, type");
  expect_refusal(stack + " --at 5 --every 2", "--at is for one picture");
  expect_refusal(stack + " --from 3", "--from and --to say nothing without --every");
  expect_refusal(stack + " --rate 30", "--rate says nothing without --every");
  expect_refusal(stack + " --every 0", "--every 0 must be at least 1");
  expect_refusal(stack + " --every 1 --rate 0", "--rate 0 must be from 1 to 1000");
  expect_refusal(stack + " --every 1 --from 9 --to 3", "--from 9 must not be beyond --to 3");
  expect_refusal(stack + " --every 1 --to 1000000", "more than 100000 pictures");
  expect_refusal(stack + " --at 1000000001", "--at 1000000001 must be from 0 to 1000000000");
  expect_refusal("render stack --out " + path("p.jpg"), "the name of the file must end in .png");
  expect_refusal("render stack", "--out is required");
  expect_refusal("render no_such_scene --out " + path("p.png"), "no_such_scene");
  expect_refusal("run stack --size 64x48", "--size requires --picture");
  expect_refusal("run stack --picture " + path("p.png") + " --size 1x1", "--size 1x1: 1 must be from 16");
}

TEST_F(RenderCommand, RefusesRecordingsThatItCannotPlay) {
  scree::testing::record_stack(path("stack.scree"), 30);
  expect_refusal("render " + path("stack.scree") + " --at 31 --out " + path("p.png"),
                 "--at 31 must be from 0 to 30");
  expect_refusal("render " + path("stack.scree") + " --set bodies=3 --out " + path("p.png"),
                 "--set bodies: a recording has no parameters");
  std::ofstream(path("empty.scree"));
  expect_refusal("render " + path("empty.scree") + " --out " + path("p.png"), path("empty.scree") + ": ");
  std::ofstream(path("prose.txt")) << "no recording";
  expect_refusal("render " + path("prose.txt") + " --out " + path("p.png"), path("prose.txt"));
}

TEST_F(RenderCommand, ReplacesNoInput) {
  const std::string source = path("s-000004.png");  // a recording in spite of its name
  scree::testing::record_stack(source, 8);
  const std::string before = read_file(source);
  const Outcome outcome =
      scree("render " + source + " --every 2 --quiet --size 64x48 --out " + path("s.png"));
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_EQ(read_file(source), before);
  const Outcome same = scree("render " + source + " --quiet --out " + source);
  EXPECT_EQ(same.exit_code, 2) << same.err;
  EXPECT_EQ(read_file(source), before);
}

}  // namespace
