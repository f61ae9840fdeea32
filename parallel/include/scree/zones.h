// Zones: what a step does and when, for profilers.
#pragma once

#include <cstdint>

namespace scree {

/// What a zone spans. A step holds phases, a phase holds stages, and a stage holds its chunks, which may be
/// on other threads. Where the threads share many worlds instead of one, a stage comes first, and its chunks
/// hold the steps of the worlds. Queries of many, and what else is shared between steps, have stages of their
/// own outside of any step.
enum class ZoneKind : std::uint8_t {
  step,   ///< one step of one world
  phase,  ///< scree::Phase; find_pairs comes twice and list_events several times
  stage,  ///< work that threads share, with a barrier at its end
  chunk,  ///< a part of a stage, on one thread
};

/// A stretch of time on the thread that is in it.
struct Zone {
  ZoneKind kind = ZoneKind::step;  ///< what it spans
  /// "step", scree::phase_name(), or the name of the function that shares out the stage, which its chunks
  /// have, too; stays valid as long as the program runs.
  const char* name = "";
  /// Of a step: the steps that the world has taken before. Of a stage: its number of chunks; 0 for
  /// a small one that one thread does by itself. Of a chunk: which it is, from 0 on. Of a phase: its Phase.
  std::int64_t number = 0;
};

/// Functions that are called when zones begin and end, so that a profiler can draw them, on the thread that
/// is in the zone and on several threads at once. On each thread zones nest, and each that begins ends, also
/// where an exception leaves it. The functions must not touch the worlds, and add their own time to what they
/// measure: a step of 10,000 bodies has about 150 stages and 3,000 chunks. Results do not depend on them.
/// None is called after the steps and queries with the Workers have returned.
struct ZoneHooks {
  void (*begin)(void* context, const Zone& zone) noexcept = nullptr;  ///< null: zones are not reported
  void (*end)(void* context, const Zone& zone) noexcept = nullptr;    ///< null as `begin` is
  void* context = nullptr;  ///< handed to both; must live as long as anything runs with the Workers
};

}  // namespace scree
