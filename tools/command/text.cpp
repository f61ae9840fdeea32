// See text.h.
#include <tools/command/text.h>

#include <cstdarg>
#include <cstdio>

namespace scree::command {

std::string format(const char* pattern, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string grouped(std::uint64_t count) {
  const std::string digits = std::to_string(count);
  std::string result;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) result += ',';
    result += digits[i];
  }
  return result;
}

std::string mebibytes(std::uint64_t bytes) {
  return format("%.1f MiB", static_cast<double>(bytes) / (1024.0 * 1024.0));
}

std::string row(const std::string& name, const std::string& value) {
  return format("  %-20s", name.c_str()) + value + "\n";
}

std::string printable(std::string text) {
  for (char& character : text) {
    if (character < 0x20 || character > 0x7e) character = '?';
  }
  return text;
}

std::string hash_digits(std::uint64_t hash) {
  return format("%016llx", static_cast<unsigned long long>(hash));
}

}  // namespace scree::command
