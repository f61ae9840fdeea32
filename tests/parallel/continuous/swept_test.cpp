// Laws of sweeps: at any speed no body passes through fixed or sleeping shapes, and sweeps stop no other
// body.
#include <core/geometry/reference/collide.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <numbers>
#include <variant>

namespace scree::physics {
namespace {

constexpr float kSpeed = 400.0f;  // m/s: 6.7 m a step

Hull ball_of_points(int count, Vec3 size, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d unit = to_eigen(random.vector(1)).normalized();
    points.push_back({size.x * static_cast<float>(unit.x()), size.y * static_cast<float>(unit.y()),
                      size.z * static_cast<float>(unit.z())});
  }
  return Hull(points);
}

// Distance of a point from the plane of the hull's face that is farthest below it. The hull sits at its
// body's origin.
double distance_from_hull(const Hull& hull, const Pose& pose, const Eigen::Vector3d& point) {
  const Eigen::Vector3d local = to_eigen(pose.rotation).conjugate() * (point - to_eigen(pose.position));
  double farthest = -1e9;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const auto face = hull.face(f);
    const auto corner = [&](std::size_t i) { return to_eigen(hull.vertices()[face[i]]); };
    const Eigen::Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    farthest = std::max(farthest, normal.dot(local - corner(0)));
  }
  return farthest;
}

// Distance of a point from a shape, negative within.
double distance_from(const World& world, ShapeId shape, const Eigen::Vector3d& point) {
  const Geometry geometry = world.geometry(shape);
  if (const auto* convex = std::get_if<ConvexHull>(&geometry))
    return distance_from_hull(convex->hull, world.pose(world.body_of(shape)), point);
  const WorldData& data = internals(world);
  const reference::Solid solid = reference::make_solid(
      data.shapes.type[shape.index], data.shapes.extent[shape.index], data.shapes.pose[shape.index]);
  const Eigen::Vector3d local = solid.rotation.transpose() * (point - solid.position);
  const Eigen::Vector3d beyond = local.cwiseAbs() - solid.half;
  const double outside = beyond.cwiseMax(0.0).norm();
  return (outside > 0.0 ? outside : beyond.maxCoeff()) - solid.radius;
}

ShapeId shape_of(const World& world, BodyId body) {
  ShapeId shape;
  world.shapes_of(body, {&shape, 1});
  return shape;
}

// Steps, and returns the smallest distance of the bodies' centers to the shape on straight lines from step to
// step.
double nearest_way(Lab& lab, const std::vector<BodyId>& bodies, ShapeId obstacle, int steps) {
  constexpr int kSamples = 2000;
  double nearest = 1e9;
  for (int i = 0; i < steps; ++i) {
    std::vector<Eigen::Vector3d> before;
    for (const BodyId body : bodies) before.push_back(lab.position(body));
    lab.run(1);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Eigen::Vector3d way = lab.position(bodies[k]) - before[k];
      for (int sample = 0; sample <= kSamples; ++sample) {
        nearest = std::min(nearest, distance_from(lab.world, obstacle, before[k] + way * sample / kSamples));
      }
    }
  }
  return nearest;
}

const Geometry kShapes[] = {Sphere{0.05f}, Capsule{0.1f, 0.05f}, Box{{0.05f, 0.07f, 0.06f}},
                            Box{{0.3f, 0.05f, 0.3f}}};

TEST(Swept, NoBulletPassesAThinWall) {
  for (const Geometry& bullet : kShapes) {
    Lab lab(without_gravity());
    const BodyId wall = lab.add({.type = BodyType::fixed, .position = {10, 0, 0}}, Box{{0.005f, 300, 300}});
    Random random(3);
    std::vector<BodyId> bullets;
    for (int i = 0; i < 40; ++i) {
      const float slant = random.uniform(-0.8f, 0.8f);
      bullets.push_back(lab.add(
          {.position = {random.uniform(-5, 5), 0.8f * static_cast<float>(i % 20) - 8, i < 20 ? -2.0f : 2.0f},
           .rotation = random.rotation(),
           .linear_velocity = {kSpeed, slant * kSpeed, 0},
           .angular_velocity = random.vector(20)},
          bullet));
    }
    EXPECT_GT(nearest_way(lab, bullets, shape_of(lab.world, wall), 30), 0.0);
    for (const BodyId body : bullets) EXPECT_LT(lab.position(body).x(), 10.0);
  }
}

TEST(Swept, WithoutSweepsBulletsPass) {
  WorldSettings settings = without_gravity();
  settings.continuous = false;
  Lab lab(settings);
  lab.add({.type = BodyType::fixed, .position = {10, 0, 0}}, Box{{0.005f, 300, 300}});
  const BodyId bullet = lab.add({.linear_velocity = {kSpeed, 0, 0}}, Sphere{0.05f});
  lab.run(5);
  EXPECT_GT(lab.position(bullet).x(), 20.0);
  EXPECT_EQ(lab.world.stats().swept_bodies, 0);
}

TEST(Swept, FastBodiesMeetEveryKindOfShape) {
  const Geometry obstacles[] = {Sphere{0.4f},
                                Capsule{0.6f, 0.3f},
                                Box{{0.4f, 0.3f, 0.5f}},
                                Box{{2, 0.01f, 2}},
                                ConvexHull{ball_of_points(4, {0.5f, 0.5f, 0.5f}, 1)},
                                ConvexHull{ball_of_points(40, {0.5f, 0.4f, 0.6f}, 2)},
                                ConvexHull{ball_of_points(40, {2, 0.02f, 2}, 3)}};
  std::vector<Geometry> bullets(std::begin(kShapes), std::end(kShapes));
  bullets.push_back(ConvexHull{ball_of_points(20, {0.1f, 0.1f, 0.1f}, 4)});
  bullets.push_back(ConvexHull{ball_of_points(20, {0.3f, 0.03f, 0.1f}, 5)});
  Random random(11);
  for (const Geometry& geometry : obstacles) {
    for (const Geometry& bullet : bullets) {
      Lab lab(without_gravity());
      const BodyId obstacle =
          lab.add({.type = BodyType::fixed, .position = {3, -2, 1}, .rotation = random.rotation()}, geometry);
      const ShapeId shape = shape_of(lab.world, obstacle);
      for (int shot = 0; shot < 12; ++shot) {
        const Eigen::Vector3d from = to_eigen(random.vector(1)).normalized() * 4.0;
        const Eigen::Vector3d velocity = -from.normalized() * static_cast<double>(kSpeed);
        const auto to_vec3 = [](const Eigen::Vector3d& v) {
          return Vec3{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
        };
        const BodyId body = lab.add({.position = to_vec3(Eigen::Vector3d(3, -2, 1) + from),
                                     .rotation = random.rotation(),
                                     .linear_velocity = to_vec3(velocity)},
                                    bullet);
        // A body that hits a slanted face leaves along it: only the obstacle itself stops bodies.
        EXPECT_GT(nearest_way(lab, {body}, shape, 4), 0.0)
            << "obstacle " << geometry.index() << ", bullet " << bullet.index() << ", shot " << shot;
        lab.world.destroy_body(body);
      }
    }
  }
}

TEST(Swept, ABodyThatHitsStopsAtTheSurfaceAndKeepsItsVelocity) {
  Lab lab(without_gravity());
  lab.add({.type = BodyType::fixed, .position = {5.01f, 0, 0}}, Box{{0.01f, 5, 5}});
  const BodyId ball =
      lab.add({.linear_velocity = {kSpeed, 0, 0}, .angular_velocity = {0, 0, 30}}, Sphere{0.1f});
  lab.run(1);
  EXPECT_EQ(lab.world.stats().swept_bodies, 1);
  EXPECT_EQ(lab.world.stats().sweep_hits, 1);
  EXPECT_NEAR(lab.position(ball).x(), 4.9, 1e-3);
  EXPECT_EQ(lab.velocity(ball).x(), static_cast<double>(kSpeed));
  // Rotation and translation stop at the same share of the step.
  const double turn = 2.0 * std::acos(static_cast<double>(lab.world.pose(ball).rotation.w));
  EXPECT_NEAR(turn, 30.0 * 4.9 / static_cast<double>(kSpeed), 1e-3);
  lab.run(1);
  EXPECT_EQ(lab.world.stats().contacts, 1);
  EXPECT_NEAR(lab.velocity(ball).x(), 0.0, 0.1);
  EXPECT_NEAR(lab.position(ball).x(), 4.9, 0.01);
}

TEST(Swept, ABulletReboundsByItsRestitution) {
  Lab lab(without_gravity());
  lab.add({.type = BodyType::fixed, .position = {5.01f, 0, 0}}, Box{{0.01f, 5, 5}});
  const BodyId ball =
      lab.add({.linear_velocity = {kSpeed, 0, 0}}, Sphere{0.1f}, {.friction = 0, .restitution = 0.5f});
  lab.run(5);
  EXPECT_NEAR(lab.velocity(ball).x(), -0.5 * static_cast<double>(kSpeed), 0.01 * kSpeed);
}

TEST(Swept, BodiesThatPassByAreNotStopped) {
  Lab lab(without_gravity());
  const Material smooth{.friction = 0};
  lab.add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{50, 1, 50}}, smooth);
  // Paths along the floor at a small distance: one touches nothing, one cuts a corner by a third of its
  // radius, one is far away.
  lab.add({.type = BodyType::fixed, .position = {10, 5, 0}}, Box{{0.5f, 0.5f, 0.5f}}, smooth);
  const BodyId low =
      lab.add({.position = {-20, 0.2505f, 5}, .linear_velocity = {kSpeed, 0, 0}}, Sphere{0.25f}, smooth);
  const BodyId corner =
      lab.add({.position = {0, 5.5f + 0.2f, 0}, .linear_velocity = {kSpeed, 0, 0}}, Sphere{0.3f}, smooth);
  for (int i = 0; i < 5; ++i) {
    lab.run(1);
    EXPECT_EQ(lab.world.stats().swept_bodies, 2);
    EXPECT_EQ(lab.world.stats().sweep_hits, 0);
  }
  const double way = 5.0 * static_cast<double>(kStep * kSpeed);
  EXPECT_NEAR(lab.position(low).x(), -20.0 + way, 1e-3 * way);
  EXPECT_NEAR(lab.position(corner).x(), way, 1e-3 * way);
}

TEST(Swept, SlidingLosesNothingButFriction) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back({k & 1 ? 0.3f : -0.3f, k & 2 ? 0.2f : -0.2f, k & 4 ? 0.3f : -0.3f});
  }
  for (const float friction : {0.0f, 0.4f}) {
    for (const Geometry& geometry :
         {Geometry{Box{{0.3f, 0.2f, 0.3f}}}, Geometry{ConvexHull{Hull(corners)}}, Geometry{Sphere{0.2f}}}) {
      const bool rolls = std::holds_alternative<Sphere>(geometry);
      if (rolls && friction > 0.0f) continue;
      Lab lab;
      const Material material{.friction = friction};
      // Slabs with seams between them.
      for (int i = 0; i < 60; ++i) {
        lab.add({.type = BodyType::fixed, .position = {4.0f * static_cast<float>(i), -0.5f, 0}},
                Box{{2, 0.5f, 4}}, material);
      }
      const BodyId body =
          lab.add({.position = {0, 0.2f, 0}, .linear_velocity = {100, 0, 0}}, geometry, material);
      std::int64_t swept = 0;
      for (int i = 0; i < 120; ++i) {
        lab.run(1);
        swept += lab.world.stats().swept_bodies;
        ASSERT_EQ(lab.world.stats().sweep_hits, 0);
      }
      EXPECT_EQ(swept, 120);
      const double lost = static_cast<double>(friction) * kGravity * 2.0;
      EXPECT_NEAR(lab.velocity(body).x(), 100.0 - lost, 0.02 * lost + 1e-3);
      EXPECT_NEAR(lab.position(body).x(), 200.0 - lost, 0.5);
    }
  }
}

TEST(Swept, BodiesThatSlideOverSeamsAlongAnEdgeOrACornerAreNotStopped) {
  struct Slider {
    Box box;
    float yaw;
    double front;  // how far it reaches ahead of its center
  };
  const Slider sliders[] = {{{{0.3f, 0.2f, 20}}, 0.0f, 0.3},
                            {{{0.3f, 0.2f, 0.3f}}, 0.4f, 0.3 * (std::cos(0.4) + std::sin(0.4))}};
  const Material smooth{.friction = 0};
  for (const Slider& slider : sliders) {
    for (const float gap : {0.025f, 0.035f, 0.045f}) {  // in front of a seam, once in 2.4 slabs
      Lab lab;
      for (int i = 0; i < 60; ++i) {
        lab.add({.type = BodyType::fixed, .position = {4.0f * static_cast<float>(i), -0.5f, 0}},
                Box{{2, 0.5f, 25}}, smooth);
      }
      const float start = 2.0f - gap - static_cast<float>(slider.front) - 100 * kStep;
      const BodyId body = lab.add({.position = {start, 0.2f, 0},
                                   .rotation = rotation_about({0, 1, 0}, static_cast<double>(slider.yaw)),
                                   .linear_velocity = {100, 0, 0}},
                                  slider.box, smooth);
      lab.run(120);
      EXPECT_NEAR(lab.velocity(body).x(), 100.0, 1e-3) << slider.yaw << ", " << gap;
      EXPECT_NEAR(lab.position(body).x(), static_cast<double>(start) + 200.0, 0.1)
          << slider.yaw << ", " << gap;
    }
  }
}

TEST(Swept, ABoxThatFallsOnAnEdgeOrACornerIsStoppedAtTheSurface) {
  constexpr float kHalf = 0.5f;  // m
  const Quat on_edge = rotation_about({0, 0, 1}, 0.25 * std::numbers::pi);
  const Quat on_corner = rotation_about({1, 0, 0}, std::atan(std::sqrt(0.5))) * on_edge;
  const auto lowest = [](const Lab& lab, BodyId body) {
    double height = 1e9;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d corner(k & 1 ? kHalf : -kHalf, k & 2 ? kHalf : -kHalf, k & 4 ? kHalf : -kHalf);
      height = std::min(height, (lab.position(body) + to_eigen(lab.world.pose(body).rotation) * corner).y());
    }
    return height;
  };
  for (const Quat& rotation : {on_edge, on_corner}) {
    for (const float gap : {0.025f, 0.045f, 0.065f}) {
      Lab lab(without_gravity());
      lab.add_ground();
      const BodyId box =
          lab.add({.rotation = rotation, .linear_velocity = {0, -20, 0}}, Box{{kHalf, kHalf, kHalf}});
      const float start = gap + 20 * kStep - static_cast<float>(lowest(lab, box));
      lab.world.set_pose(box, {{0, start, 0}, rotation});
      lab.run(1);
      ASSERT_NEAR(lowest(lab, box), static_cast<double>(gap), 1e-3);
      lab.run(1);
      EXPECT_EQ(lab.world.stats().contacts, 1) << gap;
      EXPECT_GT(lowest(lab, box), -0.005) << gap;
    }
  }
}

TEST(Swept, ARodThatFallsFlatIsStoppedForEveryKindOfShape) {
  // As thin as the strip in which faces only graze.
  const Vec3 half{0.5f, 0.004f, 0.004f};
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back({k & 1 ? half.x : -half.x, k & 2 ? half.y : -half.y, k & 4 ? half.z : -half.z});
  }
  for (const Geometry& geometry : {Geometry{Box{half}}, Geometry{ConvexHull{Hull(corners)}}}) {
    Lab lab(without_gravity());
    lab.add_ground();
    const float gap = 0.03f;  // after the first step; in the second step it would pass through the floor
    const BodyId rod =
        lab.add({.position = {0, half.y + gap + 10 * kStep, 0}, .linear_velocity = {0, -10, 0}}, geometry);
    lab.run(2);
    EXPECT_EQ(lab.world.stats().contacts, 1) << geometry.index();
    EXPECT_NEAR(lab.height(rod), static_cast<double>(half.y), 0.002) << geometry.index();
  }
}

TEST(Swept, EdgesThatPassEachOtherSidewaysDoNotTouch) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back({k & 1 ? 1.0f : -1.0f, k & 2 ? 1.0f : -1.0f, k & 4 ? 1.0f : -1.0f});
  }
  const double turn = 0.25 * std::numbers::pi;
  const float diagonal = std::sqrt(2.0f);  // of a square face, half
  for (const Geometry& geometry : {Geometry{Box{{1, 1, 1}}}, Geometry{ConvexHull{Hull(corners)}}}) {
    for (const float beyond : {-0.3f, 0.028f}) {
      Lab lab(without_gravity());
      // An edge along x upward, and one along z downward that comes down on it: 10 cm above, over or
      // beyond its end.
      lab.add({.type = BodyType::kinematic, .rotation = rotation_about({1, 0, 0}, turn)}, geometry);
      lab.add({.position = {1 + beyond - 20 * kStep, 2 * diagonal + 0.1f + 8 * kStep, 0},
               .rotation = rotation_about({0, 0, 1}, turn),
               .linear_velocity = {20, -8, 0}},
              geometry);
      lab.run(2);
      EXPECT_EQ(lab.world.stats().contacts, beyond < 0.0f ? 1 : 0);
    }
  }
}

TEST(Swept, SpinningPlatesStayAboveAThinFloor) {
  Lab lab;
  lab.add({.type = BodyType::fixed, .position = {0, -0.005f, 0}}, Box{{1000, 0.005f, 1000}});
  Random random(2);
  std::vector<BodyId> plates;
  for (int i = 0; i < 50; ++i) {
    plates.push_back(lab.add({.position = {5.0f * static_cast<float>(i % 10) - 25, random.uniform(2, 9),
                                           5.0f * static_cast<float>(i / 10) - 12},
                              .rotation = random.rotation(),
                              .linear_velocity = {0, -80, 0},
                              .angular_velocity = random.vector(100)},
                             Box{{random.uniform(0.2f, 1), 0.02f, random.uniform(0.2f, 1)}}));
  }
  lab.run(400);
  for (const BodyId plate : plates) EXPECT_GT(lab.height(plate), 0.0);
}

TEST(Swept, NoBodyLeavesAClosedRoom) {
  Lab lab(without_gravity());
  const float half = 3.0f, thin = 0.005f, wide = 3.5f;
  const BodyId room = lab.world.create_body({.type = BodyType::fixed});
  for (const float side : {-1.0f, 1.0f}) {
    const Vec3 offsets[] = {
        {side * (half + thin), 0, 0}, {0, side * (half + thin), 0}, {0, 0, side * (half + thin)}};
    const Vec3 sizes[] = {{thin, wide, wide}, {wide, thin, wide}, {wide, wide, thin}};
    for (int axis = 0; axis < 3; ++axis)
      lab.world.add_shape(room, Box{sizes[axis]}, {}, {.local_pose = {offsets[axis], {}}});
  }
  Random random(6);
  std::vector<BodyId> bodies;
  const Material elastic{.friction = 0.3f, .restitution = 0.8f};
  for (int i = 0; i < 150; ++i) {
    const float size = random.uniform(0.08f, 0.2f);
    const Geometry geometry = i % 3 == 0   ? Geometry{Sphere{size}}
                              : i % 3 == 1 ? Geometry{Box{{size, 0.5f * size, size}}}
                                           : Geometry{Capsule{size, 0.5f * size}};
    bodies.push_back(lab.add({.position = random.vector(2.7f),
                              .rotation = random.rotation(),
                              .linear_velocity = random.vector(300),
                              .angular_velocity = random.vector(50)},
                             geometry, elastic));
  }
  lab.run(300);
  for (const BodyId body : bodies) {
    EXPECT_LT(lab.position(body).cwiseAbs().maxCoeff(), static_cast<double>(half)) << body.index;
  }
}

TEST(Swept, AHullStopsBodiesAtItsFacesForAnyCentroid) {
  // A slab whose points lie far from the body's origin, and the same as a bullet.
  const float left = 7, right = 8;
  std::vector<Vec3> corners;
  for (const float x : {left, right}) {
    for (const float y : {-1.0f, 1.0f}) {
      for (const float z : {-1.0f, 1.0f}) corners.push_back({x, y, z});
    }
  }
  const ConvexHull slab{Hull(corners)};
  {
    Lab lab(without_gravity());
    lab.add({.type = BodyType::fixed, .position = {-4, 0, 0}}, slab);
    const BodyId ball = lab.add({.linear_velocity = {kSpeed, 0, 0}}, Sphere{0.1f});
    lab.run(1);
    EXPECT_EQ(lab.world.stats().sweep_hits, 1);
    EXPECT_NEAR(lab.position(ball).x(), 2.9, 1e-3);
  }
  Lab lab(without_gravity());
  lab.add({.type = BodyType::fixed, .position = {3.01f, 0, 0}}, Box{{0.01f, 2, 2}});
  const BodyId bullet = lab.add({.position = {-8, 0, 0}, .linear_velocity = {kSpeed, 0, 0}}, slab);
  lab.run(1);
  EXPECT_EQ(lab.world.stats().sweep_hits, 1);
  EXPECT_NEAR(lab.position(bullet).x(), 2.5, 1e-3);
}

TEST(Swept, ShapesFarFromTheCenterOfMassAreSweptToo) {
  // A dumbbell that flies past a post with its middle and whose end would pass through the post.
  Lab lab(without_gravity());
  const BodyId wall = lab.add({.type = BodyType::fixed, .position = {4, 3, 0}}, Box{{0.005f, 1, 5}});
  const BodyId bell = lab.world.create_body({.linear_velocity = {kSpeed, 0, 0}});
  for (const float side : {-1.0f, 1.0f})
    lab.world.add_shape(bell, Sphere{0.2f}, {}, {.local_pose = {{0, 3 * side, 0}, {}}});
  lab.run(1);
  EXPECT_EQ(lab.world.stats().sweep_hits, 1);
  EXPECT_NEAR(lab.position(bell).x(), 3.795, 2e-3);
  EXPECT_GT(
      distance_from(lab.world, shape_of(lab.world, wall), lab.position(bell) + Eigen::Vector3d(0, 3, 0)),
      0.19);
}

TEST(Swept, ASleepingCrateIsHitAndWakes) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const BodyId crate = lab.add({.position = {10, 0.5f, 0}}, Box{});
  lab.run(120);
  ASSERT_FALSE(lab.world.is_awake(crate));
  const BodyId bullet =
      lab.add({.position = {3, 0.5f, 0}, .linear_velocity = {kSpeed, 0, 0}, .mass = 10.0f}, Sphere{0.05f});
  lab.run(4);
  EXPECT_TRUE(lab.world.is_awake(crate));
  EXPECT_LT(lab.position(bullet).x(), lab.position(crate).x());
  EXPECT_GT(lab.velocity(crate).x(), 1.0);
}

TEST(Swept, AWallJustCreatedOrMovedStopsBodies) {
  for (const bool sleeping : {false, true}) {
    WorldSettings settings = without_gravity();
    settings.sleeping = sleeping;
    Lab lab(settings);
    const BodyId wall = lab.add({.type = BodyType::fixed, .position = {3, 0, 0}}, Box{{0.005f, 2, 2}});
    const BodyId bullet = lab.add({.linear_velocity = {kSpeed, 0, 0}}, Sphere{0.05f});
    lab.run(1);
    EXPECT_NEAR(lab.position(bullet).x(), 2.945, 2e-3);
    lab.world.set_pose(wall, {{3, 8, 0}, {}});
    lab.world.set_pose(bullet, {{0, 8, 0}, {}});
    lab.world.set_linear_velocity(bullet, {kSpeed, 0, 0});
    lab.run(1);
    EXPECT_NEAR(lab.position(bullet).x(), 2.945, 2e-3);
    EXPECT_NEAR(lab.height(bullet), 8.0, 1e-3);
  }
}

TEST(Swept, BodiesThatDoNotCollideDoNotStop) {
  Lab lab(without_gravity());
  const BodyId wall = lab.world.create_body({.type = BodyType::fixed, .position = {3, 0, 0}});
  lab.world.add_shape(wall, Box{{0.005f, 2, 2}}, {}, {.filter = {.category = 2}});
  const BodyId ghost = lab.world.create_body({.linear_velocity = {kSpeed, 0, 0}});
  lab.world.add_shape(ghost, Sphere{0.05f}, {}, {.filter = {.mask = 1}});
  lab.run(1);
  EXPECT_EQ(lab.world.stats().swept_bodies, 1);
  EXPECT_NEAR(lab.position(ghost).x(), static_cast<double>(kSpeed * kStep), 1e-3);
}

TEST(Swept, SlowBodiesAndBodiesWithoutShapesAreNotSwept) {
  Lab lab;
  lab.add_ground();
  for (int i = 0; i < 20; ++i) lab.add({.position = {2.0f * static_cast<float>(i), 1, 0}}, Box{});
  lab.add({.position = {0, 3, 0}, .angular_velocity = {300, 0, 0}, .gravity_factor = 0}, Sphere{0.1f});
  lab.world.create_body({.position = {0, 100, 0}, .linear_velocity = {0, -kSpeed, 0}});
  for (int i = 0; i < 60; ++i) {
    lab.run(1);
    ASSERT_EQ(lab.world.stats().swept_bodies, 0);
  }
}

TEST(Swept, AShapesNewSizeCounts) {
  Lab lab(without_gravity());
  const BodyId ball = lab.add({.linear_velocity = {12, 0, 0}}, Sphere{0.1f});  // 0.2 m a step
  lab.run(1);
  EXPECT_EQ(lab.world.stats().swept_bodies, 1);
  lab.world.set_geometry(shape_of(lab.world, ball), Sphere{1.0f});
  lab.run(1);
  EXPECT_EQ(lab.world.stats().swept_bodies, 0);
  const ShapeId small = lab.world.add_shape(ball, Sphere{0.05f});
  lab.run(1);
  EXPECT_EQ(lab.world.stats().swept_bodies, 1);
  lab.world.destroy_shape(small);
  lab.run(1);
  EXPECT_EQ(lab.world.stats().swept_bodies, 0);
  lab.run(1, 0.0f);
  EXPECT_EQ(lab.world.stats().swept_bodies, 0);
}

TEST(Swept, AShapesReusedSlotCountsForBothBodies) {
  Lab lab(without_gravity());
  const BodyId ball = lab.add({.linear_velocity = {12, 0, 0}}, Sphere{1.0f});  // 0.2 m a step
  const ShapeId small = lab.world.add_shape(ball, Sphere{0.1f});
  lab.world.set_mass_properties(ball, {});  // so that the center stays where it is
  const BodyId other = lab.world.create_body({.position = {0, 100, 0}});
  lab.run(1);
  ASSERT_EQ(lab.world.stats().swept_bodies, 1);
  lab.world.destroy_shape(small);
  ASSERT_EQ(lab.world.add_shape(other, Sphere{1.0f}).index, small.index);
  lab.run(1);
  EXPECT_EQ(lab.world.stats().swept_bodies, 0);
}

}  // namespace
}  // namespace scree::physics
