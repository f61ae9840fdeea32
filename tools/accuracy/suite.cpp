// The suite: checks the options, runs, and shows the figures.
#include <tools/accuracy/suite.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

namespace scree::accuracy {
namespace {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[128];
  std::snprintf(text, sizeof(text), pattern, values...);
  return text;
}

const EngineChoice& find_engine(const std::string& name, std::span<const EngineChoice> engines) {
  std::string names;
  for (const EngineChoice& engine : engines) {
    if (engine.name == name) return engine;
    names.append(names.empty() ? "" : ", ").append(engine.name);
  }
  throw Error("--engines " + name + ": unknown engine; there are: " + names);
}

std::vector<const EngineChoice*> chosen_engines(const SuiteOptions& options,
                                                std::span<const EngineChoice> engines) {
  std::vector<const EngineChoice*> chosen;
  for (const std::string& name : options.engines) chosen.push_back(&find_engine(name, engines));
  if (options.engines.empty()) {
    for (const EngineChoice& engine : engines) chosen.push_back(&engine);
  }
  return chosen;
}

std::vector<const Case*> chosen_cases(const SuiteOptions& options) {
  std::vector<const Case*> chosen;
  for (const std::string& name : options.cases) chosen.push_back(&find_case(name));
  if (options.cases.empty()) {
    for (const Case& one : catalog()) chosen.push_back(&one);
  }
  return chosen;
}

Entry measure(const Case& one, const EngineChoice& engine, double dt, int substeps, const Backend& backend) {
  Run run{.engine = &engine, .backend = backend, .dt = dt, .substeps = substeps};
  Entry entry{.of = &one, .engine = &engine, .dt = dt, .substeps = engine.substeps ? substeps : 0};
  try {
    entry.errors = one.measure(run);
  } catch (const Error& error) {
    entry.refusal = error.what();
    return entry;
  }
  // Short runs are timed three times: the machine may have been elsewhere.
  constexpr double kShort = 0.05;  // s
  entry.step_seconds = run.step_seconds;
  for (int again = 0; again < 2 && run.step_seconds < kShort; ++again) {
    Run repeat{.engine = &engine, .backend = backend, .dt = dt, .substeps = substeps};
    one.measure(repeat);
    entry.step_seconds = std::min(entry.step_seconds, repeat.step_seconds);
  }
  entry.simulated_seconds = run.simulated_seconds;
  entry.ms_per_second = 1000.0 * entry.step_seconds / run.simulated_seconds;
  return entry;
}

std::string number(double value) { return std::isfinite(value) ? format("%.3g", value) : "none"; }

std::string verdict(const Measure& measure, double error) {
  if (!measure.limit) return "";
  return error <= *measure.limit ? " ok" : " over";
}

std::string row(const Entry& entry) {
  std::string line = format("  %-8s %10.6g", entry.engine->name.c_str(), 1000.0 * entry.dt);
  line += entry.substeps > 0 ? format(" %8d", entry.substeps) : format(" %8s", "-");
  if (!entry.refusal.empty()) return line + "  " + entry.refusal + "\n";
  line += format(" %12.3g", entry.ms_per_second);
  for (std::size_t i = 0; i < entry.errors.size(); ++i) {
    const Measure& measure = entry.of->measures[i];
    line += format(" %18s", (number(entry.errors[i]) + verdict(measure, entry.errors[i])).c_str());
  }
  return line + "\n";
}

Solver solver_of(const Backend& backend) { return backend.solver.value_or(WorldSettings{}.solver); }

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (const std::size_t colon = line.find(": ");
        line.starts_with("model name") && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown processor";
}

std::string date() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d", &parts);
  return text;
}

std::string heading(const Case& one) {
  std::string text =
      one.name + ": " + one.scene + "\n  truth: " + one.truth + "\n  source: " + one.source + "\n";
  for (const Measure& measure : one.measures) {
    text.append("  ").append(measure.name);
    if (measure.unit != "1") text.append(" [").append(measure.unit).append("]");
    text.append(": ").append(measure.meaning);
    if (measure.limit) text += ", limit " + format("%g", *measure.limit);
    text += "\n";
  }
  text += format("  %-8s %10s %8s %12s", "engine", "dt [ms]", "substeps", "ms/s");
  for (const Measure& measure : one.measures) text += format(" %18s", measure.name.c_str());
  return text + "\n";
}

}  // namespace

void check(const SuiteOptions& options, std::span<const EngineChoice> engines) {
  chosen_cases(options);
  chosen_engines(options, engines);
  for (const double dt : options.time_steps) {
    if (!(dt > 0.0 && dt <= 0.1))
      throw Error("--dt " + format("%g", dt) + " must be above 0 and at most 0.1 seconds");
  }
  if (const auto hertz = options.backend.contact_hertz; hertz && !(*hertz >= 1e-3f && *hertz <= 1e4f)) {
    throw Error("--contact-hertz " + format("%g", static_cast<double>(*hertz)) +
                " must be from 0.001 to 10000 Hz");
  }
  constexpr int kMostIterations = 1'000'000;  // SolverOptions' limit
  if (const auto count = options.backend.iterations; count && (*count < 1 || *count > kMostIterations)) {
    throw Error("--iterations " + std::to_string(*count) + " must be from 1 to " +
                std::to_string(kMostIterations));
  }
  for (const int substeps : options.substeps) {
    if (substeps < 1 || substeps > 64) {
      throw Error("--substeps " + std::to_string(substeps) + " must be from 1 to 64");
    }
  }
}

std::vector<Entry> run_suite(const SuiteOptions& options, std::span<const EngineChoice> engines,
                             const std::function<void(const std::string&)>& show) {
  check(options, engines);
  std::vector<Entry> entries;
  for (const Case* one : chosen_cases(options)) {
    for (const EngineChoice* engine : chosen_engines(options, engines)) {
      for (const int substeps : options.substeps) {
        if (!engine->substeps && substeps != options.substeps.front()) continue;
        for (const double dt : options.time_steps) {
          show(one->name + ", " + engine->name + ", " + format("%g ms, %d substeps", 1000.0 * dt, substeps));
          entries.push_back(measure(*one, *engine, dt, substeps, options.backend));
        }
      }
    }
  }
  return entries;
}

std::string to_table(std::span<const Entry> entries, const Backend& backend) {
  std::string text;
  if (backend.solver || backend.iterations) {
    text.append("Scree's solver: ").append(solver_name(solver_of(backend)));
    if (backend.iterations) text += format(", iterations: %d", *backend.iterations);
    text += "\n\n";
  }
  const Case* last = nullptr;
  for (const Entry& entry : entries) {
    if (entry.of != last) text.append(last == nullptr ? "" : "\n").append(heading(*entry.of));
    last = entry.of;
    text += row(entry);
  }
  return text;
}

std::string to_json(std::span<const Entry> entries, const Backend& backend, const std::string& version) {
  nlohmann::ordered_json json;
  json["version"] = version;
  json["processor"] = processor();
  json["date"] = date();
  json["isa"] = isa_name(Workers(WorkersOptions{.threads = 1, .isa = backend.isa}).isa());
  json["threads"] = backend.threads;
  json["contact_hertz"] = static_cast<double>(backend.contact_hertz.value_or(WorldSettings{}.contact_hertz));
  json["solver"] = solver_name(solver_of(backend));
  json["iterations"] = backend.iterations.value_or(WorldSettings{}.solver_options.iterations);
  json["cases"] = nlohmann::ordered_json::array();
  json["entries"] = nlohmann::ordered_json::array();
  const Case* last = nullptr;
  for (const Entry& entry : entries) {
    if (entry.of != last) {
      nlohmann::ordered_json one{{"name", entry.of->name},
                                 {"scene", entry.of->scene},
                                 {"truth", entry.of->truth},
                                 {"source", entry.of->source}};
      for (const Measure& measure : entry.of->measures) {
        nlohmann::ordered_json item{
            {"name", measure.name}, {"unit", measure.unit}, {"meaning", measure.meaning}};
        item["limit"] =
            measure.limit ? nlohmann::ordered_json(*measure.limit) : nlohmann::ordered_json(nullptr);
        one["measures"].push_back(item);
      }
      json["cases"].push_back(one);
    }
    last = entry.of;
    nlohmann::ordered_json item{{"case", entry.of->name},
                                {"engine", entry.engine->name},
                                {"title", entry.engine->title},
                                {"dt", entry.dt},
                                {"substeps", entry.substeps}};
    if (!entry.refusal.empty()) {
      item["refusal"] = entry.refusal;
    } else {
      for (std::size_t i = 0; i < entry.errors.size(); ++i) {
        item["errors"][entry.of->measures[i].name] = entry.errors[i];  // null where not a number
      }
      item["ms_per_second"] = entry.ms_per_second;
      item["step_seconds"] = entry.step_seconds;
      item["simulated_seconds"] = entry.simulated_seconds;
    }
    json["entries"].push_back(item);
  }
  return json.dump(1) + "\n";
}

std::string list_of_cases() {
  std::string text;
  for (const Case& one : catalog()) text += format("%-14s ", one.name.c_str()) + one.scene + "\n";
  return text;
}

}  // namespace scree::accuracy
