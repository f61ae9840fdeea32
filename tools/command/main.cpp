// The command `scree`: reads the command line, runs, prints. Exit codes: 0 done, 1 a run failed or
// recordings differ, 2 bad input.
#include <tools/command/arguments.h>
#include <tools/command/options.h>
#include <tools/command/report.h>
#include <tools/command/source.h>

#include <exception>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace {

using scree::command::Arguments;
using scree::files::NamedFile;

constexpr int kFailed = 1;  // and recordings that differ
constexpr int kBadInput = 2;

std::string scene_list() {
  std::ostringstream list;
  for (const scree::scenes::SceneInfo& info : scree::scenes::catalog()) {
    std::ostringstream parameters;
    parameters.precision(15);
    for (const auto& [name, value] : info.parameters) {
      parameters << (parameters.tellp() > 0 ? " " : "") << name << "=" << value;
    }
    list << std::left << std::setw(15) << info.name << " " << info.summary << " (" << parameters.str()
         << ")\n";
  }
  return list.str();
}

void refuse_standard_streams(const NamedFile& output) {
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    if (!scree::files::is_standard_stream(output.path, stream)) continue;
    throw scree::Error(output.argument + " " + output.path + ": is where standard " +
                       (stream == STDOUT_FILENO ? "output" : "error") + " goes");
  }
}

// An output that cannot be written, or would overwrite another, must be reported before hours of work.
void check_files(const Arguments& arguments, const std::vector<NamedFile>& inputs) {
  std::vector<NamedFile> outputs;
  if (!arguments.json.empty() && !arguments.json_to_standard_output())
    outputs.push_back({"--json", arguments.json});
  if (!arguments.fclib.file.empty()) outputs.push_back({"FILE", arguments.fclib.file});
  if (!arguments.hull.output.empty()) outputs.push_back({"--output", arguments.hull.output});
  if (!arguments.decompose.output.empty()) outputs.push_back({"--output", arguments.decompose.output});
  if (!arguments.decompose.scene.empty()) outputs.push_back({"--scene", arguments.decompose.scene});
  if (const std::string& record = arguments.options.record; !record.empty()) {
    outputs.push_back({"--record", record});
    refuse_standard_streams(outputs.back());
  }
  if (const std::string& checkpoint = arguments.options.checkpoint; !checkpoint.empty()) {
    outputs.push_back({"--checkpoint's draft", checkpoint + ".draft"});
    outputs.push_back({"--checkpoint", checkpoint});
    refuse_standard_streams(outputs.back());
  }
  for (const std::string& trace : {arguments.options.trace, arguments.replay.trace}) {
    if (trace.empty()) continue;
    outputs.push_back({"--trace", trace});
    refuse_standard_streams(outputs.back());
  }
  for (const std::string& picture : {arguments.options.picture_file, arguments.render.file}) {
    if (picture.empty()) continue;
    outputs.push_back({arguments.render.file.empty() ? "--picture" : "--out", picture});
    refuse_standard_streams(outputs.back());
  }
  for (const std::string& output : {arguments.extract.output, arguments.exported.output}) {
    if (output.empty()) continue;
    outputs.push_back({arguments.view.save.empty() ? "--out" : "--save", output});
    refuse_standard_streams(outputs.back());
  }
  scree::files::check_outputs(inputs, outputs);
}

// Text for people goes where it does not mix with the JSON. If one output cannot be written, the others still
// are.
template <class Figures>
void print(const Figures& figures, const Arguments& arguments) {
  std::exception_ptr failure;
  const auto attempt = [&failure](const auto& write) {
    try {
      write();
    } catch (...) {
      if (failure == nullptr) failure = std::current_exception();
    }
  };
  const std::string table = to_table(figures);
  if (arguments.json_to_standard_output()) {
    std::cerr << table << std::flush;
    attempt([&] { scree::files::write_standard_output(to_json(figures)); });
  } else {
    attempt([&] { scree::files::write_standard_output(table); });
    if (!arguments.json.empty()) {
      attempt([&] { scree::files::write_file({"--json", arguments.json}, to_json(figures)); });
    }
  }
  if constexpr (requires { figures.trace; }) {
    if (figures.trace)
      attempt([&] { scree::files::write_file({"--trace", figures.trace->file}, figures.trace->json); });
  }
  if constexpr (requires { figures.picture; }) {
    if (figures.picture)
      attempt([&] { scree::files::write_file({"--picture", figures.picture->file}, figures.picture->png); });
  }
  if constexpr (requires { figures.failure; }) {
    if (failure == nullptr) failure = figures.failure;
  }
  if (failure != nullptr) std::rethrow_exception(failure);
}

int build_hull(Arguments& arguments) {
  const scree::command::HullArguments& options = arguments.hull;
  check_files(arguments, {{"FILE", options.file}});
  const scree::command::HullFigures figures = scree::command::build_hull(options);
  if (!options.output.empty()) scree::files::write_file({"--output", options.output}, figures.obj);
  print(figures, arguments);
  return 0;
}

int decompose_file(Arguments& arguments) {
  const scree::command::DecomposeArguments& options = arguments.decompose;
  check_files(arguments, {{"FILE", options.file}});
  const scree::command::DecomposeFigures figures = scree::command::decompose_file(options);
  if (!options.output.empty()) scree::files::write_file({"--output", options.output}, to_obj(figures));
  if (!options.scene.empty()) scree::files::write_file({"--scene", options.scene}, to_scene(figures));
  print(figures, arguments);
  return 0;
}

int measure_mass(Arguments& arguments) {
  check_files(arguments, {{"FILE", arguments.mass.file}});
  print(scree::command::measure_mass(arguments.mass), arguments);
  return 0;
}

int write_fclib(Arguments& arguments) {
  scree::command::FclibArguments& options = arguments.fclib;
  options.parameters = scree::command::read_parameters(arguments.settings);
  options.isa = scree::command::read_isa(arguments.isa);
  std::vector<NamedFile> inputs;
  if (scree::command::is_scene_file(options.scene)) inputs.push_back({"SCENE", options.scene});
  check_files(arguments, inputs);
  print(scree::command::write_fclib(options), arguments);
  return 0;
}

int compare_solvers(Arguments& arguments) {
  scree::command::CompareArguments& options = arguments.compare;
  options.parameters = scree::command::read_parameters(arguments.settings);
  options.isa = scree::command::read_isa(arguments.isa);
  std::vector<NamedFile> inputs;
  if (scree::command::is_scene_file(options.scene)) inputs.push_back({"SCENE", options.scene});
  check_files(arguments, inputs);
  print(scree::command::compare_solvers(options), arguments);
  return 0;
}

// Calls work(team). What it throws ends all processes.
template <class Work>
void on_team(const Work& work) {
  const std::unique_ptr<scree::command::Team> team = scree::command::make_team();
  try {
    work(*team);
  } catch (const scree::Error& error) {
    team->fail(error, kBadInput);
  } catch (const std::exception& error) {
    team->fail(error, kFailed);
  }
}

int run_scene(Arguments& arguments) {
  scree::command::RunOptions& options = arguments.options;
  options.parameters = scree::command::read_parameters(arguments.settings);
  options.isa = scree::command::read_isa(arguments.isa);
  std::vector<NamedFile> inputs;
  if (scree::command::is_scene_file(options.scene)) inputs.push_back({"SCENE", options.scene});
  // A run may go on from the file that it writes anew.
  if (!options.resume.empty() && options.resume != options.checkpoint)
    inputs.push_back({"--resume", options.resume});
  check_files(arguments, inputs);
  if (!options.distributed) {
    print(scree::command::run(options, nullptr), arguments);
    return 0;
  }
  on_team([&](scree::command::Team& team) {
    const scree::command::RunFigures figures = scree::command::run(options, &team);
    if (team.leads()) print(figures, arguments);
  });
  return 0;
}

int render(Arguments& arguments) {
  scree::command::RenderOptions& options = arguments.render;
  options.parameters = scree::command::read_parameters(arguments.settings);
  options.isa = scree::command::read_isa(arguments.isa);
  if (scree::command::is_scene_file(options.source)) options.taken.push_back({"SOURCE", options.source});
  check_files(arguments, options.taken);
  if (!arguments.json.empty() && !arguments.json_to_standard_output())
    options.taken.push_back({"--json", arguments.json});
  print(scree::command::render_pictures(options), arguments);
  return 0;
}

int extract(Arguments& arguments) {
  scree::command::ExtractOptions& options = arguments.extract;
  options.isa = scree::command::read_isa(arguments.isa);
  check_files(arguments, {{"FILE", options.file}});
  const scree::command::ExtractFigures figures = scree::command::extract_signals(options);
  scree::files::write_file({"--out", options.output}, figures.bytes);
  print(figures, arguments);
  return 0;
}

int export_recording(Arguments& arguments) {
  scree::command::ExportOptions& options = arguments.exported;
  options.isa = scree::command::read_isa(arguments.isa);
  check_files(arguments, {{"FILE", options.file}});
  const scree::command::ExportFigures figures = scree::command::export_show(options);
  scree::files::write_file({arguments.view.save.empty() ? "--out" : "--save", options.output}, figures.bytes);
  print(figures, arguments);
  return 0;
}

int view(Arguments& arguments) {
  scree::command::ViewOptions& options = arguments.view;
  options.parameters = scree::command::read_parameters(arguments.settings);
  options.isa = scree::command::read_isa(arguments.isa);
  if (options.save.empty()) {
    view_sources(options);
    return 0;
  }
  if (!options.save.ends_with(".html"))
    throw scree::Error("--save " + options.save + ": the name of the file must end in .html");
  if (options.sources.size() != 1 || !scree::command::is_recording_file(options.sources.front()))
    throw scree::Error("--save " + options.save + ": takes one recording");
  if (!options.parameters.empty())
    throw scree::Error("--set " + options.parameters.begin()->first + ": a recording has no parameters");
  arguments.exported.file = options.sources.front();
  arguments.exported.output = options.save;
  arguments.exported.threads = options.threads;
  return export_recording(arguments);
}

int replay(Arguments& arguments) {
  arguments.replay.isa = scree::command::read_isa(arguments.isa);
  check_files(arguments, {{"FILE", arguments.replay.file}});
  scree::command::ReplayFigures figures;
  if (!arguments.replay.distributed) {
    figures = scree::command::replay(arguments.replay);
    print(figures, arguments);
  } else {
    on_team([&](scree::command::Team& team) {
      figures = scree::command::replay(arguments.replay, team);
      if (team.leads()) print(figures, arguments);
    });
  }
  return figures.divergence ? kFailed : 0;
}

int show_info(const Arguments& arguments) {
  check_files(arguments, {{"FILE", arguments.info_file}});
  print(scree::command::inspect(arguments.info_file), arguments);
  return 0;
}

int diff(Arguments& arguments) {
  arguments.diff.isa = scree::command::read_isa(arguments.isa);
  check_files(arguments, {{"A", arguments.diff.a}, {"B", arguments.diff.b}});
  const scree::command::DiffFigures figures = scree::command::diff(arguments.diff);
  print(figures, arguments);
  return figures.divergence ? kFailed : 0;
}

// CLI11 reports help and version as exceptions, which are no errors.
int tell(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out;
  const int code = app.exit(error, out, std::cerr);
  scree::files::write_standard_output(out.str());
  return code == 0 ? 0 : kBadInput;
}

int run_command(int argc, char** argv) {
  CLI::App app("Scree simulates very large piles of rigid bodies, fast and with the same bits everywhere.",
               "scree");
  app.require_subcommand(0,
                         1);  // without a subcommand our own message appears: CLI11's hides a misspelled one
  app.set_version_flag("--version", "scree " SCREE_VERSION, "Print the version and exit");
  const CLI::App* scenes = app.add_subcommand("scenes", "List the built-in scenes");
  CLI::App* run = app.add_subcommand("run", "Run a scene and print its figures");
  CLI::App* replay_command = app.add_subcommand("replay", "Play a recording, or verify it");
  CLI::App* render_command = app.add_subcommand("render", "Draw pictures of a scene or a recording");
  CLI::App* export_command =
      app.add_subcommand("export", "Turn a recording into an animation for other viewers");
  CLI::App* extract_command = app.add_subcommand("extract", "Read signals off a recording into a file");
  CLI::App* view_command =
      app.add_subcommand("view", "Look at a scene or a recording in a browser, and play with it");
  CLI::App* info_command = app.add_subcommand("info", "Print the content of a recording");
  CLI::App* diff_command = app.add_subcommand("diff", "Find the first step at which two recordings diverge");
  CLI::App* compare_command = app.add_subcommand("compare", "Run a scene under every solver");
  CLI::App* fclib_command = app.add_subcommand("fclib", "Write a step's contact problem in the FCLIB format");
  CLI::App* decompose_command = app.add_subcommand("decompose", "Divide a closed mesh into convex hulls");
  CLI::App* hull_command = app.add_subcommand("hull", "Build the convex hull of a file's points");
  CLI::App* mass_command = app.add_subcommand("mass", "Measure mass, center and inertia of a closed mesh");
  CLI::App* accuracy_command = app.add_subcommand("accuracy", "Measure errors against known truth");
  Arguments arguments;
  declare_compare(*compare_command, arguments);
  declare_decompose(*decompose_command, arguments);
  declare_fclib(*fclib_command, arguments);
  declare_hull(*hull_command, arguments);
  declare_mass(*mass_command, arguments);
  declare_accuracy(*accuracy_command, arguments.accuracy, false);
  declare_export(*export_command, arguments);
  declare_extract(*extract_command, arguments);
  declare_render(*render_command, arguments);
  declare_view(*view_command, arguments);
  declare_run(*run, arguments);
  declare_replay(*replay_command, arguments);
  declare_info(*info_command, arguments);
  declare_diff(*diff_command, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return tell(app, error);
  }
  if (scenes->parsed()) {
    scree::files::write_standard_output(scene_list());
    return 0;
  }
  if (run->parsed()) return run_scene(arguments);
  if (replay_command->parsed()) return replay(arguments);
  if (export_command->parsed()) return export_recording(arguments);
  if (extract_command->parsed()) return extract(arguments);
  if (render_command->parsed()) return render(arguments);
  if (view_command->parsed()) return view(arguments);
  if (info_command->parsed()) return show_info(arguments);
  if (diff_command->parsed()) return diff(arguments);
  if (accuracy_command->parsed()) {
    run_accuracy(arguments.accuracy, {scree::accuracy::scree_engine(SCREE_VERSION)}, SCREE_VERSION);
    return 0;
  }
  if (compare_command->parsed()) return compare_solvers(arguments);
  if (fclib_command->parsed()) return write_fclib(arguments);
  if (decompose_command->parsed()) return decompose_file(arguments);
  if (hull_command->parsed()) return build_hull(arguments);
  if (mass_command->parsed()) return measure_mass(arguments);
  throw scree::Error("nothing to do; say `scree scenes`, `scree run SCENE` or `scree --help`");
}

}  // namespace

int main(int argc, char** argv) {
  scree::files::prepare_process();
  try {
    return run_command(argc, argv);
  } catch (const scree::Error& error) {
    std::cerr << "scree: " << error.what() << "\n";
    return kBadInput;
  } catch (const std::bad_alloc&) {
    std::cerr << "scree: out of memory\n";
    return kFailed;
  } catch (const std::exception& error) {
    std::cerr << "scree: " << error.what() << "\n";
    return kFailed;
  }
}
