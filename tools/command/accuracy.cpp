// `scree accuracy`: arguments -> suite -> tables and JSON.
#include <tools/command/accuracy.h>
#include <tools/command/options.h>
#include <tools/files/output_file.h>
#include <unistd.h>

#include <iostream>

namespace scree::command {

void declare_accuracy(CLI::App& app, AccuracyArguments& arguments, bool with_engines) {
  accuracy::SuiteOptions& options = arguments.options;
  app.add_option("--cases", options.cases, "Cases, separated by commas (default: all; see --list)")
      ->delimiter(',');
  app.add_option("--dt", options.time_steps,
                 "Time steps in seconds, separated by commas (default: 1/60, 10, 4, 1 ms)")
      ->delimiter(',');
  app.add_option("--substeps", options.substeps, "Solver substeps, 1 to 64, separated by commas (default: 4)")
      ->delimiter(',');
  if (with_engines) {
    app.add_option("--engines", options.engines,
                   "Engines, separated by commas (default: all that were found)")
        ->delimiter(',');
  }
  app.add_option("--threads", options.backend.threads, "Threads (default: 1; 0: one per core)");
  app.add_option("--isa", arguments.isa, "auto, scalar, sse2, avx2 or avx512 (default: auto)");
  app.add_option("--contact-hertz", options.backend.contact_hertz,
                 "Scree's WorldSettings::contact_hertz (default: 30)");
  app.add_option("--solver", arguments.solver,
                 "Scree's WorldSettings::solver: soft_step, sequential_impulse, jacobi, gauss_seidel, "
                 "over_relaxation, conjugate_gradient, accelerated_gradient or direct (default: soft_step)");
  app.add_option("--iterations", options.backend.iterations,
                 "Scree's SolverOptions::iterations, of solvers that iterate (default: 10)");
  app.add_option("--json", arguments.json, "Write the figures to FILE; - is standard output")
      ->type_name("FILE");
  app.add_flag("--list", arguments.list, "List the cases and exit");
  app.add_flag("--quiet", arguments.quiet, "No progress");
}

void run_accuracy(AccuracyArguments& arguments, const std::vector<accuracy::EngineChoice>& engines,
                  const std::string& version) {
  if (arguments.list) {
    files::write_standard_output(accuracy::list_of_cases());
    return;
  }
  accuracy::SuiteOptions& options = arguments.options;
  options.backend.isa = read_isa(arguments.isa);
  if (arguments.solver) options.backend.solver = read_solver(*arguments.solver);
  check_backend(options.backend.threads, options.backend.isa);
  accuracy::check(options, engines);
  const bool to_output = arguments.json == "-" || files::is_standard_stream(arguments.json, STDOUT_FILENO);
  const files::NamedFile json{"--json", arguments.json};
  if (!arguments.json.empty() && !to_output) files::check_outputs({}, {{json}});
  if (!arguments.quiet) tell_of_idle_threads(options.backend.threads);
  const auto show = [&](const std::string& what) {
    if (!arguments.quiet) std::cerr << "accuracy: " << what << std::endl;
  };
  const std::vector<accuracy::Entry> entries = accuracy::run_suite(options, engines, show);
  const std::string table = accuracy::to_table(entries, options.backend);
  if (to_output) {
    std::cerr << table << std::flush;
    files::write_standard_output(accuracy::to_json(entries, options.backend, version));
    return;
  }
  files::write_standard_output(table);
  if (!arguments.json.empty()) {
    files::write_file(json, accuracy::to_json(entries, options.backend, version));
  }
}

}  // namespace scree::command
