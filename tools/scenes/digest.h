// One number for many hashes.
#pragma once

#include <cstdint>

namespace scree::scenes {

/// FNV-1a (Fowler, Noll, Vo) over the bytes of hashes in order.
class Digest {
 public:
  void add(std::uint64_t hash) {
    for (int byte = 0; byte < 8; ++byte) value_ = (value_ ^ ((hash >> (8 * byte)) & 0xff)) * 0x100000001b3u;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace scree::scenes
