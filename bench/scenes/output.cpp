// Entries -> text and JSON.
#include "bench/scenes/output.h"

#include "bench/engine.h"
#include "bench/scenes/machine.h"

#include <nlohmann/json.hpp>

#include <ostream>
#include <sstream>

namespace scree::bench {
namespace {

// Numbers of runs and repeats.
std::string runs(const Options& options) {
  if (options.repeats == 1) return "1 run";
  std::ostringstream text;
  text << options.repeats << " runs in turn";
  if (options.patience > 0.0) text << " (1 where it takes more than " << options.patience << " s)";
  return text.str();
}

std::string protocol(const Options& options) {
  std::ostringstream text;
  if (!options.stand.empty()) {
    text << "Steps until a body that was on top is below " << kCollapseHeight
         << " of its first height, at most " << options.max_steps << ".";
    return text.str();
  }
  text << options.warmup << " untimed step" << (options.warmup == 1 ? "" : "s")
       << ", then total time over timed steps; median of " << runs(options)
       << ", each in its own process; quality at the end by one evaluator from poses and "
          "velocities.";
  return text.str();
}

std::string engine_line(const EngineInfo& info) {
  return info.title + ": " + info.settings + (info.multithreaded ? "" : ", single-threaded") +
         "; continuous collision: " + (info.continuous.empty() ? "none" : info.continuous);
}

// Without the single steps, which would be most of the file.
nlohmann::ordered_json json_of(const Measurement& measurement) {
  auto json = nlohmann::ordered_json::parse(to_json(measurement));
  json.erase("step_ms");
  return json;
}

}  // namespace

void print_report(const Options& options, const std::vector<Entry>& entries, std::ostream& out,
                  bool markdown) {
  const std::string item = markdown ? "- " : "";
  for (const auto& [name, value] : describe_machine()) out << item << name << ": " << value << '\n';
  for (const std::string& name : options.engines) out << item << engine_line(find_engine(name)) << '\n';
  out << item << protocol(options) << "\n\n";
  const Table table = options.stand.empty() ? comparison(entries, entries.front().engine) : standing(entries);
  markdown ? print_markdown(table, out) : print_aligned(table, out);
  const std::vector<std::string> lines = remarks(entries);
  if (!lines.empty()) out << '\n';
  for (const std::string& line : lines) out << item << line << '\n';
}

void print_brief(const Options& options, const std::vector<Entry>& entries, std::ostream& out) {
  std::string names;
  for (const auto& [name, value] : describe_machine()) {
    if (name != "load") names += (names.empty() ? "" : "; ") + name + ": " + value;
  }
  out << names << ". Medians of " << runs(options) << ".\n\n";
  print_markdown(brief(entries, entries.front().engine), out);
}

void write_json(const Options& options, const std::vector<Entry>& entries, std::ostream& out) {
  nlohmann::ordered_json document;
  for (const auto& [name, value] : describe_machine()) document["machine"][name] = value;
  document["protocol"] = protocol(options);
  const std::size_t equals = options.sweep.find('=');
  document["sweep"] = equals == std::string::npos ? "" : options.sweep.substr(0, equals);
  for (const std::string& name : options.engines) {
    const EngineInfo& info = find_engine(name);
    document["engines"][name] = {{"title", info.title},
                                 {"settings", info.settings},
                                 {"continuous", info.continuous},
                                 {"multithreaded", info.multithreaded}};
  }
  document["entries"] = nlohmann::ordered_json::array();
  for (const Entry& entry : entries) {
    nlohmann::ordered_json item{{"scene", entry.scene},
                                {"name", entry.name},
                                {"parameters", entry.parameters},
                                {"engine", entry.engine},
                                {"title", entry.title},
                                {"threads", entry.threads},
                                {"threads_used", entry.threads_used}};
    if (const Measurement* m = median_repeat(entry)) {
      item["ms_per_step"] = m->ms_per_step;
      item["bodies"] = m->bodies;
      item["phases"] = m->phases;
      const StepTimes times = step_times(entry);
      item["step_ms"] = {
          {"mean", times.mean}, {"median", times.median}, {"p999", times.p999}, {"worst", times.worst}};
    }
    item["repeats"] = nlohmann::ordered_json::array();
    for (const Measurement& m : entry.repeats) item["repeats"].push_back(json_of(m));
    if (entry.quality) item["quality"] = json_of(*entry.quality);
    document["entries"].push_back(std::move(item));
  }
  out << document.dump(1) << '\n';
}

}  // namespace scree::bench
