// See mutation.h.
#include <tests/fuzz/memory_watch.h>
#include <tests/fuzz/mutation.h>

#include <bit>
#include <iterator>

namespace scree::fuzz {

void put_a_word(std::span<std::byte> bytes, scenes::Random& random) {
  constexpr std::uint32_t kWords[] = {0,
                                      1,
                                      2,
                                      3,
                                      63,
                                      64,
                                      65,
                                      0x7f,
                                      0xff,
                                      0x7fff,
                                      0xffff,
                                      0x7fffffff,
                                      0x80000000,  // also -0
                                      0xffffffff,
                                      std::bit_cast<std::uint32_t>(1.0f),
                                      std::bit_cast<std::uint32_t>(-1.0f),
                                      std::bit_cast<std::uint32_t>(1e-4f),
                                      std::bit_cast<std::uint32_t>(1e5f),
                                      std::bit_cast<std::uint32_t>(1e7f),
                                      std::bit_cast<std::uint32_t>(1e9f),
                                      std::bit_cast<std::uint32_t>(3.4e38f),
                                      0x00000001,   // the smallest float
                                      0x7f800000,   // infinity
                                      0x7fc00000};  // not a number
  if (bytes.size() < sizeof(std::uint32_t)) return;
  const auto words = static_cast<std::uint32_t>(bytes.size() / sizeof(std::uint32_t));
  const std::size_t at = sizeof(std::uint32_t) * random.below(words);
  std::uint32_t word = kWords[random.below(static_cast<std::uint32_t>(std::size(kWords)))];
  if (random.below(4) == 0) {  // one off, as counts and indices are
    std::memcpy(&word, bytes.data() + at, sizeof word);
    word += random.below(2) == 0 ? 1u : ~0u;
  }
  std::memcpy(bytes.data() + at, &word, sizeof word);
}

}  // namespace scree::fuzz

// What libFuzzer calls first.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  scree::fuzz::tell_memory_at_exit();
  return 0;
}
