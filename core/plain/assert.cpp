// What a failed SCREE_ASSERT does. See core/plain/assert.h.
#include <core/plain/assert.h>

#include <cstdio>
#include <cstdlib>

namespace scree {

void fail_assertion(const char* condition, const char* file, int line) noexcept {
  std::fprintf(stderr, "scree: %s:%d: assertion failed: %s\n", file, line, condition);
  std::fflush(stderr);
  std::abort();
}

}  // namespace scree
