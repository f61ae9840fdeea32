// How much memory is in use at once. Only sanitizers tell of every allocation, so elsewhere it is never more
// than nothing.
#pragma once

#include <tests/fuzz/targets.h>

#include <cstddef>

namespace scree::fuzz {

class MemoryWatch {
 public:
  MemoryWatch();  // from here on
  // The most bytes at once, beyond those in use at the beginning.
  std::size_t peak() const;
  // Throws BrokenLaw where `who` has taken more than the bound for so many bytes of input.
  void require_within(const MemoryBound& bound, std::size_t input_bytes, const char* who) const;

 private:
  std::int64_t begin_;
};

// Whether allocations are told at all.
bool memory_is_watched();

// Prints, when the program ends, the largest share of a bound that anybody has taken: to be called once.
void tell_memory_at_exit();

}  // namespace scree::fuzz
