// Laws that all targets check on worlds.
#pragma once

#include <scree/scree.h>
#include <tests/fuzz/targets.h>

#include <cstddef>
#include <vector>

namespace scree::fuzz {

// Single threads: other tests cover several threads, which would only share the fuzzer's processor here.
Workers& narrow_workers();  // scalar
Workers& wide_workers();    // the widest instruction set of this machine

// Steps the world, and a clone of it on another instruction set. Expects the same hashes, and that all poses
// and velocities stay finite. Snapshots must then save and restore the world.
void require_laws_of_steps(World& world, float dt, int steps);

// Expects that the snapshot's bytes are accepted and written again equally, and that the restored world has
// the same state.
void require_laws_of_snapshots(const World& world);

std::vector<std::byte> bytes_of(const World& world);

// Whether a message is `before`, then a number that is no larger than `most`, then `after` and a reason.
bool names_offset(const std::string& message, const std::string& before, const std::string& after,
                  std::size_t most);

}  // namespace scree::fuzz
