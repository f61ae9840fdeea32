// Rays: the first shape, any shape, all shapes that a ray meets.
#include <parallel/queries/query_mesh.h>
#include <parallel/queries/query_ray.h>
#include <parallel/queries/query_scope.h>
#include <parallel/queries/ranged_queries.h>
#include <parallel/queries/ray_order.h>

#include <algorithm>

namespace scree {

namespace {

using queries::Entry;
using queries::Line;
using queries::Ranged;
using queries::Scope;
using queries::Vector;

void check_ray(Call call, const Ray& ray) {
  queries::check_point(call, "origin", ray.origin);
  queries::check_translation(call, ray.translation);
}

Line line_of(const Ray& ray) { return {queries::to_vector(ray.origin), queries::to_vector(ray.translation)}; }

simd::CrossTask task_of(const Ray& ray) {
  queries::Solid point;
  point.position = queries::to_vector(ray.origin);
  return queries::task_of(point, ray.translation);
}

// A shape that is met.
struct RayMeeting {
  std::int32_t shape = -1;
  Entry entry;
};
bool is_met_first(const RayMeeting& a, const RayMeeting& b) {
  return a.entry.fraction != b.entry.fraction ? a.entry.fraction < b.entry.fraction : a.shape < b.shape;
}

// Whether the ray meets the shape in a way that counts, and where first; of a mesh at a fraction of at most
// `most`, and anywhere if `any`.
bool meets(const Scope& scope, const Line& line, std::int32_t shape, double most, bool any, Entry& entry) {
  const queries::Solid solid = queries::solid_of(scope.data, shape);
  if (solid.mesh != nullptr) {
    const queries::MeshLook look{.back_sides = scope.options.back_sides, .any = any};
    return queries::meet_mesh(scope.kernels.query, solid, line, most, look, entry);
  }
  if (!queries::meet(scope.kernels.query, solid, line, entry)) return false;
  return !entry.inside || scope.options.start_inside == StartInside::hit;
}

CastHit describe(const WorldData& data, const Line& line, const RayMeeting& met) {
  CastHit hit;
  hit.shape = shape_handle(data, met.shape);
  hit.body = body_handle(data, data.shapes.body[met.shape]);
  hit.fraction = static_cast<float>(met.entry.fraction);
  hit.distance = static_cast<float>(met.entry.fraction * queries::length(line.translation));
  hit.point = queries::to_vec3(line.origin + met.entry.fraction * line.translation);
  hit.normal = queries::to_vec3(met.entry.normal);
  hit.face = met.entry.face;
  hit.triangle = met.entry.triangle;
  hit.starts_inside = met.entry.inside;
  return hit;
}

std::optional<Ranged<CastHit>> first_hit(const Scope& scope, const Ray& ray) {
  const Line line = line_of(ray);
  RayMeeting first;
  double most = 1.0;
  queries::walk(scope, scope.kernels.query.cross, task_of(ray), 1.0f, [&](std::int32_t shape, float limit) {
    RayMeeting met{shape, {}};
    if (!meets(scope, line, shape, most, false, met.entry)) return limit;
    if (first.shape >= 0 && !is_met_first(met, first)) return limit;
    first = met;
    most = met.entry.fraction;
    return std::min(limit, queries::limit_of(most));
  });
  if (first.shape < 0) return std::nullopt;
  return Ranged<CastHit>{describe(scope.data, line, first), first.entry.fraction};
}

bool meets_any(const Scope& scope, const Ray& ray) {
  const Line line = line_of(ray);
  bool any = false;
  queries::walk(scope, scope.kernels.query.cross, task_of(ray), 1.0f, [&](std::int32_t shape, float limit) {
    Entry entry;
    any = meets(scope, line, shape, 1.0, true, entry);
    return any ? -1.0f : limit;
  });
  return any;
}

template <class Hits>
void list_hits(const Scope& scope, const Ray& ray, Hits& hits) {
  const Line line = line_of(ray);
  std::vector<RayMeeting> all;
  queries::walk(scope, scope.kernels.query.cross, task_of(ray), 1.0f, [&](std::int32_t shape, float limit) {
    RayMeeting met{shape, {}};
    if (meets(scope, line, shape, 1.0, false, met.entry)) all.push_back(met);
    return limit;
  });
  std::sort(all.begin(), all.end(), is_met_first);
  for (const RayMeeting& met : all)
    queries::add_hit(hits, describe(scope.data, line, met), met.entry.fraction);
}

auto ordered(std::span<const Ray> rays) {
  return [rays](const Scope& scope, Crew& crew) { return queries::order_rays(scope, rays, crew); };
}

void check_rays(Call call, std::span<const Ray> rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) check_ray(item_of(call, rays.size(), i), rays[i]);
}

}  // namespace

std::optional<CastHit> cast_ray(const World& world, const Ray& ray, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_ray");
  check_ray(call, ray);
  return queries::hit_of(first_hit(queries::OwnScope(call, world, options).scope, ray));
}

bool is_blocked(const World& world, const Ray& ray, const QueryOptions& options) {
  constexpr Call call = queries::call_of("is_blocked");
  check_ray(call, ray);
  return meets_any(queries::OwnScope(call, world, options).scope, ray);
}

std::vector<CastHit> cast_ray_all(const World& world, const Ray& ray, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_ray_all");
  check_ray(call, ray);
  std::vector<CastHit> hits;
  list_hits(queries::OwnScope(call, world, options).scope, ray, hits);
  return hits;
}

void cast_rays(const World& world, std::span<const Ray> rays, std::span<std::optional<CastHit>> hits,
               Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_rays", "ray");
  queries::check_length(call, "hits", hits.size(), rays.size());
  check_rays(call, rays);
  queries::ask_all(
      call, world, rays.size(), workers, options,
      [&](const Scope& scope, std::size_t i) { hits[i] = queries::hit_of(first_hit(scope, rays[i])); },
      ordered(rays));
}

void are_blocked(const World& world, std::span<const Ray> rays, std::span<std::uint8_t> blocked,
                 Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("are_blocked", "ray");
  queries::check_length(call, "blocked", blocked.size(), rays.size());
  check_rays(call, rays);
  queries::ask_all(
      call, world, rays.size(), workers, options,
      [&](const Scope& scope, std::size_t i) { blocked[i] = meets_any(scope, rays[i]) ? 1 : 0; },
      ordered(rays));
}

AnswerLists<CastHit> cast_rays_all(const World& world, std::span<const Ray> rays, Workers& workers,
                                   const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_rays_all", "ray");
  check_rays(call, rays);
  return queries::list_all<CastHit>(
      call, world, rays.size(), workers, options,
      [&](const Scope& scope, std::size_t i, auto& hits) { list_hits(scope, rays[i], hits); });
}

AnswerLists<Ranged<CastHit>> queries::cast_rays_ranged(Call call, const World& world,
                                                       std::span<const Ray> rays, Wanted wanted,
                                                       Workers& workers, const QueryOptions& options) {
  check_rays(call, rays);
  if (wanted == Wanted::all) {
    return list_all<Ranged<CastHit>>(
        call, world, rays.size(), workers, options,
        [&](const Scope& scope, std::size_t i, auto& hits) { list_hits(scope, rays[i], hits); });
  }
  std::vector<std::optional<Ranged<CastHit>>> first(rays.size());
  ask_all(
      call, world, rays.size(), workers, options,
      [&](const Scope& scope, std::size_t i) { first[i] = first_hit(scope, rays[i]); }, ordered(rays));
  return lists_of(first);
}

}  // namespace scree
