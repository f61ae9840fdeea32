// Queries of many (scree/queries.h) to the whole world of all ranks. Queries to DistributedWorld::world()
// find only what this rank has.
//
// All ranks call each of these together, with the same queries and options, and all of them get the answers
// that a single process gives, bit for bit, with handles of their own parts. Each rank looks at the bodies
// that it owns, and asks its predicate about these alone. Where a query or a predicate throws on any rank,
// all throw an Error. What all ranks do together must not be done in the calls of DistributedWorld::give:
// that throws an Error there.
#pragma once

#include <scree/distributed_world.h>
#include <scree/queries.h>

#include <cstdint>
#include <optional>
#include <span>

namespace scree {

/// cast_ray for each ray; `hits` has as many entries.
SCREE_API void cast_rays(DistributedWorld& world, std::span<const Ray> rays,
                         std::span<std::optional<CastHit>> hits, Workers& workers,
                         const QueryOptions& options = {});
/// is_blocked for each ray: 1 or 0; `blocked` has as many entries.
SCREE_API void are_blocked(DistributedWorld& world, std::span<const Ray> rays,
                           std::span<std::uint8_t> blocked, Workers& workers,
                           const QueryOptions& options = {});
/// cast_ray_all for each ray.
SCREE_API AnswerLists<CastHit> cast_rays_all(DistributedWorld& world, std::span<const Ray> rays,
                                             Workers& workers, const QueryOptions& options = {});

/// cast_shape for each; `hits` has as many entries.
SCREE_API void cast_shapes(DistributedWorld& world, std::span<const ShapeCast> casts,
                           std::span<std::optional<CastHit>> hits, Workers& workers,
                           const QueryOptions& options = {});
/// is_cast_blocked for each: 1 or 0; `blocked` has as many entries.
SCREE_API void are_casts_blocked(DistributedWorld& world, std::span<const ShapeCast> casts,
                                 std::span<std::uint8_t> blocked, Workers& workers,
                                 const QueryOptions& options = {});
/// cast_shape_all for each.
SCREE_API AnswerLists<CastHit> cast_shapes_all(DistributedWorld& world, std::span<const ShapeCast> casts,
                                               Workers& workers, const QueryOptions& options = {});

/// overlap_shape for each.
SCREE_API AnswerLists<OverlapHit> overlap_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes,
                                                 Workers& workers, const QueryOptions& options = {});
/// overlap_box for each.
SCREE_API AnswerLists<OverlapHit> overlap_boxes(DistributedWorld& world, std::span<const AxisBox> boxes,
                                                Workers& workers, const QueryOptions& options = {});
/// overlap_point for each.
SCREE_API AnswerLists<OverlapHit> overlap_points(DistributedWorld& world, std::span<const Vec3> points,
                                                 Workers& workers, const QueryOptions& options = {});

/// closest_to_point for each; `hits` has as many entries.
SCREE_API void closest_to_points(DistributedWorld& world, std::span<const Vec3> points, float most,
                                 std::span<std::optional<NearHit>> hits, Workers& workers,
                                 const QueryOptions& options = {});
/// closest_to_shape for each; `hits` has as many entries.
SCREE_API void closest_to_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes, float most,
                                 std::span<std::optional<NearHit>> hits, Workers& workers,
                                 const QueryOptions& options = {});
/// near_point for each.
SCREE_API AnswerLists<NearHit> near_points(DistributedWorld& world, std::span<const Vec3> points, float most,
                                           Workers& workers, const QueryOptions& options = {});
/// near_shape for each.
SCREE_API AnswerLists<NearHit> near_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes,
                                           float most, Workers& workers, const QueryOptions& options = {});

}  // namespace scree
