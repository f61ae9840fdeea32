// Pieces of the tables that the command prints.
#pragma once

#include <cstdint>
#include <string>

namespace scree::command {

__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...);
std::string grouped(std::uint64_t count);    // 14950 -> "14,950"
std::string mebibytes(std::uint64_t bytes);  // "1.5 MiB"
std::string row(const std::string& name, const std::string& value);
// Text from a file, safe for a terminal: control characters and bytes beyond ASCII become '?'.
std::string printable(std::string text);
std::string hash_digits(std::uint64_t hash);  // 16 of them

}  // namespace scree::command
