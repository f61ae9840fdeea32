// A pile that falls and sleeps, in a gate that sees it, with events of all kinds.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <vector>

namespace scree::distributed_tests {

struct EventfulPile {
  World world;
  std::vector<BodyId> bodies;  // of the pile
  BodyId gate;
};

inline EventfulPile make_eventful_pile(int count) {
  scenes::Scene scene = scenes::build("pile", {{"bodies", count}}).front();
  scene.settings.sleeping = true;
  scene.settings.contact_events = ContactEvents::all;
  scene.settings.contact_forces = true;
  EventfulPile pile{World(scene.settings), {}, {}};
  pile.bodies = scenes::populate(pile.world, scene);
  pile.gate = pile.world.create_body({.type = BodyType::fixed});
  pile.world.add_shape(pile.gate, Box{{6, 1, 6}}, {}, {.local_pose = {{0, 1.5f, 0}, {}}, .sensor = true});
  return pile;
}

}  // namespace scree::distributed_tests
