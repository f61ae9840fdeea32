// The one exception type of the library.
#pragma once

#include <scree/export.h>

#include <stdexcept>
#include <string>

namespace scree {

/// Thrown for every mistake of the caller: says what was asked, which value was wrong and what the limit is.
/// The call that throws has changed nothing.
class SCREE_API Error : public std::runtime_error {
 public:
  explicit Error(const std::string& what_happened) : std::runtime_error(what_happened) {}
};

}  // namespace scree
