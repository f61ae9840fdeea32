// Laws that targets share: of worlds, wherever they come from.
#pragma once

#include <scree/scree.h>
#include <tests/fuzz/targets.h>

#include <cstddef>
#include <vector>

namespace scree::fuzz {

// Single threads: what several do is tested elsewhere, and they would only share the fuzzer's processor.
Workers& narrow_workers();  // scalar
Workers& wide_workers();    // the widest instruction set of this machine

// Steps the world, and a clone of it on another instruction set: both must come to the same hashes, and all
// poses and velocities stay finite. Then the world must be one that snapshots take and give back.
void require_laws_of_steps(World& world, float dt, int steps);

// The snapshot's bytes are accepted and are the same again, and the restored world has the same state.
void require_laws_of_snapshots(const World& world);

std::vector<std::byte> bytes_of(const World& world);

// Whether a message is `before`, then a number that is no larger than `most`, then `after` and a reason.
bool names_offset(const std::string& message, const std::string& before, const std::string& after,
                  std::size_t most);

}  // namespace scree::fuzz
