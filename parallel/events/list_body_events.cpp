// Events of bodies and joints: what fell asleep, what woke, and the joints that went with their bodies.
#include <parallel/islands/islands.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

BodyId id_of(const Bodies& bodies, std::int32_t body) {
  return {static_cast<std::uint32_t>(body), bodies.generation[body]};
}

// A body that has woken since the last step, by a call or in this step, may have gone since.
bool is_still_there(const Bodies& bodies, const BodyId& body) {
  return bodies.generation[body.index] == body.generation && bodies.type[body.index] == BodyType::dynamic;
}

}  // namespace

void list_body_events(WorldData& data) {
  Events& events = data.events;
  for (const std::int32_t body : islands_of(data).fallen_asleep) {
    events.sleep_begins.push_back(id_of(data.bodies, body));
  }
  for (const BodyId& body : events.woken) {
    if (is_still_there(data.bodies, body)) events.sleep_ends.push_back(body);
  }
  std::sort(events.sleep_ends.begin(), events.sleep_ends.end());
  events.woken.clear();
  events.destroyed.swap(events.lost);
  events.lost.clear();
}

}  // namespace scree
