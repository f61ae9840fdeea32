// The hash of a world: what "the same bits" means.
#define XXH_INLINE_ALL
#include <core/edit.h>
#include <scree/world.h>
#include <xxhash.h>

#include <cstring>

namespace scree {

namespace {

// 14 words a body, without padding: index, pose of the center of mass, velocities.
constexpr std::size_t kWordsPerBody = 1 + 7 + 6;
constexpr std::size_t kBodiesPerBatch = 256;  // 14 KiB on the stack, enough to make the calls cheap

void append(std::uint32_t*& out, const float* values, std::size_t count) {
  std::memcpy(out, values, count * sizeof(float));
  out += count;
}

}  // namespace

std::uint64_t World::hash() const {
  const Bodies& bodies = opened({"hash"}, data_).bodies;
  XXH64_state_t state;
  XXH64_reset(&state, 0);
  std::uint32_t batch[kBodiesPerBatch * kWordsPerBody];
  std::uint32_t* out = batch;
  const auto flush = [&] {
    XXH64_update(&state, batch, static_cast<std::size_t>(out - batch) * sizeof(std::uint32_t));
    out = batch;
  };
  for (std::size_t row = 0; row < bodies.flags.size(); ++row) {
    if ((bodies.flags[row] & kBodyAlive) == 0) continue;
    *out++ = static_cast<std::uint32_t>(row);
    append(out, bodies.pose[row].position, 3);
    append(out, bodies.pose[row].rotation, 4);
    append(out, bodies.velocity[row].linear, 3);
    append(out, bodies.velocity[row].angular, 3);
    if (out == batch + kBodiesPerBatch * kWordsPerBody) flush();
  }
  flush();
  return XXH64_digest(&state);
}

}  // namespace scree
