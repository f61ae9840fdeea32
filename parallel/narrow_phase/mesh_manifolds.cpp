// See mesh_manifolds.h.
#include <core/world/edit.h>
#include <core/world/math.h>
#include <parallel/narrow_phase/mesh_manifolds.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scree {

namespace {

using simd::MeshManifold;
using simd::TriangleContact;

// Cosine of 3 degrees: normals closer than this are one. Points keep their own separations.
constexpr float kOneNormal = 0.9986f;
// Depths that differ by less than this are equal, so that jitter does not exchange points; m.
constexpr float kTie = 0.01f * kLinearSlop;
// And distances and areas that differ by less than this share.
constexpr float kTieShare = 1e-3f;

float deepest_of(const TriangleContact& contact) {
  return *std::min_element(std::begin(contact.separation), std::end(contact.separation));
}

std::int32_t material_of(const MeshData& mesh, std::int32_t triangle) {
  return mesh.material != nullptr ? mesh.material[triangle] : kShapeMaterial;
}

void sort_by_depth(const MeshScratch& scratch) {
  Column<std::int32_t>& order = scratch.order;
  order.resize_discarding(scratch.contacts.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
  std::sort(order.begin(), order.end(), [&](std::int32_t x, std::int32_t y) {
    const float depth_x = deepest_of(scratch.contacts[x]), depth_y = deepest_of(scratch.contacts[y]);
    return depth_x != depth_y ? depth_x < depth_y : x < y;
  });
}

// The manifold from `first` on that the contact belongs to; a new one where there is none yet.
std::int32_t cluster_of(const TriangleContact& contact, std::int32_t material, std::int32_t place,
                        std::size_t first, Column<MeshManifold>& manifolds) {
  const Vec3 normal = to_vec3(contact.normal);
  for (std::size_t i = first; i < manifolds.size(); ++i) {
    if (manifolds[i].material == material && dot(to_vec3(manifolds[i].contact.normal), normal) > kOneNormal) {
      return static_cast<std::int32_t>(i);
    }
  }
  MeshManifold fresh{contact, place, -1, material, 0};
  for (std::uint32_t& id : fresh.contact.id) id = 0;  // points come later
  manifolds.push_back(fresh);
  return static_cast<std::int32_t>(manifolds.size()) - 1;
}

// A point of a contact, seen along the manifold's normal.
struct Point {
  float u, v, separation;
  std::int32_t contact;
  int number;
};

// Chooses the points of one manifold among those of its contacts, in one pass over these for each point.
class Choice {
 public:
  Choice(const MeshScratch& scratch, std::int32_t manifold, Vec3 normal, float spread)
      : scratch_(scratch),
        manifold_(manifold),
        tangent_1_(tangent_of(normal)),
        tangent_2_(cross(normal, tangent_1_)),
        spread_(spread) {}

  // Returns how many were found: of `most`, those that spread farthest.
  int choose(int most, Point (&chosen)[kMaxManifoldPoints]) const {
    if (!best([](const Point& p) { return -p.separation; }, -kAbsentSeparation, kTie, 0.0f, chosen[0]))
      return 0;
    const Point a = chosen[0];
    const auto distance_2 = [&](const Point& p) { return square(p.u - a.u) + square(p.v - a.v); };
    if (most < 2 || !best(distance_2, square(spread_), 0.0f, kTieShare, chosen[1])) return 1;
    const Point b = chosen[1];
    const float least = spread_ * std::sqrt(distance_2(b));
    const auto aside = [&](const Point& p) { return std::abs(area(a, b, p)); };
    if (most < 3 || !best(aside, least, 0.0f, kTieShare, chosen[2])) return 2;
    const Point c = chosen[2];
    const float turn = area(a, b, c) < 0.0f ? 1.0f : -1.0f;
    const auto adds = [&](const Point& p) {
      return std::max({turn * area(a, b, p), turn * area(b, c, p), turn * area(c, a, p)});
    };
    return best(adds, least, 0.0f, kTieShare, chosen[3]) ? 4 : 3;
  }

 private:
  static float square(float x) { return x * x; }
  // Twice the area of the triangle, positive to the left of a -> b.
  static float area(const Point& a, const Point& b, const Point& p) {
    return (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u);
  }
  template <class Visit>
  void for_each_point(Visit&& visit) const {
    for (std::size_t i = 0; i < scratch_.contacts.size(); ++i) {
      if (scratch_.cluster[i] != manifold_) continue;
      const TriangleContact& contact = scratch_.contacts[i];
      for (int k = 0; k < kMaxManifoldPoints; ++k) {
        if (contact.id[k] == 0) continue;
        const Vec3 place = to_vec3(contact.point[k]);
        visit(Point{dot(place, tangent_1_), dot(place, tangent_2_), contact.separation[k],
                    static_cast<std::int32_t>(i), k});
      }
    }
  }
  // The first point whose score is above `least`, and the largest up to `slack` or a share. Of these a corner
  // of the shape, which stays while seams of the mesh pass below.
  template <class Score>
  bool best(Score&& score, float least, float slack, float share, Point& found) const {
    float top = least;
    for_each_point([&](const Point& point) { top = std::max(score(point), top); });
    if (!(top > least)) return false;
    const float enough = std::max(top - slack - share * std::abs(top), least);
    bool is_found = false, is_corner = false;
    for_each_point([&](const Point& point) {
      if (is_corner || !(score(point) >= enough)) return;
      const bool corner = scratch_.contacts[point.contact].id[point.number] < simd::kFirstMixedName;
      if (is_found && !corner) return;
      is_found = true;
      is_corner = corner;
      found = point;
    });
    return is_found;
  }

  const MeshScratch& scratch_;
  std::int32_t manifold_;
  Vec3 tangent_1_, tangent_2_;
  float spread_;
};

int most_points(simd::MeshFirstType type) {
  return type == simd::kMeshSphere ? 1 : type == simd::kMeshCapsule ? 2 : kMaxManifoldPoints;
}

}  // namespace

void merge_contacts(const MeshData& mesh, simd::MeshFirstType first_type, std::int32_t place, float spread,
                    const MeshScratch& scratch, Column<MeshManifold>& manifolds) {
  const std::size_t first = manifolds.size();
  sort_by_depth(scratch);
  scratch.cluster.resize_discarding(scratch.contacts.size());
  for (const std::int32_t i : scratch.order) {
    const TriangleContact& contact = scratch.contacts[i];
    scratch.cluster[i] = cluster_of(contact, material_of(mesh, contact.triangle), place, first, manifolds);
  }
  for (std::size_t i = first; i < manifolds.size(); ++i) {
    TriangleContact& to = manifolds[i].contact;
    Point chosen[kMaxManifoldPoints];
    const Choice choice(scratch, static_cast<std::int32_t>(i), to_vec3(to.normal), spread);
    const int count = choice.choose(most_points(first_type), chosen);
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      to.separation[k] = kAbsentSeparation;
      for (float& coordinate : to.point[k]) coordinate = 0.0f;
      if (k >= count) continue;
      const TriangleContact& from = scratch.contacts[chosen[k].contact];
      std::copy(std::begin(from.point[chosen[k].number]), std::end(from.point[chosen[k].number]),
                to.point[k]);
      to.separation[k] = from.separation[chosen[k].number];
      to.id[k] = from.id[chosen[k].number];
    }
  }
}

}  // namespace scree
