// The command `scree`: reads the command line, runs, prints. Exit codes: 0 done, 1 a run failed or
// recordings differ, 2 bad input.
#include <tools/command/accuracy.h>
#include <tools/command/compare.h>
#include <tools/command/decompose.h>
#include <tools/command/fclib.h>
#include <tools/command/options.h>
#include <tools/command/render.h>
#include <tools/command/replay.h>
#include <tools/command/report.h>
#include <tools/command/run.h>
#include <tools/command/shape_files.h>
#include <tools/files/output_file.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

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

// Values of the command line, as text; checked when the run begins.
struct Arguments {
  bool json_to_standard_output() const {
    return json == "-" || scree::files::is_standard_stream(json, STDOUT_FILENO);
  }

  scree::command::RunOptions options;
  scree::command::ReplayOptions replay;
  scree::command::DiffOptions diff;
  scree::command::AccuracyArguments accuracy;
  scree::command::CompareArguments compare;
  scree::command::FclibArguments fclib;
  scree::command::DecomposeArguments decompose;
  scree::command::HullArguments hull;
  scree::command::MassArguments mass;
  scree::command::RenderOptions render;
  std::string info_file;
  std::vector<std::string> settings;
  std::string isa = "auto";
  std::string json;  // empty: none
};

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
  if (failure != nullptr) std::rethrow_exception(failure);
}

// An empty name is usually an unset variable of a script.
const CLI::Validator kNotEmpty(
    [](std::string& name) { return name.empty() ? std::string("the name of the file is empty") : ""; }, "",
    "not empty");

void declare_backend(CLI::App& app, int& threads, Arguments& arguments) {
  app.add_option("--threads", threads, "Threads (default 0: one per core)");
  app.add_option("--isa", arguments.isa, "auto, scalar, sse2, avx2 or avx512 (default: auto)");
}

void declare_json(CLI::App& app, Arguments& arguments) {
  app.add_option("--json", arguments.json, "Write the figures to FILE; - is standard output")
      ->type_name("FILE")
      ->check(kNotEmpty);
}

void declare_trace(CLI::App& app, std::string& file) {
  app.add_option("--trace", file, "Write a timeline of phases, stages and chunks, for Perfetto's viewer")
      ->type_name("FILE")
      ->check(kNotEmpty);
}

// What `scree render` says of all of its pictures, and `scree run` of the one that --picture names.
void declare_picture(CLI::App& app, scree::command::PictureOptions& options, CLI::Option* needed) {
  CLI::Option* const all[] = {
      app.add_option("--size", options.size, "WIDTHxHEIGHT in pixels (default: 1280x720)")
          ->type_name("WIDTHxHEIGHT"),
      app.add_option("--camera", options.camera,
                     "corner, front, side, top, or the eye and what it looks at as X,Y,Z or X,Y,Z,X,Y,Z "
                     "in meters (default: corner)"),
      app.add_option("--view", options.view,
                     "Degrees from the lower to the upper edge, 1 to 170 (default: 40)"),
      app.add_option("--color-by", options.color_by, "body, part, speed, sleep or type (default: body)"),
      app.add_flag("--rough", options.rough, "One ray a pixel: edges are not smooth, a third of the time"),
      app.add_flag("--walls", options.walls, "Draw fixed shapes that hide what moves, too")};
  for (CLI::Option* option : all) {
    if (needed != nullptr) option->needs(needed);
  }
}

void declare_render(CLI::App& render, Arguments& arguments) {
  scree::command::RenderOptions& options = arguments.render;
  render.add_option("SOURCE", options.source, "A recording, a built-in scene or a JSON scene file")
      ->required();
  render.add_option("--out", options.file, "The picture, FILE.png; those of a series are FILE-STEP.png")
      ->type_name("FILE.png")
      ->required()
      ->check(kNotEmpty);
  render.add_option("--at", options.at, "The step that it shows (default: the last)");
  render.add_option(
      "--every", options.every,
      "A series: steps from one picture to the next; and the film FILE.mp4 where ffmpeg is installed");
  render.add_option("--from", options.from, "The first step of a series (default: the first)");
  render.add_option("--to", options.to, "The last step of a series (default: the last)");
  render.add_option("--rate", options.rate, "Pictures a second of the film, 1 to 1000 (default: 30)");
  declare_picture(render, options.picture, nullptr);
  render.add_option("--set", arguments.settings, "key=value: a parameter of the scene; may be repeated")
      ->allow_extra_args(true)
      ->type_name("KEY=VALUE");
  declare_backend(render, options.threads, arguments);
  declare_json(render, arguments);
  render.add_flag("--quiet", options.quiet, "No progress");
}

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
  run.add_option("--solver", options.solver,
                 "soft_step, sequential_impulse, jacobi, gauss_seidel, "
                 "over_relaxation, conjugate_gradient, accelerated_gradient or "
                 "direct (default: the scene's)");
  run.add_option("--iterations", options.iterations, "Of solvers that iterate (default: the scene's)");
  declare_backend(run, options.threads, arguments);
  run.add_option("--warmup", options.warmup, "Untimed steps at the start (default: 1)");
  run.add_flag("--no-sleep", options.no_sleep, "Keep resting bodies awake");
  run.add_option("--record", options.record, "Record the world into FILE, for replay, info and diff")
      ->type_name("FILE")
      ->check(kNotEmpty);
  run.add_option("--keyframes", options.keyframes, "Steps between the recording's keyframes (default: 300)");
  declare_trace(run, options.trace);
  declare_picture(run, options.picture,
                  run.add_option("--picture", options.picture_file, "Draw the end into FILE.png")
                      ->type_name("FILE.png")
                      ->check(kNotEmpty));
  declare_json(run, arguments);
  run.add_flag("--quiet", options.quiet, "No progress");
}

void declare_replay(CLI::App& replay, Arguments& arguments) {
  scree::command::ReplayOptions& options = arguments.replay;
  replay.add_option("FILE", options.file, "A recording")->required();
  replay.add_flag("--verify", options.verify, "Compare every hash and the state at every keyframe");
  declare_backend(replay, options.threads, arguments);
  replay.add_option("--from", options.from, "The step to begin after (default: the recording's first)");
  replay.add_option("--to", options.to, "The last step (default: the recording's last)");
  declare_trace(replay, options.trace);
  declare_json(replay, arguments);
  replay.add_flag("--quiet", options.quiet, "No progress");
}

void declare_info(CLI::App& info, Arguments& arguments) {
  info.add_option("FILE", arguments.info_file, "A recording")->required();
  declare_json(info, arguments);
}

void declare_diff(CLI::App& diff, Arguments& arguments) {
  diff.add_option("A", arguments.diff.a, "A recording")->required();
  diff.add_option("B", arguments.diff.b, "Another recording")->required();
  declare_backend(diff, arguments.diff.threads, arguments);
  declare_json(diff, arguments);
}

void declare_compare(CLI::App& compare, Arguments& arguments) {
  scree::command::CompareArguments& options = arguments.compare;
  compare.add_option("SCENE", options.scene, "A built-in scene (see `scree scenes`) or a JSON scene file")
      ->required();
  compare.add_option("--set", arguments.settings, "key=value: a parameter of the scene; may be repeated")
      ->allow_extra_args(true)
      ->type_name("KEY=VALUE");
  compare.add_option("--solvers", options.solvers, "Some of them, separated by commas (default: all)")
      ->delimiter(',');
  compare
      .add_option("--counts", options.counts,
                  "Iterations to measure the residual after (default: 1,2,4..1024)")
      ->delimiter(',');
  compare.add_option("--at", options.at, "The step after which it is measured (default: 10)");
  compare.add_option("--steps", options.steps, "Of each run (default: the scene's, at most 600)");
  compare.add_option("--substeps", options.substeps, "Of the runs, 1 to 64 (default: the scene's)");
  compare.add_option("--iterations", options.iterations, "Of the runs (default: 30)");
  declare_backend(compare, options.threads, arguments);
  declare_json(compare, arguments);
}

void declare_fclib(CLI::App& fclib, Arguments& arguments) {
  scree::command::FclibArguments& options = arguments.fclib;
  fclib.add_option("SCENE", options.scene, "A built-in scene (see `scree scenes`) or a JSON scene file")
      ->required();
  fclib.add_option("FILE", options.file, "The file to write")->required()->check(kNotEmpty);
  fclib.add_option("--set", arguments.settings, "key=value: a parameter of the scene; may be repeated")
      ->allow_extra_args(true)
      ->type_name("KEY=VALUE");
  fclib.add_option("--at", options.at, "Steps before the one that is written (default: 10)");
  declare_backend(fclib, options.threads, arguments);
  declare_json(fclib, arguments);
}

void declare_shape_file(CLI::App& app, scree::command::ShapeFileArguments& options, Arguments& arguments) {
  app.add_option("FILE", options.file, "An OBJ or STL file, in meters")->required();
  app.add_option("--scale", options.scale, "Multiplies all coordinates: 0.001 for millimeters (default: 1)");
  declare_json(app, arguments);
}

void declare_hull(CLI::App& hull, Arguments& arguments) {
  declare_shape_file(hull, arguments.hull, arguments);
  hull.add_option("--max-vertices", arguments.hull.max_vertices, "4 to 256 (default: 256)");
  hull.add_option("--output", arguments.hull.output, "Write the hull as an OBJ file")
      ->type_name("FILE")
      ->check(kNotEmpty);
}

void declare_decompose(CLI::App& app, Arguments& arguments) {
  scree::command::DecomposeArguments& decompose = arguments.decompose;
  scree::DecomposeOptions& options = decompose.options;
  declare_shape_file(app, decompose, arguments);
  app.add_option("--concavity", options.concavity, "How far a hull may reach out of the mesh, in meters");
  app.add_option("--concavity-share", options.concavity_share,
                 "The same as a share of the mesh's largest extent, 0.001 to 1 (default: 0.02)");
  app.add_option("--max-parts", options.max_parts, "1 to 1024 (default: 64)");
  app.add_option("--max-vertices", options.max_vertices, "Of each hull, 4 to 256 (default: 64)");
  app.add_option("--resolution", options.resolution,
                 "Cells along the largest extent, 16 to 256, in which hulls are searched (default: 64)");
  app.add_option("--output", decompose.output, "Write the hulls as an OBJ file, an object each")
      ->type_name("FILE")
      ->check(kNotEmpty);
  app.add_option("--scene", decompose.scene, "Write a scene file with a body of the hulls")
      ->type_name("FILE")
      ->check(kNotEmpty);
}

void declare_mass(CLI::App& mass, Arguments& arguments) {
  declare_shape_file(mass, arguments.mass, arguments);
  mass.add_option("--density", arguments.mass.density, "kg/m^3 (default: 1000)");
  mass.add_flag("--hull", arguments.mass.of_hull, "Of the convex hull, for meshes that are not closed");
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

int run_scene(Arguments& arguments) {
  scree::command::RunOptions& options = arguments.options;
  options.parameters = scree::command::read_parameters(arguments.settings);
  options.isa = scree::command::read_isa(arguments.isa);
  std::vector<NamedFile> inputs;
  if (scree::command::is_scene_file(options.scene)) inputs.push_back({"SCENE", options.scene});
  check_files(arguments, inputs);
  print(scree::command::run(options), arguments);
  return 0;
}

int render(Arguments& arguments) {
  scree::command::RenderOptions& options = arguments.render;
  options.parameters = scree::command::read_parameters(arguments.settings);
  options.isa = scree::command::read_isa(arguments.isa);
  if (std::filesystem::exists(options.source)) options.taken.push_back({"SOURCE", options.source});
  check_files(arguments, options.taken);
  if (!arguments.json.empty() && !arguments.json_to_standard_output())
    options.taken.push_back({"--json", arguments.json});
  print(scree::command::render_pictures(options), arguments);
  return 0;
}

int replay(Arguments& arguments) {
  arguments.replay.isa = scree::command::read_isa(arguments.isa);
  check_files(arguments, {{"FILE", arguments.replay.file}});
  const scree::command::ReplayFigures figures = scree::command::replay(arguments.replay);
  print(figures, arguments);
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
  declare_render(*render_command, arguments);
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
  if (render_command->parsed()) return render(arguments);
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
