// Laws of the kernels' code as memory.
#include <gtest/gtest.h>
#include <parallel/crew/kernel_code.h>
#include <scree/scree.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#if defined(__linux__)
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace scree {
namespace {

// Code instrumented for a sanitizer exceeds the size that the library preloads.
#if defined(__linux__) && defined(MADV_POPULATE_READ) && !defined(SCREE_SANITIZED)

// Whether the system supports the request: Linux before 5.14 does not.
bool brings_in(std::span<const std::byte> memory) {
  return madvise(const_cast<std::byte*>(memory.data()), 4096, MADV_POPULATE_READ) == 0;
}

// Resident pages of a range of memory, as the system reports them; -1: no report.
std::int64_t pages_there(std::span<const std::byte> memory) {
  constexpr std::uintptr_t kPageBytes = 4096;
  constexpr std::uint64_t kPresent = std::uint64_t{1} << 63;
  std::vector<std::uint64_t> entries(memory.size() / kPageBytes);
  const auto size = static_cast<ssize_t>(entries.size() * sizeof(std::uint64_t));
  const auto page = static_cast<off_t>(reinterpret_cast<std::uintptr_t>(memory.data()) / kPageBytes);
  const int map = open("/proc/self/pagemap", O_RDONLY | O_CLOEXEC);
  if (map < 0) return -1;
  const bool told = pread(map, entries.data(), entries.size() * sizeof(std::uint64_t), page * 8) == size;
  close(map);
  if (!told) return -1;
  const auto is_there = [](std::uint64_t entry) { return (entry & kPresent) != 0; };
  return std::count_if(entries.begin(), entries.end(), is_there);
}

TEST(KernelCode, IsInMemoryOnceWorkersExist) {
  const Workers workers(1);
  const auto set = static_cast<simd::InstructionSet>(static_cast<int>(workers.isa()) - 1);
  const std::span<const std::byte> code = code_of(*simd::find_kernels(set));
  EXPECT_GT(code.size(), 100'000u);
  EXPECT_LT(code.size(), 8'000'000u);
  const std::int64_t there = pages_there(code);
  if (there < 0 || !brings_in(code)) GTEST_SKIP() << "the system does not tell, or does not do it";
  EXPECT_EQ(there, static_cast<std::int64_t>(code.size() / 4096));
}

#endif

}  // namespace
}  // namespace scree
