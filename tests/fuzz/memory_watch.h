// Measures the peak of allocated memory. Only sanitizers report every allocation; elsewhere the peak reads as
// zero.
#pragma once

#include <tests/fuzz/targets.h>

#include <cstddef>

namespace scree::fuzz {

class MemoryWatch {
 public:
  MemoryWatch();  // from here on
  // Peak of bytes allocated beyond those at the beginning.
  std::size_t peak() const;
  // Throws BrokenLaw if `who` has taken more than the bound for this many bytes of input.
  void require_within(const MemoryBound& bound, std::size_t input_bytes, const char* who) const;

 private:
  std::int64_t begin_;
};

// Whether allocations are reported at all.
bool memory_is_watched();

// Prints, when the program ends, the largest share of a bound that any input has taken. To be called once.
void tell_memory_at_exit();

}  // namespace scree::fuzz
