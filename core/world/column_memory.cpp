// See column_memory.h. (Huge pages, by MADV_HUGEPAGE, gain 1 to 2 % of the steps of 250,000 bodies, and take
// 12 % more memory.)
#include <core/world/column_memory.h>

#include <cstdint>
#include <new>

// AddressSanitizer knows nothing of such pages, and sees less.
#if defined(__SANITIZE_ADDRESS__)
#define SCREE_PLAIN_MEMORY 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SCREE_PLAIN_MEMORY 1
#endif
#endif

#if defined(__linux__) && !defined(SCREE_PLAIN_MEMORY)
#include <sys/mman.h>
#include <unistd.h>
#define SCREE_HAS_PAGES 1
#endif

namespace scree {

#ifdef SCREE_HAS_PAGES

namespace {

// Calls take(room), or take(least) if the system has too few addresses.
template <class Take>
std::byte* take_either(std::size_t least, std::size_t& room, Take&& take) {
  void* pages = take(room);
  if (pages == MAP_FAILED) {
    room = least;
    pages = take(room);
  }
  if (pages == MAP_FAILED) throw std::bad_alloc();
  return static_cast<std::byte*>(pages);
}

}  // namespace

bool has_page_memory() noexcept { return true; }

std::byte* take_pages(std::size_t least, std::size_t& room) {
  return take_either(least, room, [](std::size_t bytes) {
    return mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  });
}

std::byte* grow_pages(std::byte* pages, std::size_t old_room, std::size_t least, std::size_t& room) {
  return take_either(least, room,
                     [=](std::size_t bytes) { return mremap(pages, old_room, bytes, MREMAP_MAYMOVE); });
}

bool drop_pages(std::byte* pages, std::size_t bytes) noexcept {
  // The system drops whole pages of its own, which may be larger than ours.
  static const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  if (reinterpret_cast<std::uintptr_t>(pages) % page != 0 || bytes % page != 0) return false;
  return madvise(pages, bytes, MADV_DONTNEED) == 0;
}

void free_pages(std::byte* pages, std::size_t room) noexcept { munmap(pages, room); }

#else

bool has_page_memory() noexcept { return false; }
std::byte* take_pages(std::size_t, std::size_t&) { throw std::bad_alloc(); }
std::byte* grow_pages(std::byte*, std::size_t, std::size_t, std::size_t&) { throw std::bad_alloc(); }
bool drop_pages(std::byte*, std::size_t) noexcept { return false; }
void free_pages(std::byte*, std::size_t) noexcept {}

#endif

}  // namespace scree
