// Laws of the command `scree`, run as a program: what it prints, where, and with which exit code.
#include <scree/stats.h>
#include <scree/workers.h>
#include <tests/run_program.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

namespace fs = std::filesystem;

using scree::testing::Outcome;
using scree::testing::read_file;

class Command : public scree::testing::ProgramTest {
 protected:
  // Arguments are words for the shell.
  Outcome scree(const std::string& arguments, const std::string& environment = "") {
    return run(environment + " '" SCREE_COMMAND "' " + arguments);
  }

  // Runs and parses what `--json -` prints.
  nlohmann::json figures(const std::string& arguments, const std::string& environment = "") {
    const Outcome outcome = scree("run " + arguments + " --quiet --json -", environment);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }

  void expect_refusal(const std::string& arguments, const std::string& reason,
                      const std::string& environment = "") {
    const Outcome outcome = scree(arguments, environment);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << arguments << "\n" << outcome.err;
  }

  std::string write(const std::string& name, const std::string& text) {
    const fs::path path = folder_ / name;
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
};

TEST_F(Command, ComparesSolversOnTheSameScene) {
  const char* const kNames[] = {
      "soft_step",          "sequential_impulse",   "jacobi", "gauss_seidel", "over_relaxation",
      "conjugate_gradient", "accelerated_gradient", "direct"};
  const std::string json = write("compare.json", "");
  const Outcome outcome = scree("compare stack --set bodies=2 --steps 20 --counts 1,64 --json " + json);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json figures = nlohmann::json::parse(read_file(json));
  ASSERT_EQ(figures["solvers"].size(), std::size(kNames));
  for (std::size_t i = 0; i < figures["solvers"].size(); ++i) {
    const nlohmann::json& solver = figures["solvers"][i];
    const std::string name = solver["solver"];
    EXPECT_EQ(name, kNames[i]);
    EXPECT_NE(outcome.out.find(name), std::string::npos);
    const auto& points = solver["convergence"];
    const double first = points.front()["residual"], last = points.back()["residual"];
    EXPECT_LE(last, first) << name;
    if (name != "soft_step") {
      EXPECT_LT(last, 1e-2) << name;
    }
    EXPECT_LT(solver["moved"].get<double>(), 0.01) << name;
    EXPECT_LT(solver["off_exact"].get<double>(), 0.01) << name;
  }
}

// A brick of 1 x 2 x 4 m, whose triangles look outward.
const char* const kBrick =
    "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 4\nv 1 0 4\nv 1 2 4\nv 0 2 4\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

TEST_F(Command, MeasuresTheMassOfAMesh) {
  const std::string brick = write("brick.obj", kBrick);
  const Outcome outcome = scree("mass " + brick + " --density 3 --json -");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json mass = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(mass["mass"], 24.0);
  EXPECT_EQ(mass["center"], (nlohmann::json{0.5, 1.0, 2.0}));
  EXPECT_EQ(mass["principal_moments"], (nlohmann::json{10.0, 34.0, 40.0}));
  EXPECT_EQ(mass["open_edges"], 0);
  EXPECT_NE(outcome.err.find("24 kg"), std::string::npos) << outcome.err;
  const Outcome small = scree("mass " + brick + " --scale 0.001 --hull");
  EXPECT_NE(small.out.find("its convex hull"), std::string::npos);
  EXPECT_NE(small.out.find("8e-06 kg"), std::string::npos) << small.out;
}

TEST_F(Command, BuildsTheHullOfAFile) {
  const std::string brick = write("brick.obj", std::string(kBrick) + "v 0.5 1 2\nf 1 2 9\n");
  const std::string hull = write("hull.obj", "");
  const Outcome outcome = scree("hull " + brick + " --output " + hull);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("8 m^3"), std::string::npos) << outcome.out;
  const Outcome mass = scree("mass " + hull);
  EXPECT_NE(mass.out.find("8000 kg"), std::string::npos) << mass.out << mass.err;
}

// The prism of an L, 6 m^2 by 1 m.
const char* const kBracket =
    "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 4 0\nv 0 4 0\n"
    "v 0 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 4 1\nv 0 4 1\n"
    "f 4 3 2 1\nf 6 5 4 1\nf 7 8 9 10\nf 7 10 11 12\n"
    "f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

TEST_F(Command, DecomposesAFile) {
  const std::string bracket = write("bracket.obj", kBracket);
  const std::string parts = write("parts.obj", ""), scene = write("bracket.json", "");
  const Outcome outcome =
      scree("decompose " + bracket + " --output " + parts + " --scene " + scene + " --json -");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json figures = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(figures["parts"].size(), 2u);
  EXPECT_EQ(figures["parts"][0]["faces"], 6);
  EXPECT_NEAR(figures["mesh_volume"].get<double>(), 6.0, 1e-12);
  EXPECT_NEAR(figures["hull_volume"].get<double>(), 6.0, 1e-5);
  EXPECT_LT(figures["hulls_from_mesh"].get<double>(), 1e-5);
  EXPECT_NE(outcome.err.find("mesh 6, hulls 6 m^3"), std::string::npos) << outcome.err;
  const Outcome mass = scree("mass " + parts + " --density 1");
  EXPECT_NE(mass.out.find("6 kg"), std::string::npos) << mass.out << mass.err;
  const Outcome run = scree("run " + scene + " --steps 120 --threads 1 --quiet --json -");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(nlohmann::json::parse(run.out)["bodies"], 1);
}

TEST_F(Command, RefusesDecompositionsThatMakeNoSense) {
  const std::string bracket = write("bracket.obj", kBracket);
  const std::string open =
      write("open.obj", std::string(kBracket).substr(0, std::string(kBracket).size() - 11));
  expect_refusal("decompose " + open, "open.obj: decompose: the mesh is not closed: of 29 edges 4 are open");
  expect_refusal("decompose " + bracket + " --max-parts 0", "max_parts is 0, must lie in [1, 1024]");
  expect_refusal("decompose " + bracket + " --concavity-share 2", "concavity_share is 2");
  expect_refusal("decompose " + bracket + " --concavity -1", "concavity is -1");
  expect_refusal("decompose " + bracket + " --resolution 4", "resolution is 4");
  expect_refusal("decompose " + bracket + " --output " + bracket, "FILE");
  const std::string same = (folder_ / "same").string();
  expect_refusal("decompose " + bracket + " --output " + same + " --scene " + same, "--scene");
}

TEST_F(Command, RefusesShapesThatAreNone) {
  const std::string brick = write("brick.obj", kBrick);
  const std::string open = write("open.obj", std::string(kBrick).substr(0, std::string(kBrick).size() - 10));
  expect_refusal("mass " + open, "the mesh is not closed: of 17 edges 4 are open");
  expect_refusal("mass " + brick + " --density 0", "density is 0, must lie in");
  expect_refusal("mass " + brick + " --scale -1", "--scale -1 must be above 0");
  expect_refusal("mass " + (folder_ / "none.obj").string(), "there is no such file");
  expect_refusal("hull " + brick + " --max-vertices 3", "3");
  expect_refusal("hull " + brick + " --output " + brick, "FILE");
  expect_refusal("hull " + write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"), "flat.obj: Hull");
}

TEST_F(Command, RefusesComparisonsThatMakeNoSense) {
  expect_refusal("compare stack --solvers direct,newton", "--solver newton: unknown solver");
  expect_refusal("compare stack --counts 0", "--counts 0 must be from 1");
  expect_refusal("compare stack --steps 5 --at 6", "--at 6 must be from 0 to 5");
  expect_refusal("compare many_worlds", "consists of 1000 worlds");
  expect_refusal("compare nothing", "unknown scene");
}

TEST_F(Command, WritesContactProblemsOrSaysThatItCannot) {
  const std::string file = (folder_ / "problem.hdf5").string();
#ifdef SCREE_HAS_FCLIB
  const Outcome outcome = scree("fclib stack " + file + " --set bodies=2 --at 3 --json -");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json figures = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(figures["points"], 8);
  EXPECT_LT(figures["natural_error"].get<double>(), 1e-9);
  EXPECT_EQ(read_file(file).substr(1, 3), "HDF");
  expect_refusal("fclib stack " + file + " --at -1", "--at -1 must be from 0");
  expect_refusal("fclib many_worlds " + file, "consists of 1000 worlds");
  expect_refusal("fclib stack " + (folder_ / "no" / "file.hdf5").string(), "FILE");
  expect_refusal("fclib chain " + (folder_ / "chain.hdf5").string() + " --at 1", "nothing touches");
#else
  expect_refusal("fclib stack " + file, "this build cannot write the FCLIB format");
#endif
}

TEST_F(Command, ListsEverySceneOnALineOfItsOwn) {
  const Outcome outcome = scree("scenes");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 33);
  for (const char* name :
       {"large_pyramid", "many_pyramids", "convex_pile", "junkyard", "pile", "hull_zoo", "stack", "wall",
        "card_house", "slope", "spheres_in_box", "many_worlds", "large_world", "streaming", "spawning",
        "terrain", "drum", "height_field", "bullets"}) {
    EXPECT_TRUE(outcome.out.find(std::string("\n") + name + " ") != std::string::npos ||
                outcome.out.rfind(std::string(name) + " ", 0) == 0)
        << name;
  }
}

TEST_F(Command, HelpIsNoError) {
  EXPECT_EQ(scree("--help").exit_code, 0);
  EXPECT_EQ(scree("run --help").exit_code, 0);
}

TEST_F(Command, RefusesBadCommandLinesWithExitCodeTwo) {
  expect_refusal("", "nothing to do");
  expect_refusal("fly", "fly");
  expect_refusal("run", "SCENE");
  expect_refusal("run stack --fly", "--fly");
  expect_refusal("run stack --steps many", "many");
  expect_refusal("run nowhere", "unknown scene \"nowhere\"; there are: large_pyramid");
  expect_refusal("run stack --set height=3", "scene stack has no parameter \"height\"; it has: bodies");
  expect_refusal("run stack --set bodies", "--set bodies: expected key=value");
  expect_refusal("run stack --set bodies=", "is not a finite number");
  expect_refusal("run stack --set bodies=1x", "\"1x\" is not a finite number");
  expect_refusal("run stack --set bodies=nan", "\"nan\" is not a finite number");
  expect_refusal("run stack --set bodies=1e400", "is not a finite number");
  expect_refusal("run stack --set bodies=0", "bodies = 0 must be from 1 to 10000");
  expect_refusal("run stack --set bodies=2 bodies=3", "--set bodies is given twice");
  expect_refusal("run convex_pile --set layers=0", "layers = 0 must be from 1 to 1000");
  expect_refusal("run convex_pile --set columns=1.5", "columns = 1.5 must be a whole number");
  expect_refusal("run junkyard --set columns=22", "columns = 22 must be from 1 to 21");
  expect_refusal("run junkyard --set rocks=5", "it has: columns, layers");
  expect_refusal("run hull_zoo --set max_vertices=3", "max_vertices = 3 must be from 4 to 256");
  expect_refusal("run stack --steps 0", "--steps 0 must be from 1");
  expect_refusal("run stack --steps -5", "--steps -5 must be from 1");
  expect_refusal("run stack --steps 10 --warmup 10", "--warmup 10 must be below the 10 steps");
  expect_refusal("run stack --warmup -1", "--warmup -1 must be from 0");
  expect_refusal("run stack --dt -0.1", "--dt -0.1");
  expect_refusal("run stack --dt nan", "--dt nan");
  expect_refusal("run stack --dt 1.5", "must be from 0 to 1 seconds");
  expect_refusal("run stack --substeps 0", "--substeps 0 must be from 1 to 64");
  expect_refusal("run stack --solver newton", "--solver newton: unknown solver; there are: soft_step");
  expect_refusal("run stack --iterations 0", "--iterations 0 must be from 1 to 1000000");
  expect_refusal("run stack --threads -1", "--threads -1 must be from 0 to 1024");
  expect_refusal("run stack --threads 5000", "--threads 5000 must be from 0 to 1024");
  expect_refusal("run stack --isa mmx", "--isa mmx: unknown instruction set; there are: auto, scalar, sse2");
  expect_refusal("run stack --keyframes 5", "--keyframes says nothing without --record FILE");
  expect_refusal("run stack --record x.scree --keyframes 0", "--keyframes 0 must be from 1 to 1000000000");
  expect_refusal("run stack --record /no/such/folder/x.scree", "/no/such/folder/x.scree");
  expect_refusal("run many_worlds --set worlds=3 --record x.scree",
                 "a recording is of one world, and the scene many_worlds consists of 3; say --set worlds=1");
  expect_refusal("run stack --json /no/such/folder/x.json", "/no/such/folder/x.json: cannot be written");
}

TEST_F(Command, RefusesAnUnknownInstructionSetInTheEnvironment) {
  expect_refusal("run stack --steps 2", "SCREE_ISA", "SCREE_ISA=mmx");
}

TEST_F(Command, ReportsBadSceneFilesWithFilePlaceAndReason) {
  expect_refusal("run " + folder_.string() + "/missing.json", "missing.json: cannot be read");
  const std::string broken = write("broken.json", "{\n  \"bodies\": [\n}\n");
  expect_refusal("run " + broken, broken + ":3:1: not JSON: ");
  const std::string wrong = write("wrong.json", R"({"bodies": [{"shapes": [{"type": "box"}]}]})");
  expect_refusal("run " + wrong, wrong + ": /bodies/0/shapes/0: the key \"half_extents\" is missing");
  const std::string good =
      write("good.json", R"({"bodies": [{"shapes": [{"type": "sphere", "radius": 1}]}]})");
  expect_refusal("run " + good + " --set bodies=3", "a scene file has no parameters");
}

TEST_F(Command, JsonHoldsEveryFigure) {
  const nlohmann::json json = figures("stack --set bodies=4 --steps 20 --warmup 5 --threads 1 --isa scalar");
  EXPECT_EQ(json.at("scene"), "stack");
  EXPECT_EQ(json.at("isa"), "scalar");
  EXPECT_EQ(json.at("threads"), 1);
  EXPECT_EQ(json.at("steps"), 20);
  EXPECT_EQ(json.at("bodies"), 4);
  EXPECT_EQ(json.at("contacts"), 4);
  for (const char* key : {"mean", "median", "min", "max"}) {
    EXPECT_GT(json.at("ms_per_step").at(key).get<double>(), 0.0) << key;
  }
  double sum = 0.0;
  for (int phase = 0; phase < scree::kPhaseCount; ++phase) {
    sum += json.at("phases").at(scree::phase_name(static_cast<scree::Phase>(phase))).get<double>();
  }
  EXPECT_EQ(json.at("phases").size(), static_cast<std::size_t>(scree::kPhaseCount));
  EXPECT_LE(sum, json.at("ms_per_step").at("mean").get<double>() * 1.01);
  EXPECT_GT(sum, 0.0);
  for (const char* key : {"mean", "p999", "max"}) {
    const double penetration = json.at("penetration").at(key).get<double>();
    EXPECT_GE(penetration, 0.0);
    EXPECT_LT(penetration, 0.02);
  }
  EXPECT_GT(json.at("penetration").at("max").get<double>(), 0.0);
  EXPECT_TRUE(json.at("residual").is_number());
  EXPECT_GE(json.at("kinetic_energy").get<double>(), 0.0);
  EXPECT_GT(json.at("peak_memory_bytes").get<std::int64_t>(), 1'000'000);
  EXPECT_GT(json.at("lane_fill").get<double>(), 0.0);
  EXPECT_LE(json.at("lane_fill").get<double>(), 1.0);
  EXPECT_GE(json.at("stages").get<int>(), 0);
  const std::string hash = json.at("hash");
  EXPECT_EQ(hash.size(), 16u);
  EXPECT_EQ(hash.find_first_not_of("0123456789abcdef"), std::string::npos);
}

TEST_F(Command, HashDependsOnNeitherThreadsNorInstructionSetNorTheMeasurement) {
  const std::string scene = "pile --set bodies=200 --steps 60 ";
  const std::string hash = figures(scene + "--threads 1 --isa scalar").at("hash");
  EXPECT_EQ(figures(scene + "--threads 3 --isa auto").at("hash"), hash);
  EXPECT_EQ(figures(scene + "--threads 2 --warmup 30").at("hash"), hash);
  if (scree::is_supported(scree::Isa::sse2)) {
    EXPECT_EQ(figures(scene, "SCREE_ISA=sse2").at("hash"), hash);
  }
  EXPECT_NE(figures(scene + "--set seed=2").at("hash"), hash);
}

TEST_F(Command, EverySceneRuns) {
  for (const char* scene : {"large_pyramid --set base=6",
                            "many_pyramids --set rows=2 --set columns=2 --set base=3",
                            "convex_pile --set columns=2 --set layers=2",
                            "junkyard --set columns=2 --set layers=1",
                            "hull_zoo --set bodies=40",
                            "pile --set bodies=50",
                            "stack --set bodies=5",
                            "wall --set columns=4 --set rows=3",
                            "kapla",
                            "card_house",
                            "slope",
                            "spheres_in_box --set bodies=40",
                            "many_worlds --set worlds=4 --set bodies=20",
                            "joint_grid --set columns=6 --set rows=6",
                            "chain --set links=8 --set weight=10",
                            "bridge --set planks=10 --set loads=3",
                            "wrecking_ball --set columns=4 --set rows=3",
                            "ragdolls --set ragdolls=3",
                            "vehicles --set cars=3",
                            "motors --set machines=1",
                            "card_catapult --set stories=2"}) {
    EXPECT_GT(figures(std::string(scene) + " --steps 10 --no-sleep").at("awake_bodies"), 0) << scene;
  }
}

TEST_F(Command, ManyWorldsAddUp) {
  const nlohmann::json json = figures("many_worlds --set worlds=5 bodies=30 --steps 3");
  EXPECT_EQ(json.at("worlds"), 5);
  EXPECT_EQ(json.at("bodies"), 150);
}

TEST_F(Command, CountsJoints) {
  EXPECT_EQ(figures("joint_grid --set columns=4 rows=3 --steps 2").at("joints"), 4 * 2 + 3 * 3);
  EXPECT_EQ(figures("stack --set bodies=2 --steps 2").at("joints"), 0);
  EXPECT_EQ(figures(SCREE_EXAMPLES "/drawbridge.json --steps 2").at("joints"), 1 + 11 + 2 + 1 + 9 + 1);
}

TEST_F(Command, RunsASceneFile) {
  const nlohmann::json json = figures(SCREE_EXAMPLES "/dominoes.json --steps 5");
  EXPECT_EQ(json.at("scene"), "dominoes");
  EXPECT_EQ(json.at("bodies"), 51);
  EXPECT_EQ(json.at("steps"), 5);
}

TEST_F(Command, TheTableGoesToStandardOutputUnlessTheJsonDoes) {
  const std::string run = "run stack --set bodies=2 --steps 5 --quiet ";
  const Outcome plain = scree(run);
  EXPECT_EQ(plain.err, "");
  for (const char* row : {"bodies", "contacts", "steps/s", "ms per step", "solve", "awake bodies",
                          "penetration", "residual", "kinetic energy", "peak memory", "lane fill",
                          "stages per step", "hash", "instruction set", "threads"}) {
    EXPECT_NE(plain.out.find(row), std::string::npos) << row;
  }
  const Outcome json = scree(run + "--json -");
  EXPECT_EQ(json.out.front(), '{');
  EXPECT_NE(json.err.find("steps/s"), std::string::npos);
  const fs::path file = folder_ / "figures.json";
  const Outcome both = scree(run + "--json " + file.string());
  EXPECT_NE(both.out.find("steps/s"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(read_file(file)).at("scene"), "stack");
}

TEST_F(Command, SaysThatThreadsBeyondTheCoresAreIdleUnlessQuiet) {
  const std::string cores = std::to_string(scree::Workers().threads());
  const std::string line = "scree: --threads 1000: " + cores + " thread";
  const std::string pile = "run pile --set bodies=300 --steps 3 --threads 1000 ";
  const Outcome talkative = scree(pile);
  EXPECT_EQ(talkative.err.rfind(line, 0), 0u) << talkative.err;
  EXPECT_EQ(talkative.err.find("TBB"), std::string::npos) << talkative.err;
  const Outcome quiet = scree(pile + "--quiet --record " + (folder_ / "pile.scree").string());
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(scree("run pile --set bodies=300 --steps 3 --quiet --threads " + cores).err, "");
  EXPECT_EQ(scree("replay " + (folder_ / "pile.scree").string() + " --quiet --threads 1000").err, "");
}

TEST_F(Command, ShowsProgressOnStandardErrorUnlessQuiet) {
  const Outcome outcome = scree("run stack --set bodies=2 --steps 20");
  EXPECT_NE(outcome.err.find("stack:  50 %, step 10 of 20"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("stack: 100 %, step 20 of 20"), std::string::npos) << outcome.err;
}

// --- accuracy ---

TEST_F(Command, AccuracyPrintsATableAndWritesItsFigures) {
  const std::string file = (folder_ / "figures.json").string();
  const Outcome outcome =
      scree("accuracy --quiet --cases slide_to_roll --dt 0.02,0.01 --json '" + file + "'");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.out.rfind("slide_to_roll: ", 0), 0u) << outcome.out;
  const nlohmann::json figures = nlohmann::json::parse(read_file(file));
  EXPECT_EQ(figures.at("entries").size(), 2u);
  EXPECT_LT(figures.at("entries")[1].at("errors").at("speed").get<double>(), 0.01);
}

TEST_F(Command, AccuracyHasTheSameErrorsOnEveryInstructionSet) {
  const auto errors = [&](const std::string& isa) {
    const Outcome outcome =
        scree("accuracy --quiet --cases rolling,dominoes --dt 0.01 --isa " + isa + " --json -");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    std::string text;
    const nlohmann::json figures = nlohmann::json::parse(outcome.out);
    for (const nlohmann::json& entry : figures.at("entries")) text += entry.at("errors").dump();
    return text;
  };
  EXPECT_EQ(errors("scalar"), errors("auto"));
}

TEST_F(Command, AccuracyListsItsCasesAndRefusesOthers) {
  const Outcome outcome = scree("accuracy --list");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 16);
  expect_refusal("accuracy --cases croquet", "unknown case; there are: bouncing, height");
  expect_refusal("accuracy --dt 0", "--dt 0 must be above 0");
  expect_refusal("accuracy --substeps 0", "--substeps 0 must be from 1 to 64");
  expect_refusal("accuracy --contact-hertz 0", "--contact-hertz 0 must be from");
  expect_refusal("accuracy --isa mmx", "unknown instruction set");
  expect_refusal("accuracy --solver magic",
                 "--solver magic: unknown solver; there are: soft_step, sequential_impulse");
  expect_refusal("accuracy --solver ''", "unknown solver");
  expect_refusal("accuracy --iterations 0", "--iterations 0 must be from 1 to 1000000");
  expect_refusal("accuracy --iterations many", "--iterations");
  expect_refusal("accuracy --threads -1", "--threads -1");
  expect_refusal("accuracy --json /no/such/folder/figures.json", "--json");
}

}  // namespace
