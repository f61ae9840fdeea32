// See extract.h.
#include <tools/extract/extract.h>
#include <tools/files/recordings.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace scree::extract {
namespace {

// From a keyframe up to the next, or to the end.
struct Part {
  std::uint64_t begin = 0, end = 0;  // step counters
  bool has_begin = false;            // whether the state at `begin` is a sample of this part
  double duration = 0.0;             // s, of its steps after the first sample
  Samples samples;
  std::vector<EventRow> events;  // with times since the beginning of the part
};

std::vector<Part> divide(const Plan& plan, std::span<const std::uint64_t> keyframes) {
  std::vector<Part> parts;
  if (!is_parallel(plan.wanted)) {
    parts.push_back({keyframes.front(), plan.to, true, 0.0, {}, {}});
    return parts;
  }
  // What is of a step is known at `from` only if that step is played.
  const bool needs_step = std::any_of(plan.wanted.signals.begin(), plan.wanted.signals.end(),
                                      [](Signal signal) { return info_of(signal).of_steps; });
  auto after = std::upper_bound(keyframes.begin(), keyframes.end(), plan.from);
  if (needs_step && after - 1 != keyframes.begin() && after[-1] == plan.from) --after;
  for (auto begin = after - 1; begin != keyframes.end() && (parts.empty() || *begin < plan.to); ++begin) {
    const std::uint64_t end = begin + 1 != keyframes.end() ? std::min(plan.to, begin[1]) : plan.to;
    parts.push_back({*begin, end, parts.empty(), 0.0, {}, {}});
  }
  return parts;
}

bool is_sample(const Plan& plan, std::uint64_t step) {
  return step >= plan.from && step <= plan.to && (step - plan.from) % plan.every == 0;
}

void play(const Plan& plan, Player& player, Workers& workers, Part& part,
          const std::function<void(std::uint64_t)>& show) {
  // From the keyframe itself: a damaged one is found, whoever has played up to it.
  player.seek(player.info().first_step, workers);
  player.seek(part.begin, workers);
  const bool needs_centers = plan.wanted.has(Signal::contact_torque);
  const bool needs_contacts = needs_centers || plan.wanted.has(Signal::contact_force);
  PlayedStep played;
  if (part.has_begin && is_sample(plan, part.begin))
    add_sample(player.world(), plan.wanted, plan.choice, part.begin, 0.0, {}, part.samples);
  while (player.position() < part.end) {
    if (needs_centers && is_sample(plan, player.position() + 1)) {
      player.make_calls(workers);  // which may have put bodies elsewhere
      played.centers = centers_of_mass(player.world());
    }
    if (!player.step(workers)) break;
    played.dt = *player.recorded_dt();
    if (needs_contacts) note_awake(player.world(), played);
    const std::uint64_t step = player.position();
    if (step > plan.from) part.duration += double{played.dt};
    if (plan.wanted.events && step > plan.from)
      add_events(player.world(), plan.choice, step, part.duration, part.events);
    if (is_sample(plan, step))
      add_sample(player.world(), plan.wanted, plan.choice, step, part.duration, played, part.samples);
    show(1);
  }
  files::check_repeats(player, plan.file);
}

PlayerMeasures measures_for(const Wanted& wanted) {
  PlayerMeasures measures;
  measures.contact_forces = wanted.has(Signal::contact_force) || wanted.has(Signal::contact_torque);
  measures.residual = wanted.has(Signal::residual);
  measures.penetration = wanted.has(Signal::penetration);
  if (wanted.events) measures.contact_events = ContactEvents::begin_end | ContactEvents::hit;
  return measures;
}

// Plays parts until there are none. What a thread throws ends all.
class Crowd {
 public:
  Crowd(const Plan& plan, std::vector<Part>& parts,
        const std::function<void(std::uint64_t, std::uint64_t)>& show)
      : plan_(plan), parts_(parts), show_(show), steps_(parts.back().end - parts.front().begin) {}

  void run(int threads) {
    std::vector<std::thread> others;
    try {
      for (int i = 1; i < threads; ++i) others.emplace_back([this] { work(1); });
    } catch (const std::system_error&) {  // the system gives no more threads: those that there are do it all
    }
    // Alone it has all threads for itself.
    work(parts_.size() == 1 ? plan_.threads : 1);
    for (std::thread& other : others) other.join();
    if (failure_ != nullptr) std::rethrow_exception(failure_);
  }

 private:
  void work(int threads) {
    try {
      Player player = files::open_recording(plan_.file);
      player.measure(measures_for(plan_.wanted));
      Workers workers({.threads = threads, .isa = plan_.isa});
      for (std::size_t i = next_++; i < parts_.size() && !has_failed_; i = next_++)
        files::naming(plan_.file, [&] {
          play(plan_, player, workers, parts_[i], [this](std::uint64_t steps) { count(steps); });
        });
    } catch (...) {
      const std::lock_guard lock(mutex_);
      has_failed_ = true;
      if (failure_ == nullptr) failure_ = std::current_exception();
    }
  }

  void count(std::uint64_t steps) {
    const std::lock_guard lock(mutex_);
    show_(done_ += steps, steps_);
  }

  const Plan& plan_;
  std::vector<Part>& parts_;
  const std::function<void(std::uint64_t, std::uint64_t)>& show_;
  const std::uint64_t steps_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> has_failed_{false};
  std::mutex mutex_;
  std::uint64_t done_ = 0;
  std::exception_ptr failure_;
};

// The rows whose owners ever existed, ascending.
std::vector<std::uint32_t> rows_seen(const std::vector<Part>& parts, int kind) {
  std::vector<std::uint32_t> rows;
  std::size_t most = 0;
  for (const Part& part : parts) most = std::max(most, part.samples.seen[kind].size());
  for (std::size_t row = 0; row < most; ++row) {
    const bool is_seen = std::any_of(parts.begin(), parts.end(), [&](const Part& part) {
      return row < part.samples.seen[kind].size() && part.samples.seen[kind][row] != 0;
    });
    if (is_seen) rows.push_back(static_cast<std::uint32_t>(row));
  }
  return rows;
}

// Appends a part's values of a signal, of these rows alone.
void append(const Samples& samples, Signal signal, const std::vector<std::uint32_t>& rows, Values& to) {
  const SignalInfo& info = info_of(signal);
  const Values& from = samples.values[static_cast<std::size_t>(signal)];
  const auto width = static_cast<std::size_t>(info.width);
  to.is_wide = info.is_wide;
  std::size_t begin = 0;
  for (const Samples::Sample& sample : samples.samples) {
    const std::size_t count = info.owner == Owner::world ? 1 : sample.rows[info.owner == Owner::body ? 0 : 1];
    const std::size_t wanted = info.owner == Owner::world ? 1 : rows.size();
    for (std::size_t i = 0; i < wanted; ++i) {
      const std::size_t row = info.owner == Owner::world ? 0 : rows[i];
      for (std::size_t k = 0; k < width; ++k)
        to.add(row < count ? from[begin + row * width + k] : std::numeric_limits<double>::quiet_NaN());
    }
    begin += count * width;
  }
}

Extract join(const Plan& plan, std::vector<Part>& parts) {
  Extract all;
  all.wanted = plan.wanted;
  const std::vector<std::uint32_t> bodies = rows_seen(parts, 0);
  all.joints = rows_seen(parts, 1);
  for (const std::uint32_t row : bodies)
    all.bodies.push_back(plan.choice.all ? row : plan.choice.indices[row]);
  double time = 0.0;
  for (Part& part : parts) {
    for (const Samples::Sample& sample : part.samples.samples) {
      all.steps.push_back(sample.step);
      all.times.push_back(time + sample.time);
    }
    for (const Signal signal : plan.wanted.signals) {
      append(part.samples, signal, info_of(signal).owner == Owner::joint ? all.joints : bodies,
             all.values[static_cast<std::size_t>(signal)]);
    }
    for (EventRow& event : part.events) {
      event.time += time;
      all.events.push_back(event);
    }
    time += part.duration;
    part = {};
  }
  return all;
}

}  // namespace

bool is_parallel(const Wanted& wanted) {
  return !wanted.events && !wanted.has(Signal::contact_force) && !wanted.has(Signal::contact_torque);
}

Extract extract(const Plan& plan, const std::function<void(std::uint64_t, std::uint64_t)>& show) {
  std::vector<Part> parts;
  {
    const Player player = files::open_recording(plan.file);
    parts = divide(plan, player.keyframe_steps());
  }
  const int cores = Workers(plan.threads).threads();
  Crowd(plan, parts, show).run(std::min<int>(cores, static_cast<int>(parts.size())));
  return join(plan, parts);
}

}  // namespace scree::extract
