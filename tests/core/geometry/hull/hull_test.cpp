// Laws of building hulls: canonical bits, sound polyhedra, and a report of all dropped points.
#include <tests/core/geometry/hull/hull_clouds.h>

#include <array>
#include <cstring>
#include <map>
#include <set>
#include <thread>

namespace scree::test {
namespace {

template <class Row>
bool same_bytes(const std::vector<Row>& a, const std::vector<Row>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Row)) == 0;
}

// Hash of everything that a step reads.
bool same_bits(const Hull& a, const Hull& b) {
  const HullSolid &s = solid_of(a), &t = solid_of(b);
  const HullData &m = *s.columns.data, &n = *t.columns.data;
  const auto columns = [](const HullData& data) {
    const auto* first = reinterpret_cast<const char*>(data.vertex[0]);
    return std::pair(first, static_cast<std::size_t>(reinterpret_cast<const char*>(data.offset) - first) +
                                static_cast<std::size_t>(data.padded_faces) * sizeof(float));
  };
  return s.content_hash == t.content_hash && a == b && same_bytes(s.topology.planes, t.topology.planes) &&
         same_bytes(s.topology.edges, t.topology.edges) &&
         std::memcmp(s.origin, t.origin, sizeof s.origin) == 0 &&
         std::memcmp(&s.integrals, &t.integrals, sizeof s.integrals) == 0 &&
         s.columns.bytes == t.columns.bytes && m.inner_radius == n.inner_radius &&
         m.outer_radius == n.outer_radius &&
         std::memcmp(columns(m).first, columns(n).first, columns(m).second) == 0;
}

// FNV-1a (Fowler, Noll, Vo) over the bytes.
template <class Row>
void add_to_hash(std::uint64_t& hash, const Row* rows, std::size_t count) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(rows);
  for (std::size_t i = 0; i < count * sizeof(Row); ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
}

// The same for every compiler and build type. If it changes, the results of worlds with hulls change, and
// their golden hashes must be recorded again.
TEST(Hull, BitsEqualTheRecordedHash) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const NamedCloud& cloud : all_clouds()) {
    const std::string name = cloud.name;
    if (name == "prism" || name == "cylinder") continue;  // their points come from the platform's cosine
    const Hull hull(cloud.points);
    const HullSolid& solid = solid_of(hull);
    const HullTopology& topology = solid.topology;
    add_to_hash(hash, topology.vertices.data(), topology.vertices.size());
    add_to_hash(hash, topology.loops.data(), topology.loops.size());
    add_to_hash(hash, topology.planes.data(), topology.planes.size());
    add_to_hash(hash, &solid.integrals, 1);
    add_to_hash(hash, solid.origin, 3);
    add_to_hash(hash, &solid.columns.data->inner_radius, 2);  // and the outer one
  }
  EXPECT_EQ(hash, 0x7df7d4ea40f00c09u);
}

void shuffle(Cloud& cloud, Random& random) {
  for (std::size_t i = cloud.size(); i > 1; --i) std::swap(cloud[i - 1], cloud[random.below(i)]);
}

TEST(Hull, EqualPointsInAnyOrderGiveTheSameBits) {
  Random random(1);
  for (const NamedCloud& cloud : all_clouds()) {
    const Hull hull(cloud.points);
    for (int round = 0; round < 3; ++round) {
      Cloud mixed = cloud.points;
      mixed.insert(mixed.end(), cloud.points.begin(), cloud.points.begin() + round);  // twice
      for (Vec3& p : mixed) {
        if (p.x == 0.0f) p.x = -p.x;  // zero has two signs
      }
      shuffle(mixed, random);
      EXPECT_TRUE(same_bits(Hull(mixed), hull)) << cloud.name;
    }
  }
}

TEST(Hull, ThreadsThatBuildAtOnceGetTheSameBits) {
  const Cloud cloud = sphere_cloud(3000, 9);
  const Hull expected(cloud);
  std::array<Hull, 4> hulls;
  std::vector<std::thread> threads;
  for (Hull& hull : hulls) threads.emplace_back([&] { hull = Hull(cloud); });
  for (std::thread& thread : threads) thread.join();
  for (const Hull& hull : hulls) EXPECT_TRUE(same_bits(hull, expected));
}

TEST(Hull, CornersFacesAndEdgesAreInCanonicalOrder) {
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  };
  for (const NamedCloud& cloud : all_clouds()) {
    const Hull hull(cloud.points);
    const HullTopology& topology = solid_of(hull).topology;
    EXPECT_TRUE(std::is_sorted(topology.vertices.begin(), topology.vertices.end(), before)) << cloud.name;
    std::vector<std::vector<std::uint8_t>> loops;
    for (std::size_t f = 0; f < hull.face_count(); ++f) {
      loops.emplace_back(hull.face(f).begin(), hull.face(f).end());
      EXPECT_EQ(loops.back().front(), *std::min_element(loops.back().begin(), loops.back().end()));
    }
    EXPECT_TRUE(std::is_sorted(loops.begin(), loops.end())) << cloud.name;
    for (std::size_t e = 0; e < topology.edges.size(); ++e) {
      const std::uint8_t* v = topology.edges[e].vertex;
      EXPECT_LT(v[0], v[1]);
      if (e == 0) continue;
      const std::uint8_t* u = topology.edges[e - 1].vertex;
      EXPECT_LT(std::pair(u[0], u[1]), std::pair(v[0], v[1])) << cloud.name;
    }
  }
}

TEST(Hull, EulersFormulaHoldsAndEveryEdgeLiesInItsTwoFaces) {
  for (const NamedCloud& cloud : all_clouds()) {
    const Hull hull(cloud.points);
    const HullTopology& topology = solid_of(hull).topology;
    EXPECT_EQ(hull.vertices().size() + hull.face_count(), hull.edge_count() + 2) << cloud.name;
    std::map<std::pair<int, int>, std::size_t> face_of;  // by directed edge
    std::map<int, int> faces_at;                         // by corner
    for (std::size_t f = 0; f < hull.face_count(); ++f) {
      const auto loop = hull.face(f);
      ASSERT_GE(loop.size(), 3u);
      for (std::size_t k = 0; k < loop.size(); ++k) {
        ++faces_at[loop[k]];
        EXPECT_TRUE(face_of.emplace(std::pair(loop[k], loop[(k + 1) % loop.size()]), f).second);
      }
    }
    EXPECT_EQ(face_of.size(), 2 * topology.edges.size());
    for (const HullTopology::Edge& edge : topology.edges) {
      EXPECT_EQ(face_of.at({edge.vertex[0], edge.vertex[1]}), edge.face[0]) << cloud.name;
      EXPECT_EQ(face_of.at({edge.vertex[1], edge.vertex[0]}), edge.face[1]) << cloud.name;
    }
    ASSERT_EQ(faces_at.size(), hull.vertices().size()) << cloud.name;
    for (const auto& [corner, faces] : faces_at) EXPECT_GE(faces, 3) << cloud.name << " " << corner;
  }
}

TEST(Hull, NoCornerLiesOutsideAPlaneAndEveryFaceLiesInIts) {
  for (const NamedCloud& cloud : all_clouds()) {
    const Hull hull(cloud.points);
    const HullTopology& topology = solid_of(hull).topology;
    const double flat = 1e-5 * extent_of(cloud.points);
    for (std::size_t f = 0; f < topology.planes.size(); ++f) {
      const auto& [n, offset] = topology.planes[f];
      const auto reach = [&n = n](const Vec3& v) {
        return double{n[0]} * v.x + double{n[1]} * v.y + double{n[2]} * v.z;
      };
      EXPECT_NEAR(double{n[0]} * n[0] + double{n[1]} * n[1] + double{n[2]} * n[2], 1.0, 3e-7) << cloud.name;
      for (const Vec3& v : topology.vertices) ASSERT_LE(reach(v), double{offset}) << cloud.name;
      for (const std::uint8_t corner : hull.face(f)) {
        ASSERT_NEAR(reach(topology.vertices[corner]), offset, flat) << cloud.name;
      }
      EXPECT_GT(offset, 0.0f) << cloud.name << ": the centroid lies within";
    }
  }
}

struct Wide {
  double x, y, z;
};
Wide minus(const Vec3& a, const Vec3& b) { return {double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z}; }
Wide cross_of(const Wide& a, const Wide& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

TEST(Hull, FacesAreConvexAndBendAwayFromTheirNeighbors) {
  for (const NamedCloud& cloud : all_clouds()) {
    const Hull hull(cloud.points);
    const HullTopology& topology = solid_of(hull).topology;
    for (std::size_t f = 0; f < hull.face_count(); ++f) {
      const auto loop = hull.face(f);
      const float* n = topology.planes[f].normal;
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vec3& a = topology.vertices[loop[k]];
        const Vec3& b = topology.vertices[loop[(k + 1) % loop.size()]];
        const Vec3& c = topology.vertices[loop[(k + 2) % loop.size()]];
        const Wide turn = cross_of(minus(b, a), minus(c, b));
        EXPECT_GT(turn.x * n[0] + turn.y * n[1] + turn.z * n[2], 0.0) << cloud.name << " face " << f;
      }
    }
    for (const HullTopology::Edge& edge : topology.edges) {
      // The other face, apart from the common edge, lies below this face's plane.
      for (int side = 0; side < 2; ++side) {
        const float* n = topology.planes[edge.face[side]].normal;
        const Vec3& on_edge = topology.vertices[edge.vertex[0]];
        double lowest = 0.0;
        for (const std::uint8_t corner : hull.face(edge.face[1 - side])) {
          const Wide arm = minus(topology.vertices[corner], on_edge);
          lowest = std::min(lowest, arm.x * n[0] + arm.y * n[1] + arm.z * n[2]);
        }
        EXPECT_LT(lowest, 0.0) << cloud.name;
      }
    }
  }
}

TEST(Hull, CoplanarPointsMakeOneFace) {
  for (const Vec3& shift : {Vec3{}, Vec3{100, -50, 20}}) {
    const Hull box(turned(lattice(9, {1.0f, 2.0f, 3.0f}), kTurn, shift));
    EXPECT_EQ(box.vertices().size(), 8u);
    EXPECT_EQ(box.edge_count(), 12u);
    EXPECT_EQ(box.face_count(), 6u);
    EXPECT_EQ(box.report().inner_points, 9u * 9u * 9u - 8u - box.report().merged_points);
    EXPECT_NEAR(box.volume(), 6.0, 6e-5);
  }
  for (const int sides : {3, 5, 12, 64, 128}) {
    const Hull hull(turned(prism(sides, 1.0f, 2.0f), kTurn));
    EXPECT_EQ(hull.vertices().size(), 2u * static_cast<unsigned>(sides));
    EXPECT_EQ(hull.face_count(), 2u + static_cast<unsigned>(sides));
  }
}

TEST(Hull, AHullIsTheHullOfItsVertices) {
  for (const NamedCloud& cloud : all_clouds()) {
    const Hull hull(cloud.points);
    const Hull again(hull.vertices());
    EXPECT_TRUE(same_bits(again, hull)) << cloud.name;
    EXPECT_EQ(again.report().cut_vertices, 0u) << cloud.name;
  }
}

// The largest difference of the reach of points and hull over many directions: it comes from below to the
// distance of the farthest point, because the distance to a convex set is the largest such difference.
double outreach(const Cloud& cloud, const Hull& hull, int directions) {
  const HullSolid& solid = solid_of(hull);
  Random random(77);
  double largest = 0.0;
  for (int k = 0; k < directions; ++k) {
    const Vec3 d = k < 200 ? random_unit(random) : Vec3{};
    std::array<double, 3> n{d.x, d.y, d.z};
    if (k >= 200) {  // toward the points themselves
      const Vec3& p = cloud[random.below(cloud.size())];
      n = {p.x - solid.origin[0], p.y - solid.origin[1], p.z - solid.origin[2]};
      const double size = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      if (size == 0.0) continue;
      for (double& x : n) x /= size;
    }
    double points = -1e300, corners = -1e300;
    for (const Vec3& p : cloud) {
      points = std::max(points, n[0] * (p.x - solid.origin[0]) + n[1] * (p.y - solid.origin[1]) +
                                    n[2] * (p.z - solid.origin[2]));
    }
    for (const Vec3& v : solid.topology.vertices) {
      corners = std::max(corners, n[0] * v.x + n[1] * v.y + n[2] * v.z);
    }
    largest = std::max(largest, points - corners);
  }
  return largest;
}

TEST(Hull, NoPointLiesFartherOutsideThanTheReportSays) {
  for (const NamedCloud& cloud : all_clouds()) {
    for (const int limit : {256, 32, 8, 4}) {
      const Hull hull(cloud.points, {.max_vertices = limit});
      const HullReport& report = hull.report();
      EXPECT_LE(hull.vertices().size(), static_cast<std::size_t>(limit));
      EXPECT_EQ(report.given_points, cloud.points.size());
      EXPECT_EQ(report.merged_points + report.inner_points + report.cut_vertices + hull.vertices().size(),
                cloud.points.size());
      // The report leaves out the rounding to the hull's grid, of 2^-23 of half the extent.
      const double rounding = 2e-7 * extent_of(cloud.points);
      EXPECT_LE(outreach(cloud.points, hull, 400), double{report.deviation} + rounding)
          << cloud.name << limit;
      if (!report.simplified()) {
        // Flat hulls have sharp edges: a point that sticks out little of a plane can be farther from the
        // hull.
        EXPECT_LE(report.deviation, 1e-4 * extent_of(cloud.points)) << cloud.name << " " << limit;
      }
    }
  }
}

TEST(Hull, FlatHullsKeepTheirTips) {
  for (const float flatness : {1e-2f, 1e-3f, 1e-4f, 2e-5f}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Cloud cloud = turned(stretched(cube_cloud(40, seed), {10.0f, 10.0f * flatness, 10.0f}), kTurn);
      const Hull hull(cloud);
      EXPECT_LE(hull.report().deviation, 1e-4 * extent_of(cloud)) << flatness << " " << seed;
    }
  }
}

TEST(Hull, TheReportedDeviationIsReached) {
  const Cloud cloud = sphere_cloud(1000, 11);
  for (const int limit : {6, 16, 64}) {
    const Hull hull(cloud, {.max_vertices = limit});
    EXPECT_EQ(hull.report().cut_vertices, 1000u - static_cast<unsigned>(limit));
    EXPECT_GT(outreach(cloud, hull, 1200), 0.9 * double{hull.report().deviation});
  }
}

TEST(Hull, MoreVerticesComeCloserToThePoints) {
  const Cloud cloud = sphere_cloud(3000, 12);
  double last = 2.0;
  for (const int limit : {4, 8, 16, 32, 64, 128, 256}) {
    const Hull hull(cloud, {.max_vertices = limit});
    EXPECT_EQ(hull.vertices().size(), static_cast<std::size_t>(limit));
    EXPECT_LT(hull.report().deviation, last) << limit;
    last = hull.report().deviation;
  }
  EXPECT_LT(last, 0.02);  // a fifth of the spacing of 256 points on a sphere
}

TEST(Hull, PublicDataAgreesWithTheColumns) {
  for (const NamedCloud& cloud : all_clouds()) {
    const Hull hull(cloud.points);
    const HullSolid& solid = solid_of(hull);
    const HullData& data = *solid.columns.data;
    const double fine = 3e-7 * extent_of(cloud.points);
    ASSERT_EQ(static_cast<std::size_t>(data.vertex_count), hull.vertices().size());
    ASSERT_EQ(static_cast<std::size_t>(data.face_count), hull.face_count());
    EXPECT_EQ(static_cast<std::size_t>(data.edge_count), hull.edge_count());
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&data) % 64, 0u);
    for (int i = 0; i < data.padded_vertices; ++i) {
      const auto corner = static_cast<std::size_t>(i < data.vertex_count ? i : 0);
      const Vec3& v = hull.vertices()[corner];
      EXPECT_NEAR(data.vertex[0][i] + solid.origin[0], v.x, fine) << cloud.name;
      EXPECT_NEAR(data.vertex[1][i] + solid.origin[1], v.y, fine) << cloud.name;
      EXPECT_NEAR(data.vertex[2][i] + solid.origin[2], v.z, fine) << cloud.name;
      const double size = std::hypot(data.vertex[0][i], data.vertex[1][i], data.vertex[2][i]);
      EXPECT_LE(size, data.outer_radius * (1.0 + 1e-7));
    }
    EXPECT_EQ(data.padded_vertices % kHullPadding, 0);
    EXPECT_EQ(data.padded_faces % kHullPadding, 0);
    for (int f = 0; f < data.padded_faces; ++f) {
      if (f < data.face_count) {
        EXPECT_LE(data.inner_radius, data.offset[f]);
      } else {
        EXPECT_EQ(data.offset[f], 1e30f);
      }
    }
    EXPECT_GT(data.inner_radius, 0.0f) << cloud.name;
    // The frame of the columns is the centroid's, within the grid.
    const double* center = solid.integrals.center;
    EXPECT_LE(std::hypot(center[0], center[1], center[2]), fine) << cloud.name;
  }
}

TEST(Hull, AnEmptyHullHasNothing) {
  Hull empty;
  EXPECT_TRUE(empty.is_empty());
  EXPECT_TRUE(empty.vertices().empty());
  EXPECT_EQ(empty.face_count() + empty.edge_count(), 0u);
  EXPECT_EQ(empty.volume(), 0.0f);
  EXPECT_EQ(empty.report().given_points, 0u);
  EXPECT_EQ(empty, Hull());
  const Hull box(lattice(2, {1, 1, 1}));
  EXPECT_NE(empty, box);
  EXPECT_EQ(error_of([&] { empty.face(0); }), "Hull::face: index is 0, but the hull has 0 faces");
  Hull from = box;
  const Hull moved = std::move(from);
  EXPECT_EQ(moved, box);
}

}  // namespace
}  // namespace scree::test
