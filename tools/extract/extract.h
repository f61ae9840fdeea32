// Plays a recording again and reads signals off it, whatever was logged when it ran.
#pragma once

#include <scree/recording.h>
#include <tools/extract/read_world.h>
#include <tools/extract/signals.h>

#include <cstdint>
#include <functional>
#include <string>

namespace scree::extract {

struct Plan {
  std::string file;
  Wanted wanted;
  Choice choice;
  std::uint64_t from = 0, to = 0;  // step counters within the recording
  std::uint64_t every = 1;         // steps from one sample to the next, the first at `from`
  int threads = 0;                 // 0: one per core
  Isa isa = Isa::automatic;
};

// Whether the parts between keyframes are played at the same time, a thread for each. Contact events and
// forces depend on what came before a keyframe: for them the recording is played in one piece, from its
// beginning, by all threads together.
bool is_parallel(const Wanted& wanted);

// The same numbers for any number of threads and any instruction set. `show(done, all)` is called now and
// then with a count of steps. Throws Error for a recording that cannot be read and std::runtime_error for one
// that does not repeat.
Extract extract(const Plan& plan, const std::function<void(std::uint64_t, std::uint64_t)>& show);

}  // namespace scree::extract
