// Records zones and writes them; see trace.h. Names of zones are those of functions, which need no escapes.
#include <tools/command/text.h>
#include <tools/command/trace.h>

#include <algorithm>
#include <new>
#include <utility>

namespace scree::command {
namespace {

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

const char* name_of(ZoneKind kind) {
  constexpr const char* kNames[] = {"step", "phase", "stage", "chunk"};
  return kNames[static_cast<int>(kind)];
}

// What Zone::number is called in the viewer; of phases it says nothing that the name does not.
const char* number_name(ZoneKind kind) {
  constexpr const char* kNames[] = {"step", nullptr, "chunks", "chunk"};
  return kNames[static_cast<int>(kind)];
}

// Without the arguments of a template, which compilers spell out.
std::string short_name(const char* name) {
  const std::string whole = name;
  return whole.substr(0, whole.find('<'));
}

double microseconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

}  // namespace

Trace::Trace(std::size_t most) : most_(most), number_(next_number()) { lane(); }
Trace::~Trace() = default;

ZoneHooks Trace::hooks() {
  return {[](void* trace, const Zone& zone) noexcept { static_cast<Trace*>(trace)->begin(zone); },
          [](void* trace, const Zone&) noexcept { static_cast<Trace*>(trace)->end(); }, this};
}

Trace::Lane& Trace::lane() {
  thread_local std::pair<std::uint64_t, Lane*> own{0, nullptr};
  if (own.first == number_) return *own.second;
  const std::lock_guard lock(mutex_);
  const std::thread::id thread = std::this_thread::get_id();
  const auto known =
      std::find_if(lanes_.begin(), lanes_.end(), [&](const auto& each) { return each->thread == thread; });
  if (known == lanes_.end()) {
    lanes_.push_back(std::make_unique<Lane>());
    lanes_.back()->thread = thread;
    own = {number_, lanes_.back().get()};
  } else {
    own = {number_, known->get()};
  }
  return *own.second;
}

void Trace::begin(const Zone& zone) noexcept {
  try {
    Lane& own = lane();
    const int depth = own.depth++;
    if (depth >= Lane::kDeepest) return;
    const Clock::time_point now = Clock::now();
    own.open[static_cast<std::size_t>(depth)] = {zone.name, zone.kind, zone.number, now, now};
  } catch (const std::bad_alloc&) {  // of a lane; the thread's zones are left out until there is one
  }
}

void Trace::end() noexcept {
  bool recorded = false;
  try {
    Lane& own = lane();
    const int depth = own.depth > 0 ? --own.depth : Lane::kDeepest;  // it began when there was no lane
    if (depth < Lane::kDeepest && !is_full()) {
      Event event = own.open[static_cast<std::size_t>(depth)];
      event.end = Clock::now();
      own.closed.push_back(event);
      recorded = true;
    }
  } catch (const std::bad_alloc&) {
  }
  (recorded ? recorded_ : left_out_).fetch_add(1, std::memory_order_relaxed);
}

void Trace::count(const std::vector<const StepStats*>& worlds) {
  if (is_full()) return;
  Counts counts{Clock::now(), 0, 0, 0, 0, 0.0};
  for (const StepStats* stats : worlds) {
    counts.contacts += stats->contacts;
    counts.awake_bodies += stats->awake_bodies;
    counts.islands += stats->islands;
    counts.colors += stats->colors;
    counts.lane_fill += stats->lane_fill / static_cast<double>(worlds.size());
  }
  counts_.push_back(counts);
}

std::string Trace::to_json() {
  std::string text = "{\"displayTimeUnit\": \"ms\", \"traceEvents\": [\n";
  text += R"({"name": "process_name", "ph": "M", "pid": 1, "args": {"name": "scree"}})";
  for (std::size_t thread = 0; thread < lanes_.size(); ++thread) {
    const auto number = static_cast<int>(thread);
    text += format(
        ",\n"
        R"({"name": "thread_name", "ph": "M", "pid": 1, "tid": %d, "args": {"name": "%s %d"}})",
        number, thread == 0 ? "calling thread" : "helper", number);
    // Zones end before those around them. Viewers want them as they begin, and the outer one first where two
    // begin in the same tick of the clock.
    std::vector<Event>& events = lanes_[thread]->closed;
    std::reverse(events.begin(), events.end());
    std::stable_sort(events.begin(), events.end(),
                     [](const Event& a, const Event& b) { return a.begin < b.begin; });
    for (const Event& event : events) {
      text += R"(,
{"name": ")" + short_name(event.name);
      text += format(R"(", "cat": "%s", "ph": "X", "pid": 1, "tid": %d, "ts": %.3f, "dur": %.3f)",
                     name_of(event.kind), number, microseconds(event.begin - start_),
                     microseconds(event.end - event.begin));
      if (const char* name = number_name(event.kind))
        text += format(R"(, "args": {"%s": %lld})", name, static_cast<long long>(event.number));
      text += "}";
    }
  }
  for (const Counts& counts : counts_) {
    const auto put = [&](const char* name, double value) {
      text += format(
          ",\n"
          R"({"name": "%s", "ph": "C", "pid": 1, "ts": %.3f, "args": {"%s": %.17g}})",
          name, microseconds(counts.time - start_), name, value);
    };
    put("contacts", static_cast<double>(counts.contacts));
    put("awake bodies", static_cast<double>(counts.awake_bodies));
    put("islands", static_cast<double>(counts.islands));
    put("colors", static_cast<double>(counts.colors));
    put("lane fill", counts.lane_fill);
  }
  text += "\n]}\n";
  return text;
}

TraceFigures Trace::finish(const std::string& file) {
  const std::lock_guard lock(mutex_);
  return {file, to_json(), recorded_.load(), left_out_.load()};
}

std::string trace_row(const TraceFigures& figures) {
  std::string zones = figures.file + ", " + grouped(figures.zones) + " zones";
  if (figures.left_out > 0) zones += ", " + grouped(figures.left_out) + " more left out";
  return row("trace", zones);
}

Workers make_workers(int threads, Isa isa, const std::string& file, std::optional<Trace>& trace) {
  if (!file.empty()) trace.emplace();
  return Workers({.threads = threads, .isa = isa, .zones = trace ? trace->hooks() : ZoneHooks{}});
}

}  // namespace scree::command
