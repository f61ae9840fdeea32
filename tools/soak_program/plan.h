// The plan of a round: a scene of random size under random settings, drawn from a seed.
#pragma once

#include <tools/scenes/random.h>
#include <tools/scenes/scene.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scree::soak {

struct Plan {
  std::string name;  ///< "pile bodies=130,seed=7"
  std::vector<scenes::Scene> scenes;
  int steps = 0;
  std::vector<float> dt;    ///< s; taken in turn
  std::uint32_t pause = 0;  ///< see Mischief
  int keyframe_spacing = 0;
};

/// Throws scree::Error where the catalog has a scene that has no sizes here.
Plan draw_plan(scenes::Random& random);

/// The sizes of a scene of the catalog, as draw_plan finds them.
scenes::Parameters draw_parameters(const std::string& scene, scenes::Random& random);

}  // namespace scree::soak
