// Calls that one rank makes for all: they travel as in a recording, and the other ranks make them, too. Used
// by DistributedWorld::give.
#pragma once

#include <scree/error.h>
#include <scree/transport.h>
#include <scree/world.h>

#include <functional>
#include <optional>

namespace scree {

struct Border;
struct WorldData;

// What all ranks do together after each part of the calls, and at their end.
using AfterCalls = std::function<void()>;

// Makes the calls on this rank's part and sends them, a part at a time. What they throw ends them, and is
// returned on all ranks. All other ranks call take_calls() meanwhile.
std::optional<Error> send_calls(World& world, Transport& transport, const std::function<void(World&)>& calls,
                                const AfterCalls& after);
std::optional<Error> take_calls(World& world, Transport& transport, int from, const AfterCalls& after);

// Lets go of bodies that calls have given to other ranks, and of their memory. Border::dirty_before is 0
// before the first of these calls.
void let_go_of_given(WorldData& data, Border& border);

}  // namespace scree
