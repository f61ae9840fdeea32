// What is asked of a contact where its approach speed is noted and where its events are listed.
#pragma once

#include <core/world/edit.h>

#include <algorithm>

namespace scree {

// Events that either shape or the world asks for.
inline ContactEvents asked_about(const WorldData& data, const ShapePair& pair) {
  return data.settings.contact_events | data.shapes.events[pair.a] | data.shapes.events[pair.b];
}

inline float nearest_of(const Manifold& manifold) {
  float nearest = kAbsentSeparation;
  for (const float separation : manifold.separation) nearest = separation < nearest ? separation : nearest;
  return nearest;
}

// The points of hulls may lie as far away as the hull is large, where nothing happens: of a contact count the
// nearest point and those within this gap.
inline float near_of(const Manifold& manifold) {
  return std::max(nearest_of(manifold), kSpeculativeDistance);
}

}  // namespace scree
