// Figures -> table and JSON; see report.h.
#include <tools/command/report.h>
#include <tools/command/text.h>

#include <nlohmann/json.hpp>
#include <numeric>

namespace scree::command {
namespace {

// Counts are never negative.
std::uint64_t whole(std::int64_t count) { return static_cast<std::uint64_t>(count); }

std::string millimeters(double meters) { return format("%.4f mm", 1000.0 * meters); }

// The rest of the table of a distributed run; what a rank measures of its part alone says little.
std::string rank_rows(const RunFigures& figures) {
  std::string table = row("ranks", std::to_string(figures.ranks.size()));
  table +=
      row("  of the last step", "  bodies   ghosts contacts  messages      KiB  step ms  waiting   load");
  for (std::size_t rank = 0; rank < figures.ranks.size(); ++rank) {
    const RankStats& stats = figures.ranks[rank];
    table +=
        row("  rank " + std::to_string(rank),
            format("%8lld %8lld %8lld %9lld %8.1f %8.3f %8.3f %6.2f", static_cast<long long>(stats.bodies),
                   static_cast<long long>(stats.ghosts), static_cast<long long>(stats.contacts),
                   static_cast<long long>(stats.messages), static_cast<double>(stats.bytes) / 1024.0,
                   stats.step_ms, stats.waiting_ms, stats.load));
  }
  table += row("peak memory", mebibytes(figures.peak_memory_bytes) + " of rank 0");
  table += row("instruction set", isa_name(figures.isa));
  table += row("threads", std::to_string(figures.threads) + " a rank");
  table += row("hash", hash_digits(figures.hash));
  return table;
}

// What is measured over the whole world.
void add_quality(const RunFigures& figures, nlohmann::ordered_json& json) {
  json["overlaps"] = figures.overlaps;
  json["penetration"] = {{"mean", figures.penetration_mean},
                         {"p999", figures.penetration_p999},
                         {"max", figures.penetration_max}};
  json["residual"] = figures.residual;
  json["kinetic_energy"] = figures.kinetic_energy;
  json["lane_fill"] = figures.lane_fill;
  json["stages"] = figures.stages;
}

nlohmann::ordered_json rank_json(const RankStats& stats) {
  return {{"bodies", stats.bodies},
          {"awake_bodies", stats.awake_bodies},
          {"ghosts", stats.ghosts},
          {"contacts", stats.contacts},
          {"border_contacts", stats.border_contacts},
          {"messages", stats.messages},
          {"bytes", stats.bytes},
          {"step_ms", stats.step_ms},
          {"waiting_ms", stats.waiting_ms},
          {"load", stats.load}};
}

}  // namespace

std::string to_table(const RunFigures& figures) {
  std::string table = figures.scene + "\n";
  if (figures.worlds > 1) table += row("worlds", grouped(whole(figures.worlds)));
  table += row("bodies",
               grouped(whole(figures.bodies)) + " and " + grouped(whole(figures.fixed_bodies)) + " fixed");
  if (figures.joints > 0) table += row("joints", grouped(whole(figures.joints)));
  table += row("awake bodies", grouped(whole(figures.awake_bodies)));
  if (figures.restored_bodies > 0) table += row("restored bodies", grouped(whole(figures.restored_bodies)));
  table += row("contacts", grouped(whole(figures.contacts)));
  table += row("steps", format("%d of %.6g s with %d substeps, %d timed", figures.steps, figures.dt,
                               figures.substeps, figures.timed_steps));
  table += row("steps/s", format("%.1f", figures.steps_per_second()));
  table += row("ms per step", format("%.3f mean, %.3f median, %.3f min, %.3f max", figures.ms_mean,
                                     figures.ms_median, figures.ms_min, figures.ms_max));
  // The phases of worlds that are stepped concurrently add up to more than the step: shares are of the
  // phases' sum.
  const double all_phases = std::accumulate(figures.phase_ms.begin(), figures.phase_ms.end(), 0.0);
  for (std::size_t phase = 0; phase < kPhaseCount; ++phase) {
    const double share = all_phases > 0.0 ? 100.0 * figures.phase_ms[phase] / all_phases : 0.0;
    table += row(format("  %s", phase_name(static_cast<Phase>(phase))),
                 format("%9.3f ms %5.1f %%", figures.phase_ms[phase], share));
  }
  if (!figures.ranks.empty()) return table + rank_rows(figures);
  table += row("penetration", millimeters(figures.penetration_mean) + " mean, " +
                                  millimeters(figures.penetration_p999) + " p999, " +
                                  millimeters(figures.penetration_max) + " max");
  table += row("residual", format("%.3g m/s", figures.residual));
  table += row("kinetic energy", format("%.6g J", figures.kinetic_energy));
  table += row("peak memory", mebibytes(figures.peak_memory_bytes));
  table += row("lane fill", format("%.1f %%", 100.0 * figures.lane_fill));
  table += row("stages per step", grouped(whole(figures.stages)));
  if (const auto& recording = figures.recording) {
    table += row("recording", recording->file + ", " + mebibytes(recording->bytes) + " of " +
                                  grouped(recording->steps) + " steps");
  }
  if (figures.trace) table += trace_row(*figures.trace);
  if (figures.picture) table += picture_row(*figures.picture);
  table += row("instruction set", isa_name(figures.isa));
  table += row("threads", std::to_string(figures.threads));
  table += row("hash", hash_digits(figures.hash));
  return table;
}

std::string to_json(const RunFigures& figures) {
  nlohmann::ordered_json json;
  json["scene"] = figures.scene;
  json["isa"] = isa_name(figures.isa);
  json["threads"] = figures.threads;
  json["worlds"] = figures.worlds;
  json["steps"] = figures.steps;
  json["warmup"] = figures.warmup;
  json["timed_steps"] = figures.timed_steps;
  json["dt"] = figures.dt;
  json["substeps"] = figures.substeps;
  json["bodies"] = figures.bodies;
  json["fixed_bodies"] = figures.fixed_bodies;
  json["joints"] = figures.joints;
  json["awake_bodies"] = figures.awake_bodies;
  json["restored_bodies"] = figures.restored_bodies;
  json["contacts"] = figures.contacts;
  json["steps_per_second"] = figures.steps_per_second();
  json["ms_per_step"] = {{"mean", figures.ms_mean},
                         {"median", figures.ms_median},
                         {"min", figures.ms_min},
                         {"max", figures.ms_max}};
  nlohmann::ordered_json phases;
  for (std::size_t phase = 0; phase < kPhaseCount; ++phase) {
    phases[phase_name(static_cast<Phase>(phase))] = figures.phase_ms[phase];
  }
  json["phases"] = phases;
  if (figures.ranks.empty()) add_quality(figures, json);
  for (const RankStats& rank : figures.ranks) json["ranks"].push_back(rank_json(rank));
  json["peak_memory_bytes"] = figures.peak_memory_bytes;
  if (const auto& recording = figures.recording) {
    json["recording"] = {{"file", recording->file}, {"bytes", recording->bytes}, {"steps", recording->steps}};
  }
  if (const auto& trace = figures.trace) {
    json["trace"] = {{"file", trace->file}, {"zones", trace->zones}, {"left_out", trace->left_out}};
  }
  if (const auto& picture = figures.picture) {
    json["picture"] = {{"file", picture->file}, {"rays", picture->rays}, {"seconds", picture->seconds}};
  }
  json["hash"] = hash_digits(figures.hash);
  // A file's name may hold any bytes.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace scree::command
