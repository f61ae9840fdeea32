// Distances: the nearest shape, or all shapes within a distance, from a point or a shape.
#include <parallel/queries/query_distance.h>
#include <parallel/queries/query_mesh.h>
#include <parallel/queries/query_scope.h>
#include <parallel/queries/ranged_queries.h>

#include <algorithm>

namespace scree {

namespace {

using queries::Gap;
using queries::QueryShape;
using queries::Ranged;
using queries::Scope;
using queries::Solid;

constexpr float kMaxDistance = 1e8f;  // m; its square has room in a float

// A shape that is near.
struct Near {
  std::int32_t shape = -1;
  Gap gap;
};
bool is_nearer(const Near& a, const Near& b) {
  return a.gap.distance != b.gap.distance ? a.gap.distance < b.gap.distance : a.shape < b.shape;
}

// Of meshes that are farther off than `most`, no more than that.
Near near_of(const Scope& scope, const Solid& solid, std::int32_t shape, double most) {
  const Solid other = queries::solid_of(scope.data, shape);
  Near near{shape, other.mesh != nullptr ? queries::gap_to_mesh(scope.kernels.query, solid, other, most)
                                         : queries::gap_between(solid, other)};
  near.gap.distance = std::max(near.gap.distance, 0.0);
  return near;
}

float square_of(double distance) { return queries::limit_of(distance * distance); }

NearHit describe(const Scope& scope, const Solid& solid, const Near& near) {
  const WorldData& data = scope.data;
  NearHit hit;
  hit.shape = shape_handle(data, near.shape);
  hit.body = body_handle(data, data.shapes.body[near.shape]);
  hit.distance = static_cast<float>(near.gap.distance);
  hit.triangle = near.gap.triangle;
  hit.point = hit.from = queries::to_vec3(solid.position);
  if (!(near.gap.distance > 0.0)) return hit;
  const queries::Vector base = queries::solid_of(data, near.shape).position;
  hit.point = queries::to_vec3(base + near.gap.on_b);
  hit.from = queries::to_vec3(base + near.gap.on_a);
  hit.normal = queries::to_vec3(-near.gap.normal);
  return hit;
}

std::optional<Ranged<NearHit>> closest(const Scope& scope, const Solid& solid, double most) {
  Near first;
  queries::walk(scope, scope.kernels.query.approach, queries::task_of(solid), square_of(most),
                [&](std::int32_t shape, float limit) {
                  const Near near = near_of(scope, solid, shape, most);
                  if (near.gap.distance > most) return limit;
                  if (first.shape >= 0 && !is_nearer(near, first)) return limit;
                  first = near;
                  most = near.gap.distance;
                  return std::min(limit, square_of(most));
                });
  if (first.shape < 0) return std::nullopt;
  return Ranged<NearHit>{describe(scope, solid, first), first.gap.distance};
}

template <class Hits>
void list_near(const Scope& scope, const Solid& solid, double most, Hits& hits) {
  std::vector<Near> all;
  queries::walk(scope, scope.kernels.query.approach, queries::task_of(solid), square_of(most),
                [&](std::int32_t shape, float limit) {
                  const Near near = near_of(scope, solid, shape, most);
                  if (!(near.gap.distance > most)) all.push_back(near);
                  return limit;
                });
  std::sort(all.begin(), all.end(), is_nearer);
  for (const Near& near : all) queries::add_hit(hits, describe(scope, solid, near), near.gap.distance);
}

// What asks, as a solid.
struct Asking {
  Solid solid;
  explicit Asking(Vec3 point) { solid.position = queries::to_vector(point); }
};
struct AskingShape {
  QueryShape shape;
  const Solid& solid = shape.solid;
  explicit AskingShape(const PlacedShape& placed) : shape(placed.geometry, placed.pose) {}
};
Asking asking_of(Vec3 point) { return Asking(point); }
AskingShape asking_of(const PlacedShape& placed) { return AskingShape(placed); }

void check(Call call, Vec3 point) { queries::check_point(call, "point", point); }
void check(Call call, const PlacedShape& shape) { queries::check_placed(call, shape.geometry, shape.pose); }

template <class Query>
void check_all(Call call, std::span<const Query> all, float most) {
  check_range(call, "most", most, 0.0f, kMaxDistance);
  for (std::size_t i = 0; i < all.size(); ++i) check(item_of(call, all.size(), i), all[i]);
}

template <class Query>
std::optional<NearHit> ask_closest(Call call, const World& world, const Query& query, float most,
                                   const QueryOptions& options) {
  check_all(call, std::span(&query, 1), most);
  return queries::hit_of(
      closest(queries::OwnScope(call, world, options).scope, asking_of(query).solid, most));
}

template <class Query>
std::vector<NearHit> ask_near(Call call, const World& world, const Query& query, float most,
                              const QueryOptions& options) {
  check_all(call, std::span(&query, 1), most);
  std::vector<NearHit> hits;
  list_near(queries::OwnScope(call, world, options).scope, asking_of(query).solid, most, hits);
  return hits;
}

template <class Query>
void ask_each_closest(Call call, const World& world, std::span<const Query> all, float most,
                      std::span<std::optional<NearHit>> hits, Workers& workers, const QueryOptions& options) {
  queries::check_length(call, "hits", hits.size(), all.size());
  check_all(call, all, most);
  queries::ask_all(call, world, all.size(), workers, options, [&](const Scope& scope, std::size_t i) {
    hits[i] = queries::hit_of(closest(scope, asking_of(all[i]).solid, most));
  });
}

template <class Query>
AnswerLists<NearHit> ask_each_near(Call call, const World& world, std::span<const Query> all, float most,
                                   Workers& workers, const QueryOptions& options) {
  check_all(call, all, most);
  return queries::list_all<NearHit>(call, world, all.size(), workers, options,
                                    [&](const Scope& scope, std::size_t i, auto& hits) {
                                      list_near(scope, asking_of(all[i]).solid, most, hits);
                                    });
}

template <class Query>
AnswerLists<Ranged<NearHit>> ask_each_ranged(Call call, const World& world, std::span<const Query> all,
                                             float most, queries::Wanted wanted, Workers& workers,
                                             const QueryOptions& options) {
  check_all(call, all, most);
  return queries::list_all<Ranged<NearHit>>(call, world, all.size(), workers, options,
                                            [&](const Scope& scope, std::size_t i, auto& hits) {
                                              const auto asking = asking_of(all[i]);
                                              if (wanted == queries::Wanted::all)
                                                return list_near(scope, asking.solid, most, hits);
                                              if (const auto first = closest(scope, asking.solid, most))
                                                hits.push_back(*first);
                                            });
}

}  // namespace

std::optional<NearHit> closest_to_point(const World& world, Vec3 point, float most,
                                        const QueryOptions& options) {
  return ask_closest(queries::call_of("closest_to_point"), world, point, most, options);
}

std::optional<NearHit> closest_to_shape(const World& world, const PlacedShape& shape, float most,
                                        const QueryOptions& options) {
  return ask_closest(queries::call_of("closest_to_shape"), world, shape, most, options);
}

std::vector<NearHit> near_point(const World& world, Vec3 point, float most, const QueryOptions& options) {
  return ask_near(queries::call_of("near_point"), world, point, most, options);
}

std::vector<NearHit> near_shape(const World& world, const PlacedShape& shape, float most,
                                const QueryOptions& options) {
  return ask_near(queries::call_of("near_shape"), world, shape, most, options);
}

void closest_to_points(const World& world, std::span<const Vec3> points, float most,
                       std::span<std::optional<NearHit>> hits, Workers& workers,
                       const QueryOptions& options) {
  ask_each_closest(queries::call_of("closest_to_points", "point"), world, points, most, hits, workers,
                   options);
}

void closest_to_shapes(const World& world, std::span<const PlacedShape> shapes, float most,
                       std::span<std::optional<NearHit>> hits, Workers& workers,
                       const QueryOptions& options) {
  ask_each_closest(queries::call_of("closest_to_shapes", "shape"), world, shapes, most, hits, workers,
                   options);
}

AnswerLists<NearHit> near_points(const World& world, std::span<const Vec3> points, float most,
                                 Workers& workers, const QueryOptions& options) {
  return ask_each_near(queries::call_of("near_points", "point"), world, points, most, workers, options);
}

AnswerLists<NearHit> near_shapes(const World& world, std::span<const PlacedShape> shapes, float most,
                                 Workers& workers, const QueryOptions& options) {
  return ask_each_near(queries::call_of("near_shapes", "shape"), world, shapes, most, workers, options);
}

AnswerLists<Ranged<NearHit>> queries::near_points_ranged(Call call, const World& world,
                                                         std::span<const Vec3> points, float most,
                                                         Wanted wanted, Workers& workers,
                                                         const QueryOptions& options) {
  return ask_each_ranged(call, world, points, most, wanted, workers, options);
}

AnswerLists<Ranged<NearHit>> queries::near_shapes_ranged(Call call, const World& world,
                                                         std::span<const PlacedShape> shapes, float most,
                                                         Wanted wanted, Workers& workers,
                                                         const QueryOptions& options) {
  return ask_each_ranged(call, world, shapes, most, wanted, workers, options);
}

}  // namespace scree
