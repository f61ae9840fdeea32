// scree_bench_scenes: runs scenes engine after engine, in turn, and prints time and quality side by side.
//
// Start reading here: plan() turns the options into jobs (plan.h), measure_all() runs them in turn, each in a
// process of its own (measure.h), output.h writes the results.
#include "bench/engine.h"
#include "bench/scenes/measure.h"
#include "bench/scenes/output.h"
#include "bench/scenes/plan.h"
#include "tools/files/output_file.h"

#include <CLI/CLI.hpp>

#include <iostream>
#include <sstream>

namespace scree::bench {
namespace {

void progress(const Job& job, const std::string& what) {
  std::cerr << job.entry.scene << ", " << job.entry.engine << ", " << job.request.threads << " thread"
            << (job.request.threads == 1 ? "" : "s") << ": " << what << std::endl;
}

void measure_one(Job& job) {
  const Measurement result = measure_in_child(job.request);
  if (!result.error.empty()) {
    progress(job, result.error);
  } else if (job.request.stand_steps > 0) {
    progress(job, result.collapse_step > 0 ? "collapsed at step " + std::to_string(result.collapse_step)
                                           : "stands after " + std::to_string(result.steps_done) + " steps");
  } else {
    progress(job, std::to_string(result.ms_per_step) + " ms/step");
  }
  if (!result.variant.empty()) job.entry.title = find_engine(job.request.engine).title + " " + result.variant;
  job.entry.repeats.push_back(result);
}

// Of its last run.
double seconds_of(const Job& job) {
  if (job.entry.repeats.empty()) return 0.0;
  const Measurement& last = job.entry.repeats.back();
  return 1e-3 * last.ms_per_step * last.timed_steps;
}

// Runs jobs in turn: every engine and thread count of a scene once, then all of them again, so that a drift
// of the machine affects all of them equally.
void measure_all(const Options& options, std::vector<Job>& jobs) {
  const int repeats = options.stand.empty() ? options.repeats : 1;
  for (std::size_t first = 0; first < jobs.size();) {
    std::size_t last = first;
    while (last < jobs.size() && jobs[last].entry.scene == jobs[first].entry.scene) ++last;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      for (std::size_t i = first; i < last; ++i) {
        if (jobs[i].same_as != i) continue;
        if (options.patience > 0.0 && seconds_of(jobs[i]) > options.patience) continue;
        measure_one(jobs[i]);
      }
    }
    for (std::size_t i = first; i < last && options.evaluate_every > 0 && options.stand.empty(); ++i) {
      if (jobs[i].same_as != i || jobs[i].entry.threads != options.threads.front()) continue;
      Request request = jobs[i].request;
      request.evaluate_every = options.evaluate_every;
      jobs[i].entry.quality = measure_in_child(request);
      progress(jobs[i], "evaluated every " + std::to_string(options.evaluate_every) + " steps");
    }
    first = last;
  }
  for (Job& job : jobs) {
    const Entry& source = jobs[job.same_as].entry;
    job.entry.repeats = source.repeats;
    job.entry.quality = source.quality;
    job.entry.title = source.title;
  }
}

void list_all() {
  std::cout << "engines\n";
  for (const EngineInfo& info : engines()) {
    std::cout << "  " << info.name << ": " << info.title << "; " << info.settings
              << (info.multithreaded ? "" : "; single-threaded") << '\n';
  }
  std::cout << "scenes\n";
  for (const scenes::SceneInfo& info : scenes::catalog()) {
    std::cout << "  " << info.name << ": " << info.summary;
    const char* separator = " (";
    for (const auto& [name, value] : info.parameters) {
      std::cout << separator << name << '=' << value;
      separator = ", ";
    }
    std::cout << (info.parameters.empty() ? "\n" : ")\n");
  }
}

const CLI::Validator kNotEmpty(
    [](std::string& name) { return name.empty() ? std::string("the name of the file is empty") : ""; }, "",
    "not empty");

// The files that the options name.
std::vector<files::NamedFile> outputs_of(const Options& options) {
  std::vector<files::NamedFile> outputs;
  for (const files::NamedFile& file :
       {files::NamedFile{"--markdown", options.markdown_file},
        files::NamedFile{"--brief", options.brief_file}, files::NamedFile{"--json", options.json_file}}) {
    if (!file.path.empty()) outputs.push_back(file);
  }
  return outputs;
}

template <class Print>
void write(const files::NamedFile& file, const Print& print) {
  if (file.path.empty()) return;
  std::ostringstream text;
  print(text);
  files::write_file(file, text.str());
}

int compare(const Options& options) {
  std::vector<Job> jobs = plan(options);
  if (jobs.empty()) throw Error("nothing to measure");
  files::check_outputs({}, outputs_of(options));  // a bad name must not cost a long run
  measure_all(options, jobs);
  std::vector<Entry> entries;
  bool all_good = true;
  for (Job& job : jobs) {
    all_good = all_good && median_repeat(job.entry) != nullptr;
    entries.push_back(std::move(job.entry));
  }
  print_report(options, entries, std::cout, false);
  write({"--json", options.json_file}, [&](std::ostream& out) { write_json(options, entries, out); });
  write({"--markdown", options.markdown_file},
        [&](std::ostream& out) { print_report(options, entries, out, true); });
  write({"--brief", options.brief_file}, [&](std::ostream& out) { print_brief(options, entries, out); });
  return all_good ? 0 : 1;
}

}  // namespace
}  // namespace scree::bench

int main(int argc, char** argv) {
  using namespace scree::bench;
  if (argc == 3 && std::string(argv[1]) == "--child") return child_main(argv[2]);
  scree::files::prepare_process();
  Options options;
  options.engines = default_engines();
  CLI::App app{"Runs scenes engine after engine and prints time and quality side by side."};
  app.add_option("--scenes", options.scenes, "scenes, as name or name:key=value:key=value")->delimiter(',');
  app.add_option("--sweep", options.sweep, "every scene once for each value: key=value,value,...");
  app.add_option("--engines", options.engines, "engines; ratios are against the first one")->delimiter(',');
  app.add_option("--isa", options.isas, "instruction sets of Scree: auto, scalar, sse2, avx2, avx512")
      ->delimiter(',');
  app.add_option("--threads", options.threads, "thread counts")->delimiter(',')->check(CLI::Range(1, 1024));
  app.add_option("--continuous", options.continuous, "continuous collision: on, off, or as the scene has it")
      ->check(CLI::IsMember({"scene", "on", "off"}));
  app.add_option("--steps", options.steps, "steps, the untimed ones included; default: the scene's")
      ->check(CLI::Range(2, 1'000'000));
  app.add_option("--warmup", options.warmup, "untimed first steps")->check(CLI::Range(0, 1'000'000));
  app.add_option("--repeats", options.repeats, "runs in turn, of which the median counts")
      ->check(CLI::Range(1, 1000));
  app.add_option("--patience", options.patience, "seconds; a run that takes longer is not repeated")
      ->check(CLI::Range(1e-9, 1e9));
  app.add_option("--evaluate-every", options.evaluate_every, "one more run, evaluated every K steps")
      ->check(CLI::Range(1, 1'000'000));
  app.add_option("--stand", options.stand, "instead: step these stacks until they collapse")->delimiter(',');
  app.add_option("--max-steps", options.max_steps, "with --stand: largest number of steps")
      ->check(CLI::Range(1, 10'000'000));
  app.add_option("--markdown", options.markdown_file, "also write the table to this file")->check(kNotEmpty);
  app.add_option("--brief", options.brief_file, "also write a short table in Markdown to this file")
      ->check(kNotEmpty);
  app.add_option("--json", options.json_file, "also write all figures to this file")->check(kNotEmpty);
  app.add_flag("--list", options.list, "list engines and scenes");
  int exit_code = 0;
  try {
    app.parse(argc, argv);
    if (options.list) {
      list_all();
    } else {
      exit_code = compare(options);
    }
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error);
  } catch (const scree::Error& error) {
    std::cerr << "scree_bench_scenes: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& exception) {
    std::cerr << "scree_bench_scenes: " << exception.what() << '\n';
    return 1;
  }
  try {
    scree::files::write_standard_output("");  // what was printed is there, too
  } catch (const std::exception& exception) {
    std::cerr << "scree_bench_scenes: " << exception.what() << '\n';
    return 1;
  }
  return exit_code;
}
