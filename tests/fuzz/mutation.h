// Shared by the mutators of byte formats. Only for programs with libFuzzer, which all start in mutation.cpp.
#pragma once

#include <tests/fuzz/targets.h>
#include <tools/scenes/random.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

// libFuzzer's own mutation: at most `most` bytes in the same place. Returns their number.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t bytes, std::size_t most);

namespace scree::fuzz {

using Buffer = std::vector<std::byte>;

// Mutates bytes but keeps their number.
inline void mutate_in_place(std::span<std::byte> bytes) {
  if (bytes.empty()) return;
  Buffer copy(bytes.begin(), bytes.end());
  const std::size_t count =
      LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(copy.data()), copy.size(), copy.size());
  if (count > 0) std::memcpy(bytes.data(), copy.data(), count);
}

// Mutates bytes, which may become more, up to `most`, or fewer.
inline void mutate_freely(Buffer& bytes, std::size_t most) {
  const std::size_t before = bytes.size();
  bytes.resize(most < before ? before : most);
  if (bytes.empty()) return;
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), before, bytes.size()));
}

// A boundary value, at a place where words usually lie.
void put_a_word(std::span<std::byte> bytes, scenes::Random& random);

}  // namespace scree::fuzz
