// See extract.h.
#include <tools/command/clock.h>
#include <tools/command/extract.h>
#include <tools/command/options.h>
#include <tools/command/progress.h>
#include <tools/command/replay.h>
#include <tools/command/text.h>
#include <tools/extract/extract.h>
#include <tools/extract/tables.h>
#include <tools/files/recordings.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

namespace scree::command {
namespace {

constexpr std::uint64_t kMostSamples = 100'000'000;
constexpr std::uint32_t kMostIndex = 10'000'000;

[[noreturn]] void refuse_bodies(const std::string& text) {
  throw Error("--bodies " + text + ": expected all, or indices and spans of them up to " +
              std::to_string(kMostIndex) + ", such as 3,7-12");
}

// "3,7-12"
extract::Choice read_bodies(const std::string& text) {
  extract::Choice choice;
  if (text == "all") return choice;
  choice.all = false;
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto read = [&](std::uint32_t& number) {
    const auto [next, problem] = std::from_chars(at, end, number);
    if (problem != std::errc() || number > kMostIndex) refuse_bodies(text);
    at = next;
  };
  for (;;) {
    std::uint32_t first = 0, last = 0;
    read(first);
    last = first;
    if (at != end && *at == '-') {
      ++at;
      read(last);
    }
    if (last < first || (at != end && *at != ',')) refuse_bodies(text);
    for (std::uint32_t index = first; index <= last; ++index) choice.indices.push_back(index);
    if (at == end) break;
    ++at;
  }
  std::sort(choice.indices.begin(), choice.indices.end());
  choice.indices.erase(std::unique(choice.indices.begin(), choice.indices.end()), choice.indices.end());
  return choice;
}

bool is_table(const std::string& file) { return file.ends_with(".csv"); }

extract::Plan make_plan(const ExtractOptions& options) {
  check_backend(options.threads, options.isa);
  if (!is_table(options.output) && !options.output.ends_with(".npz"))
    throw Error("--out " + options.output + ": the name of the file must end in .npz or .csv");
  if (options.every == 0) throw Error("--every 0 must be at least 1");
  extract::Plan plan;
  plan.file = options.file;
  plan.wanted = extract::read_signals(options.signals);
  if (is_table(options.output)) extract::check_fits_csv(plan.wanted);
  plan.choice = read_bodies(options.bodies);
  plan.every = options.every;
  plan.threads = options.threads;
  plan.isa = options.isa;
  const RecordingInfo info = files::open_recording(options.file).info();
  plan.from = options.from.value_or(info.first_step);
  plan.to = options.to.value_or(info.last_step);
  check_span(info, plan.from, plan.to);
  if ((plan.to - plan.from) / plan.every >= kMostSamples)
    throw Error("--every " + std::to_string(plan.every) + ": there would be more than " +
                std::to_string(kMostSamples) + " samples");
  return plan;
}

}  // namespace

ExtractFigures extract_signals(const ExtractOptions& options) {
  const extract::Plan plan = make_plan(options);
  if (!options.quiet) tell_of_idle_threads(options.threads);
  const auto start = Clock::now();
  constexpr int kTicks = 1000;
  Progress progress(options.file, kTicks, !options.quiet);
  const extract::Extract all = extract::extract(plan, [&](std::uint64_t done, std::uint64_t steps) {
    progress.show(static_cast<int>(static_cast<double>(kTicks) * static_cast<double>(done) /
                                   static_cast<double>(std::max<std::uint64_t>(steps, 1))));
  });
  progress.finish();
  ExtractFigures figures;
  figures.file = options.file;
  figures.output = options.output;
  figures.bytes = is_table(options.output) ? extract::to_csv(all) : extract::to_npz(all);
  figures.from = plan.from;
  figures.to = plan.to;
  figures.samples = all.steps.size();
  figures.bodies = all.bodies.size();
  figures.joints = all.joints.size();
  figures.events = all.events.size();
  figures.seconds = seconds_since(start);
  const Workers workers({.threads = options.threads, .isa = options.isa});
  figures.isa = workers.isa();
  figures.threads = workers.threads();
  return figures;
}

std::string to_table(const ExtractFigures& figures) {
  std::string table = table_head(figures) + row("samples", grouped(figures.samples));
  if (figures.bodies > 0) table += row("bodies", grouped(figures.bodies));
  if (figures.joints > 0) table += row("joints", grouped(figures.joints));
  if (figures.events > 0) table += row("events", grouped(figures.events));
  return table + table_tail(figures);
}

std::string to_json(const ExtractFigures& figures) {
  nlohmann::ordered_json json = json_head(figures);
  json["joints"] = figures.joints;
  json["events"] = figures.events;
  return finish_json(std::move(json), figures);
}

}  // namespace scree::command
