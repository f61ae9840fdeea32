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

using Contacts = std::span<const TriangleContact>;

void sort_by_depth(Contacts contacts, Column<MeshDepth>& order) {
  order.resize_discarding(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    order[i] = {deepest_of(contacts[i]), static_cast<std::int32_t>(i)};
  }
  std::sort(order.begin(), order.end(), [](const MeshDepth& x, const MeshDepth& y) {
    return x.separation != y.separation ? x.separation < y.separation : x.contact < y.contact;
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
  manifolds.push_back({contact, place, -1, material, 0});
  return static_cast<std::int32_t>(manifolds.size()) - 1;
}

// The points of one manifold's contacts.
void list_points(Contacts contacts, std::int32_t manifold, Vec3 normal, const MeshScratch& scratch) {
  const Vec3 tangent_1 = tangent_of(normal), tangent_2 = cross(normal, tangent_1);
  scratch.points.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (scratch.cluster[i] != manifold) continue;
    const TriangleContact& contact = contacts[i];
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      if (contact.id[k] == 0) continue;
      const Vec3 place = to_vec3(contact.point[k]);
      scratch.points.push_back({dot(place, tangent_1), dot(place, tangent_2), contact.separation[k],
                                static_cast<std::int32_t>(i), k,
                                contact.id[k] < simd::kFirstMixedName ? 1 : 0});
    }
  }
}

// Chooses the points of a manifold, in one pass over all for each.
class Choice {
 public:
  Choice(std::span<const MeshPoint> points, float spread) : points_(points), spread_(spread) {}

  // Returns how many were found: of `most`, those that spread farthest.
  int choose(int most, MeshPoint (&chosen)[kMaxManifoldPoints]) const {
    if (!best([](const MeshPoint& p) { return -p.separation; }, -kAbsentSeparation, kTie, 0.0f, chosen[0]))
      return 0;
    if (most < 2 || points_.size() < 2) return 1;
    const MeshPoint a = chosen[0];
    const auto distance_2 = [&](const MeshPoint& p) { return square(p.u - a.u) + square(p.v - a.v); };
    if (!best(distance_2, square(spread_), 0.0f, kTieShare, chosen[1])) return 1;
    if (most < 3) return 2;
    const MeshPoint b = chosen[1];
    const float least = spread_ * std::sqrt(distance_2(b));
    const auto aside = [&](const MeshPoint& p) { return std::abs(area(a, b, p)); };
    if (!best(aside, least, 0.0f, kTieShare, chosen[2])) return 2;
    const MeshPoint c = chosen[2];
    const float turn = area(a, b, c) < 0.0f ? 1.0f : -1.0f;
    const auto adds = [&](const MeshPoint& p) {
      return std::max({turn * area(a, b, p), turn * area(b, c, p), turn * area(c, a, p)});
    };
    return best(adds, least, 0.0f, kTieShare, chosen[3]) ? 4 : 3;
  }

 private:
  static float square(float x) { return x * x; }
  // Twice the area of the triangle, positive to the left of a -> b.
  static float area(const MeshPoint& a, const MeshPoint& b, const MeshPoint& p) {
    return (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u);
  }
  // The first point whose score is above `least`, and the largest up to `slack` or a share. Of these a corner
  // of the shape, which stays while seams of the mesh pass below.
  template <class Score>
  bool best(Score&& score, float least, float slack, float share, MeshPoint& found) const {
    float top = least;
    for (const MeshPoint& point : points_) top = std::max(score(point), top);
    if (!(top > least)) return false;
    const float enough = std::max(top - slack - share * std::abs(top), least);
    bool is_found = false;
    for (const MeshPoint& point : points_) {
      if (!(score(point) >= enough) || (is_found && point.is_corner == 0)) continue;
      found = point;
      if (point.is_corner != 0) break;
      is_found = true;
    }
    return true;
  }

  std::span<const MeshPoint> points_;
  float spread_;
};

int most_points(simd::MeshFirstType type) {
  return type == simd::kMeshSphere ? 1 : type == simd::kMeshCapsule ? 2 : kMaxManifoldPoints;
}

}  // namespace

void merge_contacts(const MeshData& mesh, std::span<const TriangleContact> contacts,
                    simd::MeshFirstType first_type, std::int32_t place, float spread,
                    const MeshScratch& scratch, Column<MeshManifold>& manifolds) {
  const std::size_t first = manifolds.size();
  sort_by_depth(contacts, scratch.order);
  scratch.cluster.resize_discarding(contacts.size());
  for (const MeshDepth& next : scratch.order) {
    const TriangleContact& contact = contacts[static_cast<std::size_t>(next.contact)];
    scratch.cluster[next.contact] =
        cluster_of(contact, material_of(mesh, contact.triangle), place, first, manifolds);
  }
  if (manifolds.size() - first == contacts.size()) return;  // each is one contact
  for (std::size_t i = first; i < manifolds.size(); ++i) {
    const auto number = static_cast<std::int32_t>(i);
    if (std::count(scratch.cluster.begin(), scratch.cluster.end(), number) == 1) continue;
    TriangleContact& to = manifolds[i].contact;
    list_points(contacts, number, to_vec3(to.normal), scratch);
    // A rim has many corners. Of equal ones those of the lowest names count, whatever triangles they are on.
    if (first_type == simd::kMeshSmooth) {
      std::sort(scratch.points.begin(), scratch.points.end(), [&](const MeshPoint& x, const MeshPoint& y) {
        const auto id_of = [&](const MeshPoint& p) {
          return contacts[static_cast<std::size_t>(p.contact)].id[p.number];
        };
        const std::uint32_t a = id_of(x), b = id_of(y);
        return a != b ? a < b : x.contact != y.contact ? x.contact < y.contact : x.number < y.number;
      });
    }
    MeshPoint chosen[kMaxManifoldPoints];
    const Choice choice(std::as_const(scratch.points).span(), spread);
    const int count = choice.choose(most_points(first_type), chosen);
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      to.separation[k] = kAbsentSeparation;
      to.id[k] = 0;
      for (float& coordinate : to.point[k]) coordinate = 0.0f;
      if (k >= count) continue;
      const TriangleContact& from = contacts[static_cast<std::size_t>(chosen[k].contact)];
      const auto& point = from.point[chosen[k].number];
      std::copy(std::begin(point), std::end(point), to.point[k]);
      to.separation[k] = from.separation[chosen[k].number];
      to.id[k] = from.id[chosen[k].number];
    }
  }
}

}  // namespace scree
