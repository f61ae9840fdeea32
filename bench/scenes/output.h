// What the program writes: the report for people, the table for the README, the figures for bench/plot.
#pragma once

#include "bench/scenes/plan.h"

#include <iosfwd>
#include <vector>

namespace scree::bench {

/// Machine, engines, protocol, the whole table and remarks.
void print_report(const Options& options, const std::vector<Entry>& entries, std::ostream& out,
                  bool markdown);
/// One sentence on machine and protocol, and the columns that matter most, in Markdown.
void print_brief(const Options& options, const std::vector<Entry>& entries, std::ostream& out);
/// Everything that was measured.
void write_json(const Options& options, const std::vector<Entry>& entries, std::ostream& out);

}  // namespace scree::bench
