// Laws of sensors and meshes: a sensor sees the meshes whose surfaces it touches.
#include <tests/parallel/queries/mesh_fixture.h>

namespace scree {
namespace {

using testing::Dice;

constexpr float kStep = 1.0f / 60.0f;  // s

struct Hall {
  World world{WorldSettings{.gravity = {}}};
  Workers workers{1};
  ShapeId mesh;

  explicit Hall(BodyType type = BodyType::fixed) {
    Dice dice(41);
    mesh = world.add_shape(world.create_body({.type = type}),
                           testing::bumpy_ball(dice, 10, 16, 2.0f, 2.0f).mesh());
  }
  ShapeId sensor(const Geometry& geometry, Vec3 position, BodyType type = BodyType::fixed,
                 Vec3 velocity = {}) {
    const BodyId body = world.create_body({.type = type, .position = position, .linear_velocity = velocity});
    return world.add_shape(body, geometry, {}, {.sensor = true});
  }
  bool sees(ShapeId of) const {
    std::vector<ShapeId> all(world.visitors_of(of, {}));
    world.visitors_of(of, all);
    return std::find(all.begin(), all.end(), mesh) != all.end();
  }
  void run(int steps = 1) {
    for (int i = 0; i < steps; ++i) step(world, kStep, workers);
  }
};

TEST(MeshSensors, SeeTheMeshesWhoseSurfacesTheyTouch) {
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic}) {
    Hall hall(type);
    const ShapeId across = hall.sensor(Box{{0.5f, 0.5f, 0.5f}}, {2, 0, 0});
    const ShapeId around = hall.sensor(Sphere{5}, {0, 0, 0});
    const ShapeId within = hall.sensor(Sphere{1}, {0, 0, 0});
    const ShapeId beside = hall.sensor(Capsule{}, {4, 0, 0});
    hall.run();
    EXPECT_TRUE(hall.sees(across));
    EXPECT_TRUE(hall.sees(around));
    EXPECT_FALSE(hall.sees(within)) << "a mesh has no inside";
    EXPECT_FALSE(hall.sees(beside));
    EXPECT_EQ(hall.world.sensor_begins().size(), 2u);
  }
}

TEST(MeshSensors, SeeAMeshThatMovesInAndOut) {
  Hall hall(BodyType::kinematic);
  const ShapeId gate = hall.sensor(Box{{0.5f, 3, 3}}, {6, 0, 0});
  hall.world.set_linear_velocity(hall.world.body_of(hall.mesh), {12, 0, 0});
  int begins = 0, ends = 0;
  for (int i = 0; i < 120; ++i) {
    hall.run();
    begins += static_cast<int>(hall.world.sensor_begins().size());
    ends += static_cast<int>(hall.world.sensor_ends().size());
  }
  EXPECT_EQ(begins, 1);
  EXPECT_EQ(ends, 1);
  EXPECT_FALSE(hall.sees(gate));
}

TEST(MeshSensors, FastSensorsSeeAMeshThatTheyPassInOneStep) {
  Hall hall;
  const ShapeId probe = hall.sensor(Sphere{0.1f}, {-5, 0.3f, 0}, BodyType::kinematic, {600, 0, 0});
  const ShapeId beside = hall.sensor(Sphere{0.1f}, {-5, 4, 0}, BodyType::kinematic, {600, 0, 0});
  hall.run();
  ASSERT_EQ(hall.world.sensor_begins().size(), 1u);
  EXPECT_EQ(hall.world.sensor_begins()[0].sensor, probe);
  EXPECT_EQ(hall.world.sensor_ends().size(), 1u);
  EXPECT_FALSE(hall.sees(probe));
  EXPECT_FALSE(hall.sees(beside));
}

}  // namespace
}  // namespace scree
