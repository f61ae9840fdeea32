// scree_bench_scenes: runs scenes engine after engine, in turn, and prints time and quality side by side.
//
// Start reading here: plan() turns the options into entries, measure_all() runs them in turn, each in a
// process of its own (measure.h), report.h makes the tables.
#include "bench/engine.h"
#include "bench/scenes/machine.h"
#include "bench/scenes/measure.h"
#include "bench/scenes/report.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <sstream>

namespace scree::bench {
namespace {

struct Options {
  std::vector<std::string> scenes{"large_pyramid", "many_pyramids"};
  std::vector<std::string> engines;
  std::vector<std::string> isas{"auto"};
  std::vector<int> threads{1, 2};
  std::vector<std::string> stand;
  int steps = 0;
  int max_steps = 3600;  // 60 s
  int warmup = 1;
  int repeats = 5;
  int evaluate_every = 0;
  std::string markdown_file;
  std::string json_file;
  bool list = false;
};

// ODE takes part only by name: an order of magnitude slower, it would rule the running time.
std::vector<std::string> default_engines() {
  std::vector<std::string> names;
  for (const EngineInfo& info : engines()) {
    if (info.name != "ode") names.push_back(info.name);
  }
  return names;
}

const EngineInfo& find_engine(const std::string& name) {
  for (const EngineInfo& info : engines()) {
    if (info.name == name) return info;
  }
  throw Error("unknown engine " + name + ", or this program was built without it (see --list)");
}

// "pile:count=10000" is the scene pile with that parameter.
void parse_scene(const std::string& text, Request& request) {
  std::istringstream stream(text);
  std::getline(stream, request.scene, ':');
  for (std::string part; std::getline(stream, part, ':');) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) throw Error("scene parameter without '=': " + part);
    try {
      request.parameters[part.substr(0, equals)] = std::stod(part.substr(equals + 1));
    } catch (const std::logic_error&) {
      throw Error("scene parameter without a number: " + part);
    }
  }
}

struct Job {
  Entry entry;
  Request request;
  std::size_t same_as = 0;  // the job whose measurements this one shares: its own index, or an earlier one's
};

void add_jobs(const Options& options, const std::string& scene, int threads, std::vector<Job>& jobs) {
  for (const std::string& name : options.engines) {
    const EngineInfo& info = find_engine(name);
    const std::vector<std::string> isas = name == "scree" ? options.isas : std::vector<std::string>{"auto"};
    for (const std::string& isa : isas) {
      Job job;
      parse_scene(scene, job.request);
      job.request.engine = name;
      job.request.isa = isa;
      job.request.threads = info.multithreaded ? threads : 1;
      job.request.steps = options.steps;
      job.request.warmup = options.warmup;
      job.entry.scene = scene;
      job.entry.engine = isas.size() > 1 ? name + ":" + isa : name;
      job.entry.title = info.title;
      job.entry.threads = threads;
      job.entry.threads_used = job.request.threads;
      job.same_as = jobs.size();
      for (std::size_t i = 0; i < jobs.size(); ++i) {
        const bool same = jobs[i].entry.scene == scene && jobs[i].entry.engine == job.entry.engine &&
                          jobs[i].request.threads == job.request.threads;
        if (same) job.same_as = std::min(job.same_as, i);
      }
      jobs.push_back(std::move(job));
    }
  }
}

std::vector<Job> plan(const Options& options) {
  std::vector<Job> jobs;
  if (!options.stand.empty()) {
    for (const std::string& scene : options.stand) {
      add_jobs(options, scene, *std::max_element(options.threads.begin(), options.threads.end()), jobs);
    }
    for (Job& job : jobs) job.request.stand_steps = options.max_steps;
    return jobs;
  }
  for (const std::string& scene : options.scenes) {
    for (const int threads : options.threads) add_jobs(options, scene, threads, jobs);
  }
  return jobs;
}

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

// In turn: every engine and thread count of a scene once, then all of them again, so that a machine that
// drifts does so for everybody.
void measure_all(const Options& options, std::vector<Job>& jobs) {
  const int repeats = options.stand.empty() ? options.repeats : 1;
  for (std::size_t first = 0; first < jobs.size();) {
    std::size_t last = first;
    while (last < jobs.size() && jobs[last].entry.scene == jobs[first].entry.scene) ++last;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      for (std::size_t i = first; i < last; ++i) {
        if (jobs[i].same_as == i) measure_one(jobs[i]);
      }
    }
    for (std::size_t i = first; i < last && options.evaluate_every > 0 && options.stand.empty(); ++i) {
      if (jobs[i].same_as != i || jobs[i].entry.threads != options.threads.front()) continue;
      Request request = jobs[i].request;
      request.evaluate_every = options.evaluate_every;
      jobs[i].entry.quality = measure_in_child(request);
      progress(jobs[i], "judged every " + std::to_string(options.evaluate_every) + " steps");
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

std::string protocol(const Options& options) {
  std::ostringstream text;
  if (!options.stand.empty()) {
    text << "Steps until a body that was on top is below " << kCollapseHeight
         << " of its first height, at most " << options.max_steps << ".";
    return text.str();
  }
  text << options.warmup << " untimed step" << (options.warmup == 1 ? "" : "s")
       << ", then total time over timed steps; median of " << options.repeats
       << " runs in turn, each in its own process; quality at the end by one evaluator from poses and "
          "velocities.";
  return text.str();
}

void print_report(const Options& options, const std::vector<Entry>& entries, std::ostream& out,
                  bool markdown) {
  const std::string item = markdown ? "- " : "";
  for (const auto& [name, value] : describe_machine()) out << item << name << ": " << value << '\n';
  for (const std::string& name : options.engines) {
    const EngineInfo& info = find_engine(name);
    out << item << info.title << ": " << info.settings << (info.multithreaded ? "" : ", single-threaded")
        << '\n';
  }
  out << item << protocol(options) << "\n\n";
  const Table table = options.stand.empty() ? comparison(entries, entries.front().engine) : standing(entries);
  markdown ? print_markdown(table, out) : print_aligned(table, out);
  const std::vector<std::string> lines = remarks(entries);
  if (!lines.empty()) out << '\n';
  for (const std::string& line : lines) out << item << line << '\n';
}

void write_json(const Options& options, const std::vector<Entry>& entries, std::ostream& out) {
  nlohmann::ordered_json document;
  for (const auto& [name, value] : describe_machine()) document["machine"][name] = value;
  document["protocol"] = protocol(options);
  document["entries"] = nlohmann::ordered_json::array();
  for (const Entry& entry : entries) {
    nlohmann::ordered_json item{{"scene", entry.scene},
                                {"engine", entry.engine},
                                {"title", entry.title},
                                {"threads", entry.threads},
                                {"threads_used", entry.threads_used}};
    if (const Measurement* m = median_repeat(entry)) item["ms_per_step"] = m->ms_per_step;
    item["repeats"] = nlohmann::ordered_json::array();
    for (const Measurement& m : entry.repeats)
      item["repeats"].push_back(nlohmann::ordered_json::parse(to_json(m)));
    if (entry.quality) item["quality"] = nlohmann::ordered_json::parse(to_json(*entry.quality));
    document["entries"].push_back(std::move(item));
  }
  out << document.dump(2) << '\n';
}

std::ofstream open_for_writing(const std::string& file) {
  std::ofstream stream(file);
  if (!stream) throw Error("cannot write " + file);
  return stream;
}

int compare(const Options& options) {
  std::vector<Job> jobs = plan(options);
  if (jobs.empty()) throw Error("nothing to measure");
  std::ofstream markdown, json;  // opened first: a bad name shall not cost a long run
  if (!options.markdown_file.empty()) markdown = open_for_writing(options.markdown_file);
  if (!options.json_file.empty()) json = open_for_writing(options.json_file);
  measure_all(options, jobs);
  std::vector<Entry> entries;
  bool all_good = true;
  for (Job& job : jobs) {
    all_good = all_good && median_repeat(job.entry) != nullptr;
    entries.push_back(std::move(job.entry));
  }
  print_report(options, entries, std::cout, false);
  if (markdown.is_open()) print_report(options, entries, markdown, true);
  if (json.is_open()) write_json(options, entries, json);
  return all_good ? 0 : 1;
}

}  // namespace
}  // namespace scree::bench

int main(int argc, char** argv) {
  using namespace scree::bench;
  if (argc == 3 && std::string(argv[1]) == "--child") return child_main(argv[2]);
  Options options;
  options.engines = default_engines();
  CLI::App app{"Runs scenes engine after engine and prints time and quality side by side."};
  app.add_option("--scenes", options.scenes, "scenes, as name or name:key=value:key=value")->delimiter(',');
  app.add_option("--engines", options.engines, "engines; ratios are against the first one")->delimiter(',');
  app.add_option("--isa", options.isas, "instruction sets of Scree: auto, scalar, sse2, avx2, avx512")
      ->delimiter(',');
  app.add_option("--threads", options.threads, "thread counts")->delimiter(',')->check(CLI::Range(1, 1024));
  app.add_option("--steps", options.steps, "steps, the untimed ones included; default: the scene's")
      ->check(CLI::Range(2, 1'000'000));
  app.add_option("--warmup", options.warmup, "untimed first steps")->check(CLI::Range(0, 1'000'000));
  app.add_option("--repeats", options.repeats, "runs in turn, of which the median counts")
      ->check(CLI::Range(1, 1000));
  app.add_option("--evaluate-every", options.evaluate_every, "one more run, judged every K steps")
      ->check(CLI::Range(1, 1'000'000));
  app.add_option("--stand", options.stand, "instead: step these stacks until they collapse")->delimiter(',');
  app.add_option("--max-steps", options.max_steps, "with --stand: at most so many")
      ->check(CLI::Range(1, 10'000'000));
  app.add_option("--markdown", options.markdown_file, "also write the table to this file");
  app.add_option("--json", options.json_file, "also write all figures to this file");
  app.add_flag("--list", options.list, "list engines and scenes");
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.list) {
      list_all();
      return 0;
    }
    return compare(options);
  } catch (const std::exception& exception) {
    std::cerr << "scree_bench_scenes: " << exception.what() << '\n';
    return 2;
  }
}
