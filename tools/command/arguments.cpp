// See arguments.h.
#include <tools/command/arguments.h>

#include <cstdint>
#include <optional>

namespace scree::command {
namespace {

// An empty name is usually an unset variable of a script.
const CLI::Validator kNotEmpty(
    [](std::string& name) { return name.empty() ? std::string("the name of the file is empty") : ""; }, "",
    "not empty");

// CLI11 reads -1 as the largest count.
const CLI::Validator kCount(
    [](std::string& count) { return count.starts_with('-') ? count + " must be at least 0" : ""; }, "",
    "count");

void declare_count(CLI::App& app, const char* name, std::optional<std::uint64_t>& count, const char* help) {
  app.add_option(name, count, help)->check(kCount);
}

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

// `formats`: what the output's name may end in.
void declare_samples(CLI::App& app, SampledOptions& options, const char* formats, Arguments& arguments) {
  app.add_option("FILE", options.file, "A recording")->required();
  app.add_option("--out", options.output, formats)->type_name("FILE")->required()->check(kNotEmpty);
  app.add_option("--every", options.every, "Steps from one sample to the next (default: 1)")->check(kCount);
  declare_count(app, "--from", options.from, "The step of the first sample (default: the recording's first)");
  declare_count(app, "--to", options.to, "The last step (default: the recording's last)");
  declare_backend(app, options.threads, arguments);
  declare_json(app, arguments);
  app.add_flag("--quiet", options.quiet, "No progress");
}

// What `scree render` says of all of its pictures, and `scree run` of the one that --picture names.
void declare_picture(CLI::App& app, PictureOptions& options, CLI::Option* needed) {
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

void declare_shape_file(CLI::App& app, ShapeFileArguments& options, Arguments& arguments) {
  app.add_option("FILE", options.file, "An OBJ or STL file, in meters")->required();
  app.add_option("--scale", options.scale, "Multiplies all coordinates: 0.001 for millimeters (default: 1)");
  declare_json(app, arguments);
}

}  // namespace

void declare_render(CLI::App& render, Arguments& arguments) {
  RenderOptions& options = arguments.render;
  render.add_option("SOURCE", options.source, "A recording, a built-in scene or a JSON scene file")
      ->required();
  render.add_option("--out", options.file, "The picture, FILE.png; those of a series are FILE-STEP.png")
      ->type_name("FILE.png")
      ->required()
      ->check(kNotEmpty);
  declare_count(render, "--at", options.at, "The step that it shows (default: the last)");
  declare_count(
      render, "--every", options.every,
      "A series: steps from one picture to the next; and the film FILE.mp4 where ffmpeg is installed");
  declare_count(render, "--from", options.from, "The first step of a series (default: the first)");
  declare_count(render, "--to", options.to, "The last step of a series (default: the last)");
  render.add_option("--rate", options.rate, "Pictures a second of the film, 1 to 1000 (default: 30)");
  declare_picture(render, options.picture, nullptr);
  render.add_option("--set", arguments.settings, "key=value: a parameter of the scene; may be repeated")
      ->allow_extra_args(true)
      ->type_name("KEY=VALUE");
  declare_backend(render, options.threads, arguments);
  declare_json(render, arguments);
  render.add_flag("--quiet", options.quiet, "No progress");
}

void declare_extract(CLI::App& app, Arguments& arguments) {
  ExtractOptions& options = arguments.extract;
  app.add_option("--signal", options.signals, "One or more, separated by commas: pose, velocity, energy, ...")
      ->delimiter(',')
      ->required();
  app.add_option("--bodies", options.bodies, "Indices and spans of them, such as 3,7-12 (default: all)");
  declare_samples(app, options, "FILE.npz for NumPy, or FILE.csv", arguments);
}

void declare_run(CLI::App& run, Arguments& arguments) {
  RunOptions& options = arguments.options;
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
  run.add_flag("--no-continuous", options.no_continuous, "Do not sweep fast bodies");
  run.add_flag("--distributed", options.distributed,
               "Share the world out among the processes of mpirun, with the same hash");
  run.add_option("--latency", options.latency,
                 "With --distributed: microseconds that each message takes longer than it does, to 1e6");
  run.add_option("--record", options.record, "Record the world into FILE, for replay, info and diff")
      ->type_name("FILE")
      ->check(kNotEmpty);
  run.add_option("--keyframes", options.keyframes, "Steps between the recording's keyframes (default: 300)");
  run.add_option("--checkpoint", options.checkpoint, "Write the state into FILE now and then, for --resume")
      ->type_name("FILE")
      ->check(kNotEmpty);
  run.add_option("--checkpoint-steps", options.checkpoint_steps,
                 "Steps from one checkpoint to the next (default: 1000)");
  run.add_option(
         "--resume", options.resume,
         "Go on from a checkpoint of the same scene, in which as many steps are taken as there were; with "
         "any number of processes, and the same hash")
      ->type_name("FILE")
      ->check(kNotEmpty);
  declare_trace(run, options.trace);
  declare_picture(run, options.picture,
                  run.add_option("--picture", options.picture_file, "Draw the end into FILE.png")
                      ->type_name("FILE.png")
                      ->check(kNotEmpty));
  declare_json(run, arguments);
  run.add_flag("--quiet", options.quiet, "No progress");
}

void declare_replay(CLI::App& replay, Arguments& arguments) {
  ReplayOptions& options = arguments.replay;
  replay.add_option("FILE", options.file, "A recording")->required();
  replay.add_flag("--verify", options.verify, "Compare every hash and the state at every keyframe");
  declare_backend(replay, options.threads, arguments);
  declare_count(replay, "--from", options.from, "The step to begin after (default: the recording's first)");
  declare_count(replay, "--to", options.to, "The last step (default: the recording's last)");
  replay.add_flag("--distributed", options.distributed,
                  "Share the world out among the processes of mpirun, each of which compares its part");
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
  CompareArguments& options = arguments.compare;
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
  FclibArguments& options = arguments.fclib;
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

void declare_hull(CLI::App& hull, Arguments& arguments) {
  declare_shape_file(hull, arguments.hull, arguments);
  hull.add_option("--max-vertices", arguments.hull.max_vertices, "4 to 256 (default: 256)");
  hull.add_option("--output", arguments.hull.output, "Write the hull as an OBJ file")
      ->type_name("FILE")
      ->check(kNotEmpty);
}

void declare_decompose(CLI::App& app, Arguments& arguments) {
  DecomposeArguments& decompose = arguments.decompose;
  DecomposeOptions& options = decompose.options;
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

void declare_export(CLI::App& app, Arguments& arguments) {
  declare_samples(
      app, arguments.exported,
      "FILE.html, a page that plays in a browser; FILE.gltf or FILE.glb, for Blender and others; or "
      "FILE.mcap, for viewers of robotics",
      arguments);
}

void declare_view(CLI::App& app, Arguments& arguments) {
  ViewOptions& options = arguments.view;
  app.add_option("SOURCE", options.sources,
                 "A recording, a built-in scene or a JSON scene file; two of them are compared")
      ->required()
      ->expected(1, 2);
  app.add_option("--set", arguments.settings, "key=value: a parameter of the scene; may be repeated")
      ->allow_extra_args(true)
      ->type_name("KEY=VALUE");
  app.add_option("--port", options.port, "0 to 65535; 0: any free one (default: 7707)");
  app.add_option("--address", options.address, "Where to listen (default: 127.0.0.1, this machine alone)");
  app.add_flag("--open", options.open, "Open the page in a browser");
  app.add_option("--save", options.save, "Write a page that plays the recording without a server, and end")
      ->type_name("FILE.html")
      ->check(kNotEmpty);
  declare_backend(app, options.threads, arguments);
}

}  // namespace scree::command
