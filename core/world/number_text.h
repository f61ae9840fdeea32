// Writes numbers into messages.
#pragma once

#include <cstdio>
#include <string>

namespace scree {

inline std::string number_text(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

}  // namespace scree
