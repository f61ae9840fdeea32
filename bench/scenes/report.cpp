// The tables: medians, ratios and their cells.
#include "bench/scenes/report.h"

#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <ostream>

namespace scree::bench {
namespace {

// Share of the time in which a single thread must have had a processor for its time to count.
constexpr double kUndisturbed = 0.97;

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string millimeters(double meters) { return number("%.3f", meters * 1e3); }

// Prints enough digits to show a percent, for any size.
std::string time_cell(double ms) { return number(ms < 1.0 ? "%.4f" : ms < 100.0 ? "%.3f" : "%.1f", ms); }

std::vector<const Measurement*> by_time(const Entry& entry) {
  std::vector<const Measurement*> good;
  for (const Measurement& repeat : entry.repeats) {
    if (repeat.error.empty()) good.push_back(&repeat);
  }
  std::sort(good.begin(), good.end(),
            [](const Measurement* a, const Measurement* b) { return a->ms_per_step < b->ms_per_step; });
  return good;
}

const Measurement* find_median(const std::vector<Entry>& entries, const std::string& scene,
                               const std::string& engine, int threads) {
  for (const Entry& entry : entries) {
    if (entry.scene == scene && entry.engine == engine && entry.threads == threads)
      return median_repeat(entry);
  }
  return nullptr;
}

std::string threads_cell(const Entry& entry) {
  const std::string asked = std::to_string(entry.threads);
  return entry.threads_used == entry.threads ? asked
                                             : asked + " (uses " + std::to_string(entry.threads_used) + ")";
}

std::vector<std::string> quality_cells(const Measurement& m) {
  return {millimeters(m.penetration_mean),  millimeters(m.penetration_p999), millimeters(m.penetration_max),
          number("%.4g", m.kinetic_energy), number("%.4f", m.top_drop),      std::to_string(m.bodies_left),
          std::to_string(m.awake)};
}

// Columns that only some tables have.
struct Extra {
  bool pooled = false;  // over all evaluated steps
  bool drift = false;   // of joints
};

Extra extra_columns(const std::vector<Entry>& entries) {
  Extra extra;
  for (const Entry& entry : entries) {
    const Measurement* m = median_repeat(entry);
    extra.pooled = extra.pooled || entry.quality.has_value();
    extra.drift = extra.drift || (m != nullptr && m->drift_joints > 0);
  }
  return extra;
}

std::vector<std::string> comparison_row(const std::vector<Entry>& entries, const Entry& entry,
                                        const std::string& baseline, Extra extra) {
  std::vector<std::string> row{entry.scene, threads_cell(entry), entry.title};
  const Measurement* m = median_repeat(entry);
  if (m == nullptr) {
    row.push_back("failed");
    return row;
  }
  row.push_back(m->continuous);
  const auto sorted = by_time(entry);
  row.push_back(time_cell(m->ms_per_step));
  row.push_back(time_cell(sorted.front()->ms_per_step) + " to " + time_cell(sorted.back()->ms_per_step));
  const StepTimes times = step_times(entry);
  for (const double ms : {times.mean, times.median, times.p999, times.worst}) row.push_back(time_cell(ms));
  const Measurement* base = find_median(entries, entry.scene, baseline, entry.threads);
  row.push_back(base != nullptr ? number("%.2f", m->ms_per_step / base->ms_per_step) : "");
  const Measurement* single = find_median(entries, entry.scene, entry.engine, 1);
  const bool scales = single != nullptr && entry.threads_used > 1;
  row.push_back(scales ? number("%.2f", single->ms_per_step / m->ms_per_step) : "");
  row.push_back(std::to_string(m->touching));
  row.push_back(m->touching > 0 ? number("%.0f", m->ms_per_step * 1e6 / static_cast<double>(m->touching))
                                : "");
  for (std::string& cell : quality_cells(*m)) row.push_back(std::move(cell));
  if (extra.pooled) {
    const bool known = entry.quality && entry.quality->error.empty() && entry.quality->pooled_pairs > 0;
    row.push_back(known ? millimeters(entry.quality->pooled_mean) : "");
    row.push_back(known ? millimeters(entry.quality->pooled_p999) : "");
  }
  if (extra.drift) {
    const bool pooled = entry.quality && entry.quality->error.empty();
    const bool any = m->drift_joints > 0;
    row.push_back(any ? std::to_string(m->drift_joints) : "");
    row.push_back(any ? millimeters(m->drift_mean) : "");
    row.push_back(any ? millimeters(m->drift_max) : "");
    if (extra.pooled) {
      row.push_back(any && pooled ? millimeters(entry.quality->pooled_drift_mean) : "");
      row.push_back(any && pooled ? millimeters(entry.quality->pooled_drift_max) : "");
    }
  }
  row.push_back(number("%.0f", static_cast<double>(m->peak_bytes) / (1024.0 * 1024.0)));
  return row;
}

}  // namespace

const Measurement* median_repeat(const Entry& entry) {
  const auto sorted = by_time(entry);
  return sorted.empty() ? nullptr : sorted[(sorted.size() - 1) / 2];
}

StepTimes step_times(const Entry& entry) {
  std::vector<std::vector<double>> repeats;
  for (const Measurement& repeat : entry.repeats) {
    if (repeat.error.empty()) repeats.push_back(repeat.step_ms);
  }
  return step_times(repeats);
}

Table comparison(const std::vector<Entry>& entries, const std::string& baseline) {
  const Extra extra = extra_columns(entries);
  Table table{{"scene",      "threads",     "engine",      "continuous",   "ms/step",    "range",
               "mean",       "median",      "p99.9",       "worst",        "ratio",      "scaling",
               "touching",   "ns/touching", "pen mean mm", "pen p99.9 mm", "pen max mm", "energy J",
               "top drop m", "left",        "awake"}};
  const auto add_columns = [&table](std::initializer_list<const char*> names) {
    table.front().insert(table.front().end(), names.begin(), names.end());
  };
  if (extra.pooled) add_columns({"all steps mean mm", "all steps p99.9 mm"});
  if (extra.drift) add_columns({"joints", "drift mean mm", "drift max mm"});
  if (extra.drift && extra.pooled) add_columns({"all steps drift mean mm", "all steps drift max mm"});
  table.front().push_back("MiB");
  for (const Entry& entry : entries) table.push_back(comparison_row(entries, entry, baseline, extra));
  return table;
}

Table brief(const std::vector<Entry>& entries, const std::string& baseline) {
  Table table{{"scene", "threads", "engine", "continuous", "ms/step", "ratio", "1 to n threads",
               "ns per contact", "penetration mean, p99.9 (mm)", "energy (J)", "left"}};
  const Extra extra = extra_columns(entries);
  if (extra.drift) table.front().push_back("joint drift mean, max (mm)");
  for (const Entry& entry : entries) {
    const Measurement* m = median_repeat(entry);
    // Shows entries that do not get faster with more threads once.
    if (m == nullptr || (entry.threads_used != entry.threads && entry.threads > 1)) continue;
    const Measurement* base = find_median(entries, entry.scene, baseline, entry.threads);
    const Measurement* single = find_median(entries, entry.scene, entry.engine, 1);
    const bool scales = single != nullptr && entry.threads_used > 1;
    const bool pooled = entry.quality && entry.quality->error.empty() && entry.quality->pooled_pairs > 0;
    const Measurement& quality = pooled ? *entry.quality : *m;
    const double mean = pooled ? quality.pooled_mean : quality.penetration_mean;
    const double p999 = pooled ? quality.pooled_p999 : quality.penetration_p999;
    const double touching = static_cast<double>(m->touching);
    table.push_back({entry.scene, threads_cell(entry), entry.title, m->continuous,
                     number("%.2f", m->ms_per_step),
                     base != nullptr ? number("%.2f", m->ms_per_step / base->ms_per_step) : "",
                     scales ? number("%.2f", single->ms_per_step / m->ms_per_step) : "",
                     m->touching > 0 ? number("%.0f", m->ms_per_step * 1e6 / touching) : "",
                     number("%.2f, ", mean * 1e3) + number("%.3g", p999 * 1e3),
                     number("%.3g", m->kinetic_energy), std::to_string(m->bodies_left)});
    if (!extra.drift) continue;
    const bool judged = entry.quality && entry.quality->error.empty();
    const double drift = judged ? entry.quality->pooled_drift_mean : m->drift_mean;
    const double worst = judged ? entry.quality->pooled_drift_max : m->drift_max;
    table.back().push_back(m->drift_joints > 0 ? number("%.3g, ", drift * 1e3) + number("%.3g", worst * 1e3)
                                               : "");
  }
  return table;
}

Table standing(const std::vector<Entry>& entries) {
  Table table{{"scene", "engine", "collapse at step", "steps done", "top drop m", "energy J", "pen mean mm",
               "pen max mm", "left"}};
  for (const Entry& entry : entries) {
    const Measurement* m = median_repeat(entry);
    if (m == nullptr) {
      table.push_back({entry.scene, entry.title, "failed"});
      continue;
    }
    table.push_back(
        {entry.scene, entry.title, m->collapse_step > 0 ? std::to_string(m->collapse_step) : "stands",
         std::to_string(m->steps_done), number("%.4f", m->top_drop), number("%.4g", m->kinetic_energy),
         millimeters(m->penetration_mean), millimeters(m->penetration_max), std::to_string(m->bodies_left)});
  }
  return table;
}

std::vector<std::string> remarks(const std::vector<Entry>& entries) {
  std::vector<std::string> lines;
  for (const Entry& entry : entries) {
    const std::string who = entry.title + " on " + entry.scene + ", threads " + threads_cell(entry) + ": ";
    std::string error, complaint;
    bool same_bits = true;
    for (const Measurement& repeat : entry.repeats) {
      if (!repeat.error.empty()) error = repeat.error;
      if (!repeat.complaint.empty()) complaint = repeat.complaint;
      same_bits = same_bits && repeat.bits == entry.repeats.front().bits;
    }
    if (!error.empty()) lines.push_back(who + error);
    if (!complaint.empty()) lines.push_back(who + complaint);
    if (error.empty() && !same_bits) lines.push_back(who + "the repeats end in different bits");
    const Measurement* m = median_repeat(entry);
    const Measurement* single = find_median(entries, entry.scene, entry.engine, 1);
    if (m != nullptr && entry.threads_used == 1 && m->cpu_ms_per_step < kUndisturbed * m->ms_per_step) {
      lines.push_back(who + "the machine was busy, the engine had a processor for only " +
                      number("%.0f %%", 100.0 * m->cpu_ms_per_step / m->ms_per_step) + " of the time");
    }
    if (error.empty() && same_bits && single != nullptr && m != nullptr && m->bits != single->bits) {
      lines.push_back(who + "other bits than with one thread");
    }
  }
  return lines;
}

void print_aligned(const Table& table, std::ostream& out) {
  std::vector<std::size_t> widths(table.front().size());
  for (const auto& row : table) {
    for (std::size_t column = 0; column < row.size(); ++column) {
      widths[column] = std::max(widths[column], row[column].size());
    }
  }
  for (const auto& row : table) {
    for (std::size_t column = 0; column < row.size(); ++column) {
      const std::string padding(widths[column] - row[column].size(), ' ');
      out << (column < 3 ? row[column] + padding : padding + row[column])
          << (column + 1 < row.size() ? "  " : "\n");
    }
  }
}

void print_markdown(const Table& table, std::ostream& out) {
  for (std::size_t r = 0; r < table.size(); ++r) {
    for (std::size_t column = 0; column < table.front().size(); ++column) {
      out << "| " << (column < table[r].size() ? table[r][column] : std::string{}) << ' ';
    }
    out << "|\n";
    if (r > 0) continue;
    for (std::size_t column = 0; column < table.front().size(); ++column)
      out << (column < 3 ? "|---" : "|---:");
    out << "|\n";
  }
}

}  // namespace scree::bench
