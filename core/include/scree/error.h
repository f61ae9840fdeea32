// The one exception type of the library, and the kinds of mistakes.
#pragma once

#include <scree/export.h>

#include <cstdint>
#include <stdexcept>
#include <string>

namespace scree {

/// The kind of a mistake, for programs that go on in another way for each. Numbers are never given to another
/// kind; later versions may add some.
enum class ErrorCode : std::uint8_t {
  /// An argument is outside its range or not a number, does not fit another argument (lists of different
  /// lengths, the same body twice), or is no solid.
  invalid_value = 1,
  /// A handle names nothing that lives: it is a default one or kWorld, or what it named was
  /// destroyed.
  dead_handle = 2,
  /// A handle belongs to another world.
  foreign_handle = 3,
  /// What the call works on is of another kind or in another state than the call needs: a body that is not
  /// kinematic, contact forces that are not measured, an empty snapshot.
  wrong_state = 4,
  /// The world has been moved from.
  moved_from = 5,
  /// There would be more bodies, shapes, joints or bytes than can be counted.
  too_many = 6,
  /// The bytes of a snapshot or a recording were changed or cut off, or never were any.
  corrupt_data = 7,
  /// Another version of Scree wrote the snapshot or recording, and this one cannot read it.
  wrong_version = 8,
  /// The system does not let a file be created, read or written, or a thread be started to write it.
  io_failure = 9,
  /// Another recorder records the world, or writes to the file.
  already_recording = 10,
  /// This build or this machine cannot do it: an instruction set, big-endian bytes.
  not_supported = 11,
  /// Memory ran out while a recorder wrote, so that the recording is incomplete (Recorder::finish). Elsewhere
  /// memory that runs out is std::bad_alloc.
  out_of_memory = 12,
};

/// Thrown for every mistake of the caller: says what was asked, which value was wrong and what the limit is.
/// The call that throws has changed nothing.
class SCREE_API Error : public std::runtime_error {
 public:
  /// `what_happened` becomes what().
  explicit Error(const std::string& what_happened, ErrorCode code = ErrorCode::invalid_value)
      : std::runtime_error(what_happened), code_(code) {}
  /// The kind of the mistake.
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace scree
