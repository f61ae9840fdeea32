// Memory of large columns: pages from the system, which are zero, take no memory until they are written to,
// and move without being copied.
#pragma once

#include <cstddef>

namespace scree {

// Whether the system has such memory; otherwise none of the functions below is called.
bool has_page_memory() noexcept;
// Addresses for `room` bytes of zeros, aligned to a page, or where the system does not spend addresses so
// freely for `least`, to which `room` is set then. Throws std::bad_alloc.
std::byte* take_pages(std::size_t least, std::size_t& room);
// The same in place of `old_room` bytes, which come first. If it throws std::bad_alloc, nothing has changed.
std::byte* grow_pages(std::byte* pages, std::size_t old_room, std::size_t least, std::size_t& room);
// Makes these bytes, which are whole pages, zeros that take no memory; false if the system cannot.
bool drop_pages(std::byte* pages, std::size_t bytes) noexcept;
void free_pages(std::byte* pages, std::size_t room) noexcept;

}  // namespace scree
