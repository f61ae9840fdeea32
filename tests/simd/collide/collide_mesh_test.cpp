// Convex shapes against triangle meshes: distances by brute force in double precision, seams, equal bits.
#include <core/geometry/mesh/mesh_build.h>

#include "hull_fixture.h"

#include <limits>
#include <optional>

namespace scree::collide_tests {
namespace {

using reference::Vector;

Vector to_double(Vec3 v) { return {double(v.x), double(v.y), double(v.z)}; }

using Triangle = std::array<Vector, 3>;

double point_to_segment(const Vector& p, const Vector& a, const Vector& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}
double point_to_triangle(const Vector& p, const Triangle& t) {
  const Vector n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  bool over = true;
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector &a = t[k], &b = t[(k + 1) % 3];
    over = over && (b - a).cross(p - a).dot(n) >= 0.0;
    nearest = std::min(nearest, point_to_segment(p, a, b));
  }
  return over ? std::abs(n.dot(p - t[0])) : nearest;
}
double segment_to_segment(const Vector& p, const Vector& q, const Vector& a, const Vector& b) {
  double nearest = std::min({point_to_segment(p, a, b), point_to_segment(q, a, b), point_to_segment(a, p, q),
                             point_to_segment(b, p, q)});
  const Vector d = q - p, e = b - a, way = a - p;
  const Vector upright = d.cross(e);
  const double square = upright.squaredNorm();
  if (square < 1e-20 * d.squaredNorm() * e.squaredNorm()) return nearest;
  const double s = way.cross(e).dot(upright) / square, t = way.cross(d).dot(upright) / square;
  if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0)
    nearest = std::min(nearest, std::abs(way.dot(upright)) / std::sqrt(square));
  return nearest;
}
bool crosses(const Vector& p, const Vector& q, const Triangle& t) {
  const Vector n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double from = n.dot(p - t[0]), to = n.dot(q - t[0]);
  if ((from > 0.0) == (to > 0.0)) return false;
  const Vector at = p + from / (from - to) * (q - p);
  for (std::size_t k = 0; k < 3; ++k) {
    if ((t[(k + 1) % 3] - t[k]).cross(at - t[k]).dot(n) < 0.0) return false;
  }
  return true;
}
double segment_to_triangle(const Vector& p, const Vector& q, const Triangle& t) {
  if (crosses(p, q, t)) return 0.0;
  double nearest = std::min(point_to_triangle(p, t), point_to_triangle(q, t));
  for (std::size_t k = 0; k < 3; ++k)
    nearest = std::min(nearest, segment_to_segment(p, q, t[k], t[(k + 1) % 3]));
  return nearest;
}
double triangle_to_triangle(const Triangle& x, const Triangle& y) {
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k < 3; ++k) {
    nearest = std::min({nearest, segment_to_triangle(x[k], x[(k + 1) % 3], y),
                        segment_to_triangle(y[k], y[(k + 1) % 3], x)});
  }
  return nearest;
}

// Hills: a grid whose heights are drawn at random; 0: flat.
struct Hills {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;
  std::shared_ptr<const MeshSolid> solid;
};
Hills make_hills(int cells, float cell, float height, unsigned seed) {
  Hills hills;
  Random random(seed);
  const auto side = static_cast<std::uint32_t>(cells) + 1;
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      hills.vertices.push_back({cell * (float(column) - 0.5f * float(cells)),
                                height * random.uniform(0.0f, 1.0f),
                                cell * (float(row) - 0.5f * float(cells))});
    }
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      const bool turned = random.uniform(0.0f, 1.0f) < 0.5f;
      hills.triangles.push_back(turned ? MeshTriangle{a, c, b} : MeshTriangle{a, c, d});
      hills.triangles.push_back(turned ? MeshTriangle{b, c, d} : MeshTriangle{a, d, b});
    }
  }
  hills.solid = build_mesh("test", hills.vertices, hills.triangles, {});
  return hills;
}

// A shape at a pose beside hills that are moved and turned themselves.
struct Encounter {
  Shape shape;
  Hull hull;  // of ShapeType::hull
  PoseRow pose;
};

struct World {
  const Hills& hills;
  PoseRow mesh_pose;

  Vector place(const Vector& local) const {
    const reference::Solid frame = reference::make_solid(ShapeType::box, {}, mesh_pose);
    return frame.position + frame.rotation * local;
  }
  std::vector<Triangle> placed() const {
    std::vector<Triangle> all;
    const Vector origin(hills.solid->origin[0], hills.solid->origin[1], hills.solid->origin[2]);
    for (const MeshTriangle& t : hills.triangles) {
      all.push_back({place(to_double(hills.vertices[t.a]) - origin),
                     place(to_double(hills.vertices[t.b]) - origin),
                     place(to_double(hills.vertices[t.c]) - origin)});
    }
    return all;
  }
};

// Contacts of each encounter, all found by one call.
using Contacts = std::vector<simd::TriangleContact>;
std::vector<Contacts> collide_all(const simd::Kernels& kernels, const World& world,
                                  const std::vector<Encounter>& encounters, int capacity = 4096) {
  const std::size_t count = encounters.size();
  std::vector<PoseRow> poses;
  std::vector<ExtentRow> extents;
  std::vector<const HullData*> hulls(count);
  std::vector<std::int32_t> shape_hull, shape_mesh(count, -1);
  std::vector<simd::CollideItem> items;
  std::vector<simd::MeshFirstType> types;
  for (std::size_t i = 0; i < count; ++i) {
    const Encounter& encounter = encounters[i];
    const auto number = static_cast<std::int32_t>(i), mesh = static_cast<std::int32_t>(count);
    const bool is_hull = encounter.shape.type == ShapeType::hull;
    poses.push_back(encounter.pose);
    extents.push_back(encounter.shape.extent);
    hulls[i] = is_hull ? HullAccess::solid(encounter.hull)->columns.data : nullptr;
    shape_hull.push_back(is_hull ? number : -1);
    items.push_back(
        {number, mesh, number, mesh, 0, simd::kItemFlip | simd::kItemStatic | simd::kItemFixed, 0});
    types.push_back(static_cast<simd::MeshFirstType>(encounter.shape.type));
  }
  poses.push_back(world.mesh_pose);
  extents.push_back(world.hills.solid->extent);
  shape_hull.push_back(-1);
  shape_mesh.push_back(0);
  const std::vector<VelocityRow> velocities(count + 1);
  const std::vector<MaterialRow> materials(count + 1);
  const MeshData* meshes[1] = {&world.hills.solid->data};
  const simd::CollideColumns columns{.shape_pose = poses.data(),
                                     .shape_extent = extents.data(),
                                     .shape_material = materials.data(),
                                     .shape_hull = shape_hull.data(),
                                     .hulls = hulls.data(),
                                     .shape_mesh = shape_mesh.data(),
                                     .meshes = meshes,
                                     .body_pose = poses.data(),
                                     .body_velocity = velocities.data(),
                                     .dt = 0.0f,
                                     .manifold = nullptr,
                                     .features = nullptr,
                                     .surface = nullptr,
                                     .anchor = nullptr,
                                     .axis = nullptr,
                                     .points = nullptr};
  Contacts found(static_cast<std::size_t>(capacity));
  std::vector<int> ends(count);
  while (!kernels.collide.collide_meshes({columns, items.data(), types.data(), static_cast<int>(count),
                                          found.data(), static_cast<int>(found.size()), ends.data()})) {
    found.resize(2 * found.size());
  }
  std::vector<Contacts> all;
  for (std::size_t i = 0; i < count; ++i) {
    all.emplace_back(found.begin() + (i == 0 ? 0 : ends[i - 1]), found.begin() + ends[i]);
  }
  return all;
}

Contacts collide(const simd::Kernels& kernels, const World& world, const Encounter& encounter,
                 int capacity = 4096) {
  return collide_all(kernels, world, {encounter}, capacity).front();
}

// The shape's surface without its radius: a point, a segment or triangles.
double distance_to(const Encounter& encounter, const Triangle& triangle) {
  const Shape& shape = encounter.shape;
  const reference::Solid solid = reference::make_solid(shape.type, shape.extent, encounter.pose);
  if (shape.type == ShapeType::sphere) return point_to_triangle(solid.position, triangle) - solid.radius;
  if (shape.type == ShapeType::capsule) {
    const Vector half = solid.rotation.col(1) * solid.half.y();
    return segment_to_triangle(solid.position - half, solid.position + half, triangle) - solid.radius;
  }
  const HullTopology& topology = topology_of(encounter.hull);
  const auto corner = [&](std::size_t vertex) -> Vector {
    return solid.position + solid.rotation * to_double(topology.vertices[vertex]);
  };
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t face = 0; face + 1 < topology.begin.size(); ++face) {
    const std::uint8_t* const loop = topology.loops.data() + topology.begin[face];
    const int corners = topology.begin[face + 1] - topology.begin[face];
    for (int k = 1; k + 1 < corners; ++k) {
      const Triangle part{corner(loop[0]), corner(loop[k]), corner(loop[k + 1])};
      nearest = std::min(nearest, triangle_to_triangle(part, triangle));
    }
  }
  return nearest;
}

// Of a ball around the shape.
double radius_of(const Shape& shape) {
  const ExtentRow& extent = shape.extent;
  return to_double({extent.half[0], extent.half[1], extent.half[2]}).norm() + double(extent.radius);
}

double nearest_of(const Encounter& encounter, const std::vector<Triangle>& triangles) {
  const Vector center = to_vector(encounter.pose.position);
  double nearest = std::numeric_limits<double>::max();
  for (const Triangle& triangle : triangles) {
    if (point_to_triangle(center, triangle) - radius_of(encounter.shape) > nearest) continue;
    nearest = std::min(nearest, distance_to(encounter, triangle));
  }
  return nearest;
}

double deepest_of(const std::vector<simd::TriangleContact>& contacts) {
  double deepest = std::numeric_limits<double>::max();
  for (const simd::TriangleContact& contact : contacts) {
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      if (contact.id[k] != 0) deepest = std::min(deepest, double(contact.separation[k]));
    }
  }
  return deepest;
}

World random_world(const Hills& hills, Random& random) {
  return {hills, pose_row(20.0f * random.vector(), random.rotation())};
}

// Moves the shape along the hills' upward axis until it is `gap` from them.
void lower_to(const World& world, const std::vector<Triangle>& triangles, double gap, Encounter& encounter) {
  const Vector up = world.place({0, 1, 0}) - world.place({0, 0, 0});
  for (int i = 0; i < 60; ++i) {
    const double left = nearest_of(encounter, triangles) - gap;
    if (std::abs(left) < 1e-7) return;
    const double way = 0.9 * left;  // the distance shrinks at most as fast
    for (int axis = 0; axis < 3; ++axis) encounter.pose.position[axis] -= static_cast<float>(way * up[axis]);
  }
}

Encounter random_encounter(const World& world, ShapeType type, float size, Random& random,
                           const std::vector<ZooHull>& zoo) {
  Encounter encounter;
  switch (type) {
    case ShapeType::sphere:
      encounter.shape = sphere(size * random.uniform(0.1f, 1.0f));
      break;
    case ShapeType::capsule:
      encounter.shape = capsule(size * random.uniform(0.1f, 1.0f), size * random.uniform(0.05f, 0.5f));
      break;
    case ShapeType::box: {
      const float x = size * random.uniform(0.1f, 1.0f), y = size * random.uniform(0.1f, 1.0f),
                  z = size * random.uniform(0.1f, 1.0f);
      encounter.shape = box(x, y, z);
      encounter.hull = hull_of(box_points(x, y, z));
      break;
    }
    default: {
      const auto which = static_cast<std::size_t>(random.uniform(0.0f, float(zoo.size()) - 0.01f));
      encounter.hull = zoo[which].hull;
      encounter.shape = {ShapeType::hull, {}};
      const HullSolid& solid = *HullAccess::solid(encounter.hull);
      for (const Vec3& v : solid.topology.vertices) {
        for (int axis = 0; axis < 3; ++axis) {
          float& half = encounter.shape.extent.half[axis];
          half = std::max(half, std::abs(v[axis]));
        }
      }
      encounter.shape.extent.radius = solid.columns.data->outer_radius;
      break;
    }
  }
  const Vector at = world.place(to_double(random.vector()) + Vector(0, 4.0 * double(size) + 3.0, 0));
  encounter.pose = pose_row({float(at.x()), float(at.y()), float(at.z())}, random.rotation());
  return encounter;
}

class CollideMesh : public testing::TestWithParam<ShapeType> {};

// What is apart but within reach has a contact; no contact says that it overlaps, or is farther than it is.
TEST_P(CollideMesh, ShapesApartHaveTheirDistance) {
  const ShapeType type = GetParam();
  const bool is_round = type == ShapeType::sphere || type == ShapeType::capsule;
  const std::vector<ZooHull> zoo = small_zoo();
  Random random(static_cast<unsigned>(type) + 5);
  int compared = 0, exact = 0;
  for (const float height : {0.0f, 0.1f, 0.5f}) {
    const Hills hills = make_hills(8, 0.7f, height, 3);
    for (int i = 0; i < (is_round ? 60 : 20); ++i) {
      const World world = random_world(hills, random);
      const std::vector<Triangle> triangles = world.placed();
      Encounter encounter = random_encounter(world, type, 0.8f, random, zoo);
      const double gap = 0.9 * double(kSpeculativeDistance) * double(random.uniform(0.05f, 1.0f));
      lower_to(world, triangles, gap, encounter);
      const double distance = nearest_of(encounter, triangles);
      if (std::abs(distance - gap) > 1e-5) continue;
      ++compared;
      const auto contacts = collide(scalar_kernels(), world, encounter);
      ASSERT_FALSE(contacts.empty()) << "height " << height << " case " << i << " distance " << distance;
      const double deepest = deepest_of(contacts);
      EXPECT_GT(deepest, is_round ? distance - 2e-5 : -2e-5) << "height " << height << " case " << i;
      // A capsule over a face prefers that to an edge that is hardly closer.
      const double slack =
          2e-5 + (type == ShapeType::capsule ? 0.01 * double(encounter.shape.extent.radius) : 0.0);
      EXPECT_LT(deepest, distance + slack) << "height " << height << " case " << i;
      exact += std::abs(deepest - distance) < slack ? 1 : 0;
    }
  }
  EXPECT_GT(compared, is_round ? 150 : 50);
  // Polytopes with corners opposite each other have a gap along every axis that is less than the distance.
  EXPECT_GT(exact, is_round ? compared - 1 : compared * 3 / 4);
}

TEST_P(CollideMesh, EveryInstructionSetAndAnyRoomGiveTheSameContacts) {
  const std::vector<ZooHull> zoo = whole_zoo();
  Random random(static_cast<unsigned>(GetParam()) + 50);
  std::size_t contacts = 0;
  const Hills hills = make_hills(30, 0.2f, 0.15f, 8);
  for (int i = 0; i < 200; ++i) {
    const World world = random_world(hills, random);
    Encounter encounter = random_encounter(world, GetParam(), 1.0f, random, zoo);
    const Vector at = world.place(
        {double(random.uniform(-2, 2)), double(random.uniform(0, 1)), double(random.uniform(-2, 2))});
    for (int axis = 0; axis < 3; ++axis) encounter.pose.position[axis] = static_cast<float>(at[axis]);
    const auto expected = collide(scalar_kernels(), world, encounter);
    contacts += expected.size();
    for (const simd::Kernels* kernels : all_kernels()) {
      for (const int capacity : {simd::kLeastMeshCapacity, 4096}) {
        const auto found = collide(*kernels, world, encounter, capacity);
        ASSERT_EQ(found.size(), expected.size()) << kernels->name << " case " << i;
        ASSERT_TRUE(found.empty() ||
                    std::memcmp(found.data(), expected.data(), found.size() * sizeof found[0]) == 0)
            << kernels->name << " case " << i;
      }
    }
  }
  EXPECT_GT(contacts, 400u);
}

// Triangles of several pairs are clipped together.
TEST_P(CollideMesh, ManyPairsAtOnceHaveTheContactsOfEach) {
  const std::vector<ZooHull> zoo = whole_zoo();
  Random random(static_cast<unsigned>(GetParam()) + 70);
  const Hills hills = make_hills(30, 0.2f, 0.15f, 8);
  std::size_t contacts = 0;
  for (int i = 0; i < 20; ++i) {
    const World world = random_world(hills, random);
    std::vector<Encounter> encounters;
    for (int k = 0; k < simd::kMeshChunk; ++k) {
      Encounter encounter = random_encounter(world, GetParam(), 1.0f, random, zoo);
      const Vector at = world.place(
          {double(random.uniform(-2, 2)), double(random.uniform(0, 1)), double(random.uniform(-2, 2))});
      for (int axis = 0; axis < 3; ++axis) encounter.pose.position[axis] = static_cast<float>(at[axis]);
      encounters.push_back(encounter);
    }
    for (const simd::Kernels* kernels : all_kernels()) {
      for (const int capacity : {simd::kLeastMeshCapacity, 4096}) {
        const std::vector<Contacts> found = collide_all(*kernels, world, encounters, capacity);
        for (std::size_t k = 0; k < encounters.size(); ++k) {
          const Contacts alone = collide(*kernels, world, encounters[k]);
          contacts += alone.size();
          ASSERT_EQ(found[k].size(), alone.size()) << kernels->name << " case " << i << " pair " << k;
          ASSERT_TRUE(alone.empty() ||
                      std::memcmp(found[k].data(), alone.data(), alone.size() * sizeof alone[0]) == 0)
              << kernels->name << " case " << i << " pair " << k;
        }
      }
    }
  }
  EXPECT_GT(contacts, 400u);
}

// Over a flat mesh all contacts push straight up, wherever the seams are.
TEST_P(CollideMesh, FlatMeshesPushAlongTheirNormalAlone) {
  const std::vector<ZooHull> zoo = small_zoo();
  Random random(static_cast<unsigned>(GetParam()) + 90);
  const Hills hills = make_hills(20, 0.25f, 0.0f, 4);
  int contacts = 0;
  for (int i = 0; i < 300; ++i) {
    const World world{hills, pose_row({0, 0, 0}, {})};
    Encounter encounter = random_encounter(world, GetParam(), 0.5f, random, zoo);
    encounter.pose.position[0] = random.uniform(-1.0f, 1.0f);
    encounter.pose.position[1] = random.uniform(0.0f, 0.3f);
    encounter.pose.position[2] = random.uniform(-1.0f, 1.0f);
    const Quat rotation{encounter.pose.rotation[0], encounter.pose.rotation[1], encounter.pose.rotation[2],
                        encounter.pose.rotation[3]};
    for (const simd::TriangleContact& contact : collide(scalar_kernels(), world, encounter)) {
      const Vec3 normal = rotate(rotation, Vec3{contact.normal[0], contact.normal[1], contact.normal[2]});
      EXPECT_NEAR(normal.y, -1.0f, 2e-6f) << "case " << i;
      ++contacts;
    }
  }
  EXPECT_GT(contacts, 25);
}

TEST_P(CollideMesh, NonFinitePosesTouchNothing) {
  const std::vector<ZooHull> zoo = small_zoo();
  Random random(7);
  const Hills hills = make_hills(8, 0.5f, 0.1f, 4);
  const World world{hills, pose_row({0, 0, 0}, {})};
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (int k = 0; k < 7; ++k) {
      Encounter encounter = random_encounter(world, GetParam(), 0.5f, random, zoo);
      for (float& coordinate : encounter.pose.position) coordinate = 0.1f;
      (k < 3 ? encounter.pose.position[k] : encounter.pose.rotation[k - 3]) = bad;
      EXPECT_TRUE(collide(scalar_kernels(), world, encounter).empty()) << k;
    }
  }
}

std::string mesh_case_name(const testing::TestParamInfo<ShapeType>& info) {
  constexpr const char* kNames[] = {"spheres", "capsules", "boxes", "hulls"};
  return kNames[static_cast<int>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(Of, CollideMesh,
                         testing::Values(ShapeType::sphere, ShapeType::capsule, ShapeType::box,
                                         ShapeType::hull),
                         mesh_case_name);

}  // namespace
}  // namespace scree::collide_tests
