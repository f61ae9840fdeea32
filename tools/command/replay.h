// What the command does with recordings: plays, verifies, describes and compares them.
// replay_report.cpp shows the figures.
#pragma once

#include <scree/recording.h>
#include <scree/scree.h>
#include <tools/command/trace.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace scree::command {

class Team;

struct ReplayOptions {
  std::string file;
  bool verify = false;
  int threads = 0;  // 0: one per core
  Isa isa = Isa::automatic;
  std::optional<std::uint64_t> from;  // step counters; default: the recording's first and last
  std::optional<std::uint64_t> to;
  bool quiet = false;        // no progress
  std::string trace;         // file for a timeline; empty: none
  bool distributed = false;  // needs a team
};

struct ReplayFigures {
  std::string file;
  bool verified = false;  // with every hash and every keyframe compared
  Isa isa = Isa::scalar;
  int threads = 1;
  int ranks = 0;  // 0: it was not distributed
  std::uint64_t from = 0;
  std::uint64_t to = 0;
  std::uint64_t steps = 0;      // played, of those between
  std::uint64_t keyframes = 0;  // after `from`, up to `to`
  double ms_mean = 0.0;         // per step; of a verification with its comparisons
  double ms_median = 0.0;       // this and the next two not of a verification
  double ms_min = 0.0;
  double ms_max = 0.0;
  std::uint64_t hash = 0;                      // where it ended
  std::optional<std::uint64_t> recorded_hash;  // of that step
  std::optional<Divergence> divergence;
  std::optional<TraceFigures> trace;
};

// Throws scree::Error for bad options and for files that are no recordings.
ReplayFigures replay(const ReplayOptions& options);
// Each process has its part of the world; all of them call it together.
ReplayFigures replay(const ReplayOptions& options, Team& team);

// Throws scree::Error, which names the option, where `from` or `to` is no step of the recording or `from`
// lies beyond `to`.
void check_span(const RecordingInfo& info, std::uint64_t from, std::uint64_t to);

struct InfoFigures {
  std::string file;
  RecordingInfo info;
  std::vector<std::uint64_t> keyframe_steps;
  std::uint64_t first_bodies = 0;  // at the first step
  std::uint64_t first_shapes = 0;
  std::uint64_t last_bodies = 0;  // at the last keyframe
  std::uint64_t last_shapes = 0;
};

InfoFigures inspect(const std::string& file);

struct DiffOptions {
  std::string a;
  std::string b;
  int threads = 0;
  Isa isa = Isa::automatic;
};

struct DiffFigures {
  std::string a;
  std::string b;
  std::uint64_t first_a = 0;
  std::uint64_t last_a = 0;
  std::uint64_t first_b = 0;
  std::uint64_t last_b = 0;
  std::optional<Divergence> divergence;

  // The steps that both recordings have.
  std::uint64_t from() const { return first_a > first_b ? first_a : first_b; }
  std::uint64_t to() const { return last_a < last_b ? last_a : last_b; }
};

DiffFigures diff(const DiffOptions& options);

std::string to_table(const ReplayFigures& figures);
std::string to_json(const ReplayFigures& figures);
std::string to_table(const InfoFigures& figures);
std::string to_json(const InfoFigures& figures);
std::string to_table(const DiffFigures& figures);
std::string to_json(const DiffFigures& figures);

}  // namespace scree::command
