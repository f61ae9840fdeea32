// Bullets of 1 cm at 1,000 m/s, 17 m a step, as the scene of that name fires them.
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>

namespace scree::physics {
namespace {

TEST(Bullets, PassNoPlateAndMissNoOther) {
  constexpr int kBullets = 80;
  const scenes::Scene scene =
      scenes::build("bullets", {{"bullets", kBullets}, {"columns", 4}, {"rows", 4}}).front();
  World world(scene.settings);
  const std::vector<BodyId> bodies = populate(world, scene);
  Workers workers{1};
  for (int i = 0; i < 300; ++i) step(world, scene.dt, workers);  // the last arrives after 4 s
  const std::size_t first = bodies.size() - kBullets;
  for (std::size_t i = 0; i < kBullets; i += 4) {
    const auto place = [&](std::size_t k) { return world.pose(bodies[first + i + k]).position; };
    const auto speed = [&](std::size_t k) { return world.linear_velocity(bodies[first + i + k]).z; };
    EXPECT_LT(speed(0), 900.0f) << "bullet " << i << " went through the wall";
    EXPECT_LT(place(1).z, 0.0f) << "bullet " << i + 1 << " passed the plate";
    EXPECT_LT(place(2).z, 0.1f) << "bullet " << i + 2 << " passed the one that met it";
    EXPECT_GT(place(3).z, -0.1f) << "bullet " << i + 3 << " passed the one that met it";
    EXPECT_LT(speed(2), 0.0f);
    EXPECT_GT(speed(3), 0.0f);
  }
}

}  // namespace
}  // namespace scree::physics
