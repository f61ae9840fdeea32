// Queries: what a ray, a moving shape, a place or a point meets among the shapes of a world.
//
// Queries change nothing, so any number of threads may ask at once between steps. They see the world as it
// is: after the last step and all calls since. What they answer depends on the world alone, not on queries
// made before, on threads or on the instruction set. Overlaps and distances are those of the shapes
// themselves, in double precision, without the margins that contacts have; a shape's surface belongs to it.
//
// A mesh is a surface, and has no inside: it holds no point. Rays and casts meet its triangles on their
// fronts, unless QueryOptions::back_sides: a ray that comes from the front, and a shape that moves against
// it. A cast that begins where it overlaps a triangle hits this at once, unless it moves out by the front.
// Overlaps and distances have no sides. Of triangles that answer alike the one with the smallest number
// counts.
//
// A query of many, which takes Workers, has the answers of the single ones, bit for bit.
//
// All throw Error for values outside the ranges stated here, for lists of different lengths, for the empty
// hull, for dead handles, and for a world that was moved from.
#pragma once

#include <scree/body.h>
#include <scree/export.h>
#include <scree/ids.h>
#include <scree/math_types.h>
#include <scree/shapes.h>
#include <scree/workers.h>
#include <scree/world.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace scree {

/// A set of types of bodies; combine with |.
enum class BodyTypes : std::uint8_t {
  none = 0,       ///< no bodies
  fixed = 1,      ///< BodyType::fixed
  kinematic = 2,  ///< BodyType::kinematic
  dynamic = 4,    ///< BodyType::dynamic, awake or asleep
  all = 7,        ///< every body
};

/// The types of both.
constexpr BodyTypes operator|(BodyTypes left, BodyTypes right) {
  return static_cast<BodyTypes>(static_cast<unsigned>(left) | static_cast<unsigned>(right));
}

/// What becomes of shapes that a ray or a cast begins in.
enum class StartInside : std::uint8_t {
  hit,   ///< they are hit at once, at fraction 0 and without a normal
  skip,  ///< they are passed over
};

/// Which shapes a query looks at: those that pass all of these.
struct QueryOptions {
  /// Of the query, as if it were a shape: each one's mask must have a bit of the other's category, and equal
  /// groups overrule that, see Filter. Without one every shape passes.
  std::optional<Filter> filter{};
  BodyTypes types = BodyTypes::all;  ///< of bodies, as they were given; quarantine does not change it
  BodyId ignored{};                  ///< whose shapes do not count, as those of who asks; the default: none
  StartInside start_inside = StartInside::hit;  ///< of rays and casts
  /// Whether rays and casts meet triangles of meshes from behind, too, and not from the front alone.
  bool back_sides = false;
  bool sensors = false;  ///< whether sensors count, too
  /// Called for shapes that have passed the rest; false: does not count. May be called for shapes that are no
  /// part of the answer, in any order, and by queries of many in several threads at once, so it must always
  /// say the same of a shape. What it throws, the query throws.
  std::function<bool(ShapeId, BodyId)> predicate{};
};

/// A line from `origin` to `origin + translation`. It may have no length: then it asks for shapes that hold
/// the point.
struct Ray {
  Vec3 origin{};       ///< m, each within +-1e7
  Vec3 translation{};  ///< m, each within +-2e7
};

/// A shape that a query brings; it need not be in the world. What Geometry states holds for its numbers.
struct PlacedShape {
  Geometry geometry{};  ///< its form
  Pose pose{};          ///< where it is: each within +-1e7 m, unit rotation within 1e-3
};

/// A shape that moves along `translation` and does not turn.
struct ShapeCast {
  Geometry geometry{};  ///< its form
  Pose pose{};          ///< where it begins: each within +-1e7 m, unit rotation within 1e-3
  Vec3 translation{};   ///< m, each within +-2e7; without length it asks for what the shape overlaps
};

/// Points of a box along the axes of the world.
struct AxisBox {
  Vec3 lower{};  ///< m, each within +-1e7
  Vec3 upper{};  ///< m, each within +-1e7 and at least that of `lower`
};

/// Where a ray or a cast meets a shape.
struct CastHit {
  ShapeId shape;           ///< that is hit
  BodyId body;             ///< the shape's
  float fraction = 0.0f;   ///< of the translation up to there, in [0, 1]
  float distance = 0.0f;   ///< m, up to there
  Vec3 point{};            ///< m, where they meet, on the shape's surface
  Vec3 normal{};           ///< of the shape's surface, outward, of unit length; zero if starts_inside
  std::int32_t face = -1;  ///< for rays: the hull's, as Hull::face counts them, or the box's: 0 to 5 for -x,
                           ///< +x, -y, +y, -z, +z; -1 on round surfaces, rounded hulls, cylinders and
                           ///< cones, for casts and if starts_inside
  std::int32_t triangle = -1;  ///< of a mesh, as it was handed in, counted from 0; -1 for other shapes
  bool starts_inside = false;  ///< the beginning lies in the shape already, or overlaps the triangle of a
                               ///< mesh; `point` is the beginning then

  friend bool operator==(const CastHit&, const CastHit&) = default;
};

/// A shape that holds a point, or touches or overlaps what is asked for.
struct OverlapHit {
  ShapeId shape;               ///< that does so
  BodyId body;                 ///< the shape's
  std::int32_t triangle = -1;  ///< of a mesh the first one that does so, as CastHit::triangle

  friend bool operator==(const OverlapHit&, const OverlapHit&) = default;
};

/// A shape near a point or another shape, and the nearest points of both.
struct NearHit {
  ShapeId shape;               ///< that is near
  BodyId body;                 ///< the shape's
  float distance = 0.0f;       ///< m; 0 where they touch or overlap
  Vec3 point{};                ///< m, of the shape's surface; where they overlap, the middle of what asks
  Vec3 from{};                 ///< m, the point that asks or that of the asking shape's surface, as `point`
  Vec3 normal{};               ///< from `point` to `from`, of unit length; zero where they touch or overlap
  std::int32_t triangle = -1;  ///< of a mesh the nearest one, as CastHit::triangle

  friend bool operator==(const NearHit&, const NearHit&) = default;
};

/// The answers of many queries that may each have any number.
template <class Answer>
struct AnswerLists {
  std::vector<Answer> answers;      ///< of the first query, then of the second, ...
  std::vector<std::size_t> begins;  ///< by query: where its answers begin; and where the last one's end

  /// How many queries there are.
  std::size_t size() const { return begins.empty() ? 0 : begins.size() - 1; }
  /// The answers of query `i`.
  std::span<const Answer> operator[](std::size_t i) const {
    return std::span(answers).subspan(begins[i], begins[i + 1] - begins[i]);
  }
};

/// The first shape that the ray meets, and where; nothing if it meets none. Of shapes met at the same place
/// the one with the smallest ShapeId::index counts.
SCREE_API std::optional<CastHit> cast_ray(const World& world, const Ray& ray,
                                          const QueryOptions& options = {});
/// Whether the ray meets any shape. Costs less than to find the first one.
SCREE_API bool is_blocked(const World& world, const Ray& ray, const QueryOptions& options = {});
/// All shapes that the ray meets, each where it meets it first, by fraction and then by ShapeId::index.
SCREE_API std::vector<CastHit> cast_ray_all(const World& world, const Ray& ray,
                                            const QueryOptions& options = {});

/// cast_ray for each ray; `hits` has as many entries.
SCREE_API void cast_rays(const World& world, std::span<const Ray> rays,
                         std::span<std::optional<CastHit>> hits, Workers& workers,
                         const QueryOptions& options = {});
/// is_blocked for each ray: 1 or 0; `blocked` has as many entries.
SCREE_API void are_blocked(const World& world, std::span<const Ray> rays, std::span<std::uint8_t> blocked,
                           Workers& workers, const QueryOptions& options = {});
/// cast_ray_all for each ray.
SCREE_API AnswerLists<CastHit> cast_rays_all(const World& world, std::span<const Ray> rays, Workers& workers,
                                             const QueryOptions& options = {});

/// The first shape that the moving shape meets, as cast_ray. Shapes count as met when less than 2e-9 m, and
/// 2e-11 of their sizes, is between them.
SCREE_API std::optional<CastHit> cast_shape(const World& world, const ShapeCast& cast,
                                            const QueryOptions& options = {});
/// Whether the moving shape meets any.
SCREE_API bool is_cast_blocked(const World& world, const ShapeCast& cast, const QueryOptions& options = {});
/// All shapes that the moving shape would meet if none stopped it, by fraction and then by ShapeId::index.
SCREE_API std::vector<CastHit> cast_shape_all(const World& world, const ShapeCast& cast,
                                              const QueryOptions& options = {});

/// cast_shape for each; `hits` has as many entries.
SCREE_API void cast_shapes(const World& world, std::span<const ShapeCast> casts,
                           std::span<std::optional<CastHit>> hits, Workers& workers,
                           const QueryOptions& options = {});
/// is_cast_blocked for each: 1 or 0; `blocked` has as many entries.
SCREE_API void are_casts_blocked(const World& world, std::span<const ShapeCast> casts,
                                 std::span<std::uint8_t> blocked, Workers& workers,
                                 const QueryOptions& options = {});
/// cast_shape_all for each.
SCREE_API AnswerLists<CastHit> cast_shapes_all(const World& world, std::span<const ShapeCast> casts,
                                               Workers& workers, const QueryOptions& options = {});

/// The shapes that the placed one touches or overlaps, by ShapeId::index.
SCREE_API std::vector<OverlapHit> overlap_shape(const World& world, const PlacedShape& shape,
                                                const QueryOptions& options = {});
/// The shapes that the box touches or overlaps (the shapes themselves, not boxes around them), by
/// ShapeId::index.
SCREE_API std::vector<OverlapHit> overlap_box(const World& world, const AxisBox& box,
                                              const QueryOptions& options = {});
/// The shapes that hold the point (m, each within +-1e7), by ShapeId::index.
SCREE_API std::vector<OverlapHit> overlap_point(const World& world, Vec3 point,
                                                const QueryOptions& options = {});

/// overlap_shape for each.
SCREE_API AnswerLists<OverlapHit> overlap_shapes(const World& world, std::span<const PlacedShape> shapes,
                                                 Workers& workers, const QueryOptions& options = {});
/// overlap_box for each.
SCREE_API AnswerLists<OverlapHit> overlap_boxes(const World& world, std::span<const AxisBox> boxes,
                                                Workers& workers, const QueryOptions& options = {});
/// overlap_point for each.
SCREE_API AnswerLists<OverlapHit> overlap_points(const World& world, std::span<const Vec3> points,
                                                 Workers& workers, const QueryOptions& options = {});

/// The shape nearest to the point (m, each within +-1e7), unless it is farther off than `most` (m, in
/// [0, 1e8]). Of shapes as near the one with the smallest ShapeId::index counts.
SCREE_API std::optional<NearHit> closest_to_point(const World& world, Vec3 point, float most,
                                                  const QueryOptions& options = {});
/// The shape nearest to the placed one, as closest_to_point.
SCREE_API std::optional<NearHit> closest_to_shape(const World& world, const PlacedShape& shape, float most,
                                                  const QueryOptions& options = {});
/// All shapes that are no farther off the point than `most`, by distance and then by ShapeId::index.
SCREE_API std::vector<NearHit> near_point(const World& world, Vec3 point, float most,
                                          const QueryOptions& options = {});
/// All shapes that are no farther off the placed one than `most`, by distance and then by ShapeId::index.
SCREE_API std::vector<NearHit> near_shape(const World& world, const PlacedShape& shape, float most,
                                          const QueryOptions& options = {});

/// closest_to_point for each; `hits` has as many entries.
SCREE_API void closest_to_points(const World& world, std::span<const Vec3> points, float most,
                                 std::span<std::optional<NearHit>> hits, Workers& workers,
                                 const QueryOptions& options = {});
/// closest_to_shape for each; `hits` has as many entries.
SCREE_API void closest_to_shapes(const World& world, std::span<const PlacedShape> shapes, float most,
                                 std::span<std::optional<NearHit>> hits, Workers& workers,
                                 const QueryOptions& options = {});
/// near_point for each.
SCREE_API AnswerLists<NearHit> near_points(const World& world, std::span<const Vec3> points, float most,
                                           Workers& workers, const QueryOptions& options = {});
/// near_shape for each.
SCREE_API AnswerLists<NearHit> near_shapes(const World& world, std::span<const PlacedShape> shapes,
                                           float most, Workers& workers, const QueryOptions& options = {});

}  // namespace scree
