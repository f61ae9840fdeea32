// SCREE_ASSERT: what this library relies on of itself. Arguments of callers are checked by core/world/check.h
// instead, in every build.
#pragma once

namespace scree {

// Prints the condition and its place, and aborts.
[[noreturn]] void fail_assertion(const char* condition, const char* file, int line) noexcept;

}  // namespace scree

// Checks a condition in debug builds (the presets debug, asan, tsan and fuzz), where SCREE_ASSERTIONS is
// defined. In release builds the condition is compiled but never evaluated.
#ifdef SCREE_ASSERTIONS
#define SCREE_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : ::scree::fail_assertion(#condition, __FILE__, __LINE__))
#else
#define SCREE_ASSERT(condition) static_cast<void>(sizeof(!(condition)))
#endif
