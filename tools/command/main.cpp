// The command `scree`: reads the command line, runs, prints. Exit codes: 0 done, 1 something broke, 2 bad
// input.
#include <tools/command/report.h>
#include <tools/command/run.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>

namespace {

constexpr int kBroken = 1;
constexpr int kBadInput = 2;

// key=value pairs; CLI11 would take them as positions of its own otherwise.
scree::scenes::Parameters read_parameters(const std::vector<std::string>& settings) {
  scree::scenes::Parameters parameters;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw scree::Error("--set " + setting + ": expected key=value");
    }
    const std::string key = setting.substr(0, equals);
    const std::string text = setting.substr(equals + 1);
    std::size_t used = 0;
    double value = 0.0;
    try {
      value = std::stod(text, &used);
    } catch (const std::logic_error&) {
      used = 0;
    }
    if (used == 0 || used != text.size() || !std::isfinite(value)) {
      throw scree::Error("--set " + setting + ": \"" + text + "\" is not a finite number");
    }
    if (!parameters.emplace(key, value).second) throw scree::Error("--set " + key + " is given twice");
  }
  return parameters;
}

scree::Isa read_isa(const std::string& name) {
  std::string names;
  for (int i = 0; i <= static_cast<int>(scree::Isa::avx512); ++i) {
    const auto isa = static_cast<scree::Isa>(i);
    if (name == scree::isa_name(isa)) return isa;
    names += (names.empty() ? "" : ", ") + std::string(scree::isa_name(isa));
  }
  throw scree::Error("--isa " + name + ": unknown instruction set; there are: " + names);
}

void list_scenes() {
  for (const scree::scenes::SceneInfo& info : scree::scenes::catalog()) {
    std::ostringstream parameters;
    parameters.precision(15);
    for (const auto& [name, value] : info.parameters) {
      parameters << (parameters.tellp() > 0 ? " " : "") << name << "=" << value;
    }
    std::printf("%-15s %s (%s)\n", info.name.c_str(), info.summary.c_str(), parameters.str().c_str());
  }
}

// Opened before the run: nobody should learn after an hour that the file cannot be written.
class JsonOutput {
 public:
  explicit JsonOutput(const std::string& target) : target_(target) {
    if (target_.empty() || to_standard_output()) return;
    file_.open(target_, std::ios::binary);
    if (!file_) throw scree::Error("--json " + target_ + ": cannot be written");
  }

  bool to_standard_output() const { return target_ == "-"; }

  void write(const std::string& json) {
    if (target_.empty()) return;
    std::ostream& stream = to_standard_output() ? std::cout : file_;
    stream << json << std::flush;
    if (!stream) throw std::runtime_error("--json " + target_ + ": writing failed");
  }

 private:
  std::string target_;
  std::ofstream file_;
};

// What the command line gave, as text; checked when the run begins.
struct Arguments {
  scree::command::RunOptions options;
  std::vector<std::string> settings;
  std::string isa = "auto";
  std::string json;
};

void declare_run(CLI::App& run, Arguments& arguments) {
  scree::command::RunOptions& options = arguments.options;
  run.add_option("SCENE", options.scene, "A built-in scene (see `scree scenes`) or a JSON scene file")
      ->required();
  run.add_option("--set", arguments.settings, "key=value: a parameter of the scene; may be repeated")
      ->allow_extra_args(true)
      ->type_name("KEY=VALUE");
  run.add_option("--steps", options.steps, "All steps, the warm-up included (default: the scene's)");
  run.add_option("--dt", options.dt, "Time step in seconds, 0 to 1 (default: the scene's)");
  run.add_option("--substeps", options.substeps, "Solver substeps per step, 1 to 64 (default: the scene's)");
  run.add_option("--threads", options.threads, "Threads (default 0: one per core)");
  run.add_option("--isa", arguments.isa, "auto, scalar, sse2, avx2 or avx512 (default: auto)");
  run.add_option("--warmup", options.warmup, "Untimed steps at the start (default: 1)");
  run.add_flag("--no-sleep", options.no_sleep, "Keep resting bodies awake");
  run.add_option("--json", arguments.json, "Write the figures to FILE; - is standard output")
      ->type_name("FILE");
  run.add_flag("--quiet", options.quiet, "No progress");
}

void run_scene(Arguments& arguments) {
  arguments.options.parameters = read_parameters(arguments.settings);
  arguments.options.isa = read_isa(arguments.isa);
  JsonOutput json(arguments.json);
  const scree::command::RunFigures figures = scree::command::run(arguments.options);
  (json.to_standard_output() ? std::cerr : std::cout) << scree::command::to_table(figures) << std::flush;
  json.write(scree::command::to_json(figures));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Scree simulates very large piles of rigid bodies, fast and with the same bits everywhere.",
               "scree");
  app.require_subcommand(0, 1);  // none at all gets our own message: CLI11's hides a misspelled one
  const CLI::App* scenes = app.add_subcommand("scenes", "List the built-in scenes");
  CLI::App* run = app.add_subcommand("run", "Run a scene and print its figures");
  Arguments arguments;
  declare_run(*run, arguments);
  try {
    app.parse(argc, argv);
    if (scenes->parsed()) {
      list_scenes();
    } else if (run->parsed()) {
      run_scene(arguments);
    } else {
      throw scree::Error("nothing to do; say `scree scenes`, `scree run SCENE` or `scree --help`");
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadInput;
  } catch (const scree::Error& error) {
    std::cerr << "scree: " << error.what() << "\n";
    return kBadInput;
  } catch (const std::bad_alloc&) {
    std::cerr << "scree: out of memory\n";
    return kBroken;
  } catch (const std::exception& error) {
    std::cerr << "scree: " << error.what() << "\n";
    return kBroken;
  }
  return 0;
}
