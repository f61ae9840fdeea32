// Options -> jobs. Refuses all invalid options here, before hours of measuring.
#include "bench/scenes/plan.h"

#include "bench/engine.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace scree::bench {
namespace {

double parse_number(const std::string& text, const std::string& where) {
  std::istringstream stream(text);
  double value = 0.0;
  if (!(stream >> value) || !stream.eof() || !std::isfinite(value)) {
    throw Error(where + ": \"" + text + "\" is not a finite number");
  }
  return value;
}

// "pile:bodies=10000" is the scene pile with that parameter.
void parse_scene(const std::string& text, Request& request) {
  std::istringstream stream(text);
  std::getline(stream, request.scene, ':');
  for (std::string part; std::getline(stream, part, ':');) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw Error("scene " + text + ": \"" + part + "\" is not key=value");
    }
    const std::string key = part.substr(0, equals);
    if (request.parameters.contains(key)) throw Error("scene " + text + ": " + key + " is given twice");
    request.parameters[key] = parse_number(part.substr(equals + 1), "scene " + text);
  }
  scenes::check(request.scene, request.parameters);
}

// The requested scenes, or each of them once for every value of the sweep.
std::vector<std::string> swept_scenes(const Options& options) {
  if (options.sweep.empty()) return options.scenes;
  const std::size_t equals = options.sweep.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error("--sweep " + options.sweep + ": expected key=value,value,...");
  }
  const std::string key = options.sweep.substr(0, equals);
  std::vector<std::string> scenes;
  for (const std::string& scene : options.scenes) {
    std::istringstream values(options.sweep.substr(equals + 1));
    for (std::string value; std::getline(values, value, ',');) {
      parse_number(value, "--sweep " + options.sweep);
      scenes.push_back(scene + ":" + key + "=" + value);
    }
  }
  if (scenes.empty()) throw Error("--sweep " + options.sweep + ": expected key=value,value,...");
  return scenes;
}

void add_jobs(const Options& options, const std::string& scene, int threads, std::vector<Job>& jobs) {
  for (const std::string& name : options.engines) {
    const EngineInfo& info = find_engine(name);
    const std::vector<std::string> isas = name == "scree" ? options.isas : std::vector<std::string>{"auto"};
    for (const std::string& isa : isas) {
      Job job;
      parse_scene(scene, job.request);
      job.request.engine = name;
      job.request.isa = isa;
      job.request.continuous = options.continuous;
      job.request.threads = info.multithreaded ? threads : 1;
      job.request.steps = options.steps;
      job.request.warmup = options.warmup;
      job.entry.scene = scene;
      job.entry.name = job.request.scene;
      job.entry.parameters = job.request.parameters;
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

}  // namespace

// ODE takes part only by name: it is an order of magnitude slower and would dominate the running time.
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

std::vector<Job> plan(const Options& options) {
  std::vector<Job> jobs;
  if (!options.stand.empty()) {
    for (const std::string& scene : options.stand) {
      add_jobs(options, scene, *std::max_element(options.threads.begin(), options.threads.end()), jobs);
    }
    for (Job& job : jobs) job.request.stand_steps = options.max_steps;
    return jobs;
  }
  for (const std::string& scene : swept_scenes(options)) {
    for (const int threads : options.threads) add_jobs(options, scene, threads, jobs);
  }
  return jobs;
}

}  // namespace scree::bench
