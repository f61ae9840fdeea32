// Laws of the command's handling of recordings, run as a program: output and exit codes.
#include <scree/workers.h>
#include <tests/run_program.h>
#include <tests/tools/recordings.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

namespace fs = std::filesystem;

using scree::testing::Outcome;
using scree::testing::read_file;
using scree::testing::record_stack;

class ReplayCommand : public scree::testing::ProgramTest {
 protected:
  Outcome scree(const std::string& arguments) { return run("'" SCREE_COMMAND "' " + arguments); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Parses what `--json -` prints; the exit code is for the caller to judge.
  nlohmann::json json_of(const std::string& arguments, int exit_code) {
    const Outcome outcome = scree(arguments + " --json -");
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << "\n" << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }

  void expect_refusal(const std::string& arguments, const std::string& reason) {
    const Outcome outcome = scree(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  }

  static void flip_a_byte(const std::string& file, std::uintmax_t offset) {
    std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
    stream.seekg(static_cast<std::streamoff>(offset));
    const int byte = stream.get();
    stream.seekp(static_cast<std::streamoff>(offset));
    stream.put(static_cast<char>(byte ^ 0x55));
    ASSERT_TRUE(stream.good());
  }

  std::string recorded_pile() {
    std::string file = path("pile.scree");
    const Outcome outcome = scree("run pile --set bodies=60 --steps 90 --threads 2 --record " + file +
                                  " --keyframes 25 --quiet --json " + path("run.json"));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return file;
  }
  nlohmann::json run_figures() const { return nlohmann::json::parse(read_file(folder_ / "run.json")); }
};

TEST_F(ReplayCommand, ARecordedRunVerifiesOnEveryBackendAndEndsInTheSameHash) {
  const std::string file = recorded_pile();
  const nlohmann::json run = run_figures();
  EXPECT_EQ(run.at("recording").at("file"), file);
  EXPECT_EQ(run.at("recording").at("steps"), 90);
  EXPECT_EQ(run.at("recording").at("bytes"), fs::file_size(file));
  for (const char* backend : {"", "--threads 1 --isa scalar", "--threads 3 --isa sse2", "--isa auto"}) {
    if (std::strstr(backend, "sse2") != nullptr && !scree::is_supported(scree::Isa::sse2)) continue;
    const nlohmann::json json = json_of("replay " + file + " --verify --quiet " + backend, 0);
    EXPECT_EQ(json.at("verified"), true) << backend;
    EXPECT_TRUE(json.at("divergence").is_null()) << backend;
    EXPECT_EQ(json.at("steps"), 90) << backend;
    EXPECT_GE(json.at("keyframes"), 3) << backend;
    EXPECT_EQ(json.at("hash"), run.at("hash")) << backend;
    EXPECT_EQ(json.at("recorded_hash"), run.at("hash")) << backend;
  }
}

TEST_F(ReplayCommand, RecordingChangesNoBit) {
  recorded_pile();
  const Outcome plain = scree("run pile --set bodies=60 --steps 90 --quiet --json -");
  EXPECT_EQ(nlohmann::json::parse(plain.out).at("hash"), run_figures().at("hash"));
}

TEST_F(ReplayCommand, PlaysWithoutVerifyingAndPrintsTimes) {
  const std::string file = recorded_pile();
  const nlohmann::json json = json_of("replay " + file + " --threads 2 --isa scalar", 0);
  EXPECT_EQ(json.at("isa"), "scalar");
  EXPECT_EQ(json.at("threads"), 2);
  EXPECT_EQ(json.at("verified"), false);
  EXPECT_EQ(json.at("steps"), 90);
  EXPECT_EQ(json.at("hash"), run_figures().at("hash"));
  for (const char* key : {"mean", "median", "min", "max"}) {
    EXPECT_GT(json.at("ms_per_step").at(key).get<double>(), 0.0) << key;
  }
  const Outcome table = scree("replay " + file);
  EXPECT_NE(table.out.find("the same"), std::string::npos) << table.out;
  EXPECT_NE(table.err.find(file + ": 100 %, step 90 of 90"), std::string::npos) << table.err;
}

TEST_F(ReplayCommand, PartsOfARecordingPlayAlone) {
  const std::string file = recorded_pile();
  const nlohmann::json whole = json_of("replay " + file + " --to 60 --quiet", 0);
  for (const char* from : {"0", "1", "24", "25", "26", "59"}) {
    const nlohmann::json part = json_of("replay " + file + " --verify --quiet --to 60 --from " + from, 0);
    EXPECT_EQ(part.at("from"), std::stoi(from));
    EXPECT_EQ(part.at("steps"), 60 - std::stoi(from));
    EXPECT_EQ(part.at("hash"), whole.at("hash"));
  }
  EXPECT_EQ(json_of("replay " + file + " --verify --from 60 --to 60 --quiet", 0).at("steps"), 0);
}

TEST_F(ReplayCommand, ADivergenceIsFoundAtItsStepBodyAndField) {
  const std::string file = path("tampered.scree");
  record_stack(file, 70, {.step = 33});
  const nlohmann::json json = json_of("replay " + file + " --verify --quiet --threads 2", 1);
  EXPECT_EQ(json.at("verified"), false);
  const nlohmann::json& divergence = json.at("divergence");
  EXPECT_EQ(divergence.at("step"), 33);
  EXPECT_NE(divergence.at("expected_hash"), divergence.at("actual_hash"));
  EXPECT_EQ(divergence.at("compared_at"), 40);  // the next keyframe
  EXPECT_EQ(divergence.at("difference").get<std::string>().rfind("body ", 0), 0u) << divergence;
  const Outcome table = scree("replay " + file + " --verify --quiet");
  EXPECT_EQ(table.exit_code, 1);
  EXPECT_NE(table.out.find("first in step 33"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("at step 40: body "), std::string::npos) << table.out;
  // The recording is valid before this step and after the next keyframe.
  EXPECT_EQ(scree("replay " + file + " --verify --quiet --to 32").exit_code, 0);
  EXPECT_EQ(scree("replay " + file + " --verify --quiet --from 40").exit_code, 0);
  const Outcome played = scree("replay " + file + " --quiet --to 35");
  EXPECT_EQ(played.exit_code, 0);
  EXPECT_NE(played.out.find("DIFFERENT"), std::string::npos) << played.out;
}

TEST_F(ReplayCommand, InfoPrintsTheContentOfARecording) {
  const std::string file = path("stack.scree");
  record_stack(file, 50);
  const nlohmann::json json = json_of("info " + file, 0);
  EXPECT_EQ(json.at("finished"), true);
  EXPECT_EQ(json.at("first_step"), 0);
  EXPECT_EQ(json.at("last_step"), 50);
  EXPECT_EQ(json.at("calls"), 2);  // the ball and its shape
  EXPECT_EQ(json.at("keyframes"), json.at("keyframe_steps").size());
  EXPECT_EQ(json.at("keyframe_steps").front(), 0);
  EXPECT_EQ(json.at("keyframe_steps").back(), 50);
  EXPECT_EQ(json.at("first_state").at("bodies"), 6);
  EXPECT_EQ(json.at("last_keyframe").at("bodies"), 7);
  EXPECT_EQ(json.at("file_bytes"), fs::file_size(file));
  EXPECT_GT(json.at("raw_bytes").get<std::uint64_t>(), json.at("file_bytes").get<std::uint64_t>());
  EXPECT_EQ(json.at("lost_bytes"), 0);
  const Outcome table = scree("info " + file);
  EXPECT_EQ(table.exit_code, 0);
  for (const char* text : {"format", "written by", "finished", "steps", "calls", "keyframes", "file"}) {
    EXPECT_NE(table.out.find(text), std::string::npos) << text;
  }
}

TEST_F(ReplayCommand, ARecordingThatWasCutOffPlaysToItsLastWholeStep) {
  const std::string file = path("stack.scree");
  record_stack(file, 400);
  fs::resize_file(file, fs::file_size(file) * 3 / 4);
  const nlohmann::json info = json_of("info " + file, 0);
  EXPECT_EQ(info.at("finished"), false);
  EXPECT_LT(info.at("last_step"), 400);
  EXPECT_EQ(scree("replay " + file + " --verify --quiet").exit_code, 0);
  EXPECT_NE(scree("info " + file).out.find("did not come to the end"), std::string::npos);
}

TEST_F(ReplayCommand, ADiskThatFillsUpEndsTheRunAndLeavesARecordingThatPlays) {
  const std::string file = path("full.scree");
  const Outcome outcome = run("trap '' XFSZ; ulimit -f 200; '" SCREE_COMMAND
                              "' run pile --set bodies=300 --steps 5000 --keyframes 5 --quiet --record " +
                              file);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find(file + ": cannot be written"), std::string::npos) << outcome.err;
  EXPECT_LE(fs::file_size(file), 200u * 1024);
  const nlohmann::json json = json_of("replay " + file + " --verify --quiet", 0);
  EXPECT_LT(json.at("steps"), 5000);
}

TEST_F(ReplayCommand, DiffShowsWhereTwoRecordingsDiverge) {
  const std::string a = path("a.scree"), b = path("b.scree"), c = path("c.scree"), longer = path("d.scree");
  record_stack(a, 60);
  record_stack(b, 60);
  record_stack(c, 60, {}, -10.5f);
  record_stack(longer, 80);
  const nlohmann::json same = json_of("diff " + a + " " + b, 0);
  EXPECT_EQ(same.at("same"), true);
  EXPECT_TRUE(same.at("divergence").is_null());
  EXPECT_EQ(same.at("to"), 60);
  EXPECT_NE(scree("diff " + a + " " + b).out.find("same"), std::string::npos);
  // They agree as far as both go.
  EXPECT_EQ(json_of("diff " + a + " " + longer, 0).at("to"), 60);
  const nlohmann::json parted = json_of("diff " + a + " " + c + " --threads 2", 1);
  EXPECT_EQ(parted.at("same"), false);
  EXPECT_EQ(parted.at("divergence").at("step"), 10);  // with the ball
  EXPECT_NE(parted.at("divergence").at("difference").get<std::string>().find("body 10"), std::string::npos)
      << parted;
  const Outcome table = scree("diff " + a + " " + c);
  EXPECT_EQ(table.exit_code, 1);
  EXPECT_NE(table.out.find("first in step 10"), std::string::npos) << table.out;
}

TEST_F(ReplayCommand, DiffShowsStatesThatNoStepHashShows) {
  const std::string a = path("a.scree"), b = path("b.scree");
  for (const std::string& file : {a, b}) {
    scree::World world(scree::WorldSettings{.sleep_time = file == a ? 0.5f : 3.0f});
    world.add_shape(world.create_body({.position = {0, 9, 0}}), scree::Sphere{0.5f});
    scree::Workers workers(1);
    scree::Recorder recorder(world, file);
    for (int i = 0; i < 10; ++i) scree::step(world, 1.0f / 60.0f, workers);
    recorder.finish();
  }
  const nlohmann::json json = json_of("diff " + a + " " + b, 1);
  EXPECT_EQ(json.at("same"), false);
  EXPECT_EQ(json.at("divergence").at("step"), 0);
  EXPECT_NE(json.at("divergence").at("hash_a"), json.at("divergence").at("hash_b"));
  EXPECT_NE(json.at("divergence").at("difference").get<std::string>().find("world.settings"),
            std::string::npos);
  const Outcome table = scree("diff " + a + " " + b);
  EXPECT_EQ(table.exit_code, 1);
  EXPECT_NE(table.out.find("world.settings"), std::string::npos) << table.out;
}

TEST_F(ReplayCommand, RefusesWhatCannotBePlayedWithExitCodeTwo) {
  const std::string file = path("stack.scree");
  record_stack(file, 30);
  const std::string missing = path("missing.scree");
  for (const char* verb : {"replay ", "info "}) expect_refusal(verb + missing, missing);
  expect_refusal("diff " + file + " " + missing, missing);
  expect_refusal("replay", "FILE");
  expect_refusal("diff " + file, "B");
  expect_refusal("replay " + file + " --from 31",
                 "--from 31 must be from 0 to 30, the steps of the recording");
  expect_refusal("replay " + file + " --to 31", "--to 31 must be from 0 to 30");
  expect_refusal("replay " + file + " --from 20 --to 10", "--from 20 must not be beyond --to 10");
  expect_refusal("replay " + file + " --from -1", "--from");
  expect_refusal("replay " + file + " --isa mmx", "--isa mmx: unknown instruction set");
  expect_refusal("replay " + file + " --threads 5000", "--threads 5000 must be from 0 to 1024");
  expect_refusal("replay " + file + " --json /no/such/folder/x.json", "cannot be written");
}

TEST_F(ReplayCommand, NamesFileAndReasonOfAnInvalidRecording) {
  const std::string empty = path("empty.scree"), text = path("text.scree"), changed = path("changed.scree");
  std::ofstream(empty).close();
  std::ofstream(text) << "This is no recording, but it is long enough to be one, were it one.\n";
  record_stack(changed, 30);
  flip_a_byte(changed, 200);
  for (const std::string& file : {empty, text, changed}) {
    for (const char* verb : {"replay --verify ", "info "}) expect_refusal(verb + file, file);
  }
  // Far after the beginning: the error appears only when this part is played.
  const std::string late = path("late.scree");
  record_stack(late, 60);
  flip_a_byte(late, fs::file_size(late) * 4 / 5);
  expect_refusal("replay --quiet --verify " + late, late + ": Player: byte ");
}

}  // namespace
