// What ranks do together and some of them may fail in: all go on alike, or all get the same Error.
#pragma once

#include <scree/error.h>
#include <scree/transport.h>

#include <exception>
#include <new>
#include <optional>
#include <string>

namespace scree {

// What work() throws, as an Error.
template <class Work>
std::optional<Error> attempt(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return Error("memory ran out", ErrorCode::out_of_memory);
  } catch (const std::exception& error) {
    return Error(error.what(), ErrorCode::io_failure);
  } catch (...) {
    return Error("something was thrown that is no std::exception", ErrorCode::io_failure);
  }
  return {};
}

// None where no rank has a problem. Else an Error that says what the first ones of them say, which is the
// same on all ranks: who could have done its part knows little. All ranks call it together.
std::optional<Error> agree(Transport& transport, const std::optional<Error>& problem);

// What rank 0 says. All ranks call it together.
std::string tell_all(Transport& transport, const std::string& text);
std::optional<Error> tell_all(Transport& transport, const std::optional<Error>& problem);

}  // namespace scree
