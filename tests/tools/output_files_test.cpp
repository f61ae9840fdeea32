// Laws of output files: writing destroys no input and no other output, old content stays until new content
// replaces it, and failed writes are reported.
#include <sys/resource.h>
#include <sys/stat.h>
#include <tests/run_program.h>
#include <tests/tools/recordings.h>
#include <tools/files/output_file.h>

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
using scree::testing::record_stack;

constexpr const char* kRun = "run stack --set bodies=3 --steps 5 --quiet ";

class OutputFiles : public scree::testing::ProgramTest {
 protected:
  Outcome scree(const std::string& arguments) { return run("'" SCREE_COMMAND "' " + arguments); }
  // With redirections of its own.
  Outcome scree(const std::string& arguments, const std::string& redirections) {
    return run("( '" SCREE_COMMAND "' " + arguments + " " + redirections + " )");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return path(name);
  }
  std::string recording(const std::string& name) const {
    record_stack(path(name), 8);
    return path(name);
  }
  // Of the folder, without what the shell makes.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename();
      if (name != "out" && name != "err") names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  void expect_refusal(const std::string& arguments, const std::string& reason) {
    const Outcome outcome = scree(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  }
};

constexpr const char* kScene = R"({"bodies": [{"shapes": [{"type": "sphere", "radius": 1}]}]})";

TEST_F(OutputFiles, AreNeverInputsOfTheCommand) {
  const std::string scene = write("scene.json", kScene);
  const std::string a = recording("a.scree"), b = recording("b.scree");
  const std::string recorded = read_file(a);
  const std::string hard_link = path("hard"), symbolic_link = path("symbolic");
  fs::create_hard_link(a, hard_link);
  fs::create_symlink(a, symbolic_link);
  expect_refusal("run " + scene + " --json " + scene,
                 "--json " + scene + ": is the same file as SCENE " + scene);
  expect_refusal("run " + scene + " --record " + scene, "--record " + scene + ": is the same file as SCENE");
  for (const std::string& name : {a, hard_link, symbolic_link, path("./a.scree")}) {
    const std::string message = "--json " + name + ": is the same file as ";
    expect_refusal("replay " + a + " --json " + name, message + "FILE " + a);
    expect_refusal("info " + a + " --json " + name, message + "FILE " + a);
    expect_refusal("diff " + b + " " + a + " --json " + name, message + "B " + a);
    expect_refusal("diff " + a + " " + b + " --json " + name, message + "A " + a);
  }
  EXPECT_EQ(read_file(scene), kScene);
  EXPECT_EQ(read_file(a), recorded);
}

TEST_F(OutputFiles, AreNeverTheSameTwice) {
  const std::string file = path("figures"), link = path("link");
  fs::create_symlink(file, link);  // to a file that does not exist yet
  for (const std::string& name : {file, link, path("./figures")}) {
    expect_refusal(kRun + ("--json " + file) + " --record " + name,
                   "--record " + name + ": is the same file as --json " + file);
  }
  EXPECT_FALSE(fs::exists(file));
  write("figures", "old");
  expect_refusal(kRun + ("--json " + file) + " --record " + link, "is the same file as --json");
  EXPECT_EQ(read_file(file), "old");
}

TEST_F(OutputFiles, StayAsTheyWereWhereACommandIsRefused) {
  const std::string json = write("old.json", "old figures"), record = write("old.scree", "old recording");
  const std::string no_recording = write("none.scree", "this is no recording");
  const std::string outputs = " --json " + json + " --record " + record;
  for (const std::string& arguments :
       {"run nowhere" + outputs, "run stack --steps 0" + outputs, "run stack --warmup 9 --steps 9" + outputs,
        "run " + write("wrong.json", "{}") + outputs, "run many_worlds" + outputs,
        "replay " + no_recording + " --json " + json, "info " + path("missing") + " --json " + json,
        "diff " + recording("a.scree") + " " + no_recording + " --json " + json}) {
    EXPECT_EQ(scree(arguments).exit_code, 2) << arguments;
    EXPECT_EQ(read_file(json), "old figures") << arguments;
    EXPECT_EQ(read_file(record), "old recording") << arguments;
  }
}

TEST_F(OutputFiles, AreReplacedAsAWholeAndKeepPermissionsAndLinks) {
  const std::string file = write("figures.json", std::string(100'000, ' ')), link = path("link.json");
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  fs::create_symlink("figures.json", link);
  EXPECT_EQ(scree(kRun + ("--json " + link)).exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(nlohmann::json::parse(read_file(file)).at("scene"), "stack");
  EXPECT_LT(fs::file_size(file), 10'000u);
  EXPECT_EQ(fs::status(file).permissions(),
            fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  EXPECT_EQ(scree(kRun + ("--json " + path("new.json"))).exit_code, 0);
  EXPECT_EQ(fs::status(path("new.json")).permissions(), fs::status(write("plain", "")).permissions());
  EXPECT_EQ(files(), (std::vector<std::string>{"figures.json", "link.json", "new.json", "plain"}));
}

TEST_F(OutputFiles, StayAsTheyWereWhereTheDiskIsFull) {
  const scree::files::NamedFile file{"--json", write("figures.json", "old figures")};
  scree::files::prepare_process();
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  rlimit small = limit;
  small.rlim_cur = 1000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string error;
  try {
    scree::files::write_file(file, std::string(2000, 'x'));
  } catch (const std::runtime_error& caught) {
    error = caught.what();
  }
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  EXPECT_EQ(error, "--json " + file.path + ": writing failed: File too large");
  EXPECT_EQ(read_file(file.path), "old figures");
  EXPECT_EQ(files(), std::vector<std::string>{"figures.json"});
}

TEST_F(OutputFiles, ThatAreDevicesAndPipesAreWrittenAsTheyAre) {
  EXPECT_EQ(scree(kRun + std::string("--json /dev/null --record /dev/null")).exit_code, 0);
  const std::string pipe = path("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  run("( cat " + pipe + " & '" SCREE_COMMAND "' " + kRun + "--json " + pipe + " >/dev/null; wait )");
  EXPECT_EQ(nlohmann::json::parse(read_file(folder_ / "out")).at("scene"), "stack");
  // Treated as "-", whatever standard output is.
  for (const std::string& redirection : {std::string(), "| cat >" + path("figures"), ">" + path("figures")}) {
    const Outcome outcome = scree(kRun + std::string("--json /dev/stdout"), redirection);
    EXPECT_EQ(outcome.exit_code, 0);
    const std::string json = redirection.empty() ? outcome.out : read_file(path("figures"));
    EXPECT_EQ(nlohmann::json::parse(json).at("scene"), "stack") << redirection;
    EXPECT_NE(outcome.err.find("steps/s"), std::string::npos) << redirection;
  }
  // The caller's open file gets the figures after its present content.
  const Outcome outcome = run("{ echo before >&3; '" SCREE_COMMAND "' " + std::string(kRun) +
                              "--json /dev/fd/3; echo after >&3; } 3>" + path("open"));
  EXPECT_EQ(outcome.exit_code, 0);
  const std::string text = read_file(path("open"));
  EXPECT_EQ(text.rfind("before\n{", 0), 0u) << text;
  EXPECT_NE(text.find("}\nafter\n"), std::string::npos) << text;
}

TEST_F(OutputFiles, OfFiguresAreNotTheStandardStreamOfARecording) {
  const std::string file = path("mixed");
  for (const char* name : {"/dev/stdout", "/dev/stderr"}) {
    const Outcome outcome = scree(kRun + std::string("--record ") + name);
    EXPECT_EQ(outcome.exit_code, 2) << name;
  }
  EXPECT_EQ(scree(kRun + ("--record " + file), ">" + file).exit_code, 2);
  EXPECT_EQ(scree(kRun + ("--record " + file), "2>" + file).exit_code, 2);
}

TEST_F(OutputFiles, MakeEveryCommandFailIfWritingFails) {
  const std::string file = recording("a.scree");
  for (const std::string& arguments :
       {std::string("scenes"), std::string("--help"), std::string("run --help"), std::string("--version"),
        std::string(kRun), kRun + std::string("--json -"), "replay " + file + " --quiet",
        "replay " + file + " --verify --quiet", "info " + file, "diff " + file + " " + file}) {
    const Outcome outcome = scree(arguments, ">/dev/full");
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_NE(outcome.err.find("scree: standard output cannot be written: No space left on device"),
              std::string::npos)
        << arguments << "\n"
        << outcome.err;
  }
  EXPECT_EQ(scree(kRun + std::string("--json /dev/full")).exit_code, 1);
  EXPECT_EQ(scree(kRun + std::string("--record /dev/full")).exit_code, 1);
  // The other outputs are written.
  const std::string json = path("figures.json");
  EXPECT_EQ(scree(kRun + ("--json " + json), ">/dev/full").exit_code, 1);
  EXPECT_EQ(nlohmann::json::parse(read_file(json)).at("scene"), "stack");
}

TEST_F(OutputFiles, ThatCannotBeOpenedAreBadInput) {
  const std::string too_long(300, 'x'), folder = folder_.string();
  for (const char* option : {"--json ", "--record "}) {
    expect_refusal(kRun + (option + too_long), "File name too long");
    expect_refusal(kRun + (option + folder), "Is a directory");
    expect_refusal(kRun + (option + path("none/x")), "No such file or directory");
    expect_refusal(kRun + (option + path("x/")), "No such file or directory");
    expect_refusal(kRun + (option + std::string("''")), "the name of the file is empty");
  }
  expect_refusal("run " + too_long, "unknown scene");
  expect_refusal("run " + too_long + ".json", "cannot be read");
  expect_refusal("replay " + too_long, "cannot be read");
  EXPECT_EQ(files(), std::vector<std::string>{});
}

TEST_F(OutputFiles, NeverTakeTheDescriptorOfAClosedStandardStream) {
  const std::string record = path("a.scree"), json = path("figures.json");
  for (const char* closed : {"<&-", ">&-", "2>&-", "<&- 2>&-"}) {
    fs::remove(record);
    const Outcome outcome = scree(kRun + ("--record " + record) + " --json " + json, closed);
    EXPECT_EQ(outcome.exit_code, closed == std::string(">&-") ? 1 : 0) << closed;
    const Outcome replay = scree("replay " + record + " --verify --quiet");
    EXPECT_EQ(replay.exit_code, 0) << closed << "\n" << replay.err;
    EXPECT_EQ(nlohmann::json::parse(read_file(json)).at("scene"), "stack") << closed;
  }
}

TEST_F(OutputFiles, AreNotFilesThatAnotherProcessRecords) {
  const std::string file = path("a.scree");
  scree::World world;
  scree::Workers workers(1);
  scree::Recorder recorder(world, file);
  step(world, 0.01f, workers);
  expect_refusal(kRun + ("--record " + file),
                 "--record " + file + ": cannot be written: a recorder is writing to it");
  expect_refusal(kRun + ("--json " + file),
                 "--json " + file + ": cannot be written: a recorder is writing to it");
  EXPECT_EQ(scree("info " + file).exit_code, 0);
  step(world, 0.01f, workers);
  recorder.finish();
  EXPECT_EQ(scree("replay " + file + " --verify --quiet").exit_code, 0);
  EXPECT_EQ(scree(kRun + ("--record " + file)).exit_code, 0);
}

TEST_F(OutputFiles, OfTheExampleAndTheSoakMakeThemFailIfWritingFails) {
  for (const std::string program : {SCREE_ROLLBACK " --steps 5 --bodies 3", SCREE_ROLLBACK " --help",
                                    SCREE_SOAK " --help", SCREE_SOAK " --minutes 0"}) {
    const Outcome outcome = run("( cd " + folder_.string() + " && " + program + " >/dev/full )");
    EXPECT_EQ(outcome.exit_code, 1) << program;
    EXPECT_NE(outcome.err.find("standard output cannot be written"), std::string::npos) << program;
  }
}

TEST_F(OutputFiles, NamesThatAreNotValidTextLoseNoFigures) {
  const std::string record = path("\xff.scree");
  const Outcome outcome = scree(kRun + ("--record " + record) + " --json -");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("recording").at("steps"), 5);
}

}  // namespace
