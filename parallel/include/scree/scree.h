// Everything a program needs to simulate: include this one.
#pragma once

#include <scree/body.h>
#include <scree/contact_forces.h>
#include <scree/contact_hooks.h>
#include <scree/decompose.h>
#include <scree/distributed_player.h>
#include <scree/distributed_queries.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <scree/events.h>
#include <scree/height_field.h>
#include <scree/hull.h>
#include <scree/ids.h>
#include <scree/math.h>
#include <scree/math_types.h>
#include <scree/mesh.h>
#include <scree/mover.h>
#include <scree/queries.h>
#include <scree/recording.h>
#include <scree/shapes.h>
#include <scree/snapshot.h>
#include <scree/solver.h>
#include <scree/stats.h>
#include <scree/step.h>
#include <scree/transport.h>
#include <scree/triangle_mesh.h>
#include <scree/workers.h>
#include <scree/world.h>
#include <scree/zones.h>

/// Everything that Scree offers to a program.
namespace scree {}
