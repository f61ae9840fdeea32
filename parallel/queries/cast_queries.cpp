// Casts: the first shape, any shape, all shapes that a moving shape meets.
#include <parallel/queries/query_distance.h>
#include <parallel/queries/query_mesh.h>
#include <parallel/queries/query_scope.h>
#include <parallel/queries/ranged_queries.h>

#include <algorithm>

namespace scree {

namespace {

using queries::Contact;
using queries::QueryShape;
using queries::Ranged;
using queries::Scope;
using queries::Vector;

// A shape that is met.
struct Met {
  std::int32_t shape = -1;
  Contact contact;
};
bool comes_first(const Met& a, const Met& b) {
  return a.contact.fraction != b.contact.fraction ? a.contact.fraction < b.contact.fraction
                                                  : a.shape < b.shape;
}

// A cast as it is asked.
struct Moving {
  QueryShape shape;
  Vec3 translation;
  Vector way;

  explicit Moving(const ShapeCast& cast)
      : shape(cast.geometry, cast.pose),
        translation(cast.translation),
        way(queries::to_vector(cast.translation)) {}
  simd::CrossTask task() const { return queries::task_of(shape.solid, translation); }
};

// Whether the cast meets the shape in a way that counts, at a fraction of at most `most`; a mesh anywhere if
// `any`.
bool meets(const Scope& scope, const Moving& moving, double most, bool any, Met& met) {
  const queries::Solid other = queries::solid_of(scope.data, met.shape);
  const bool skips = scope.options.start_inside == StartInside::skip;
  if (other.mesh != nullptr) {
    const queries::MeshLook look{scope.options.back_sides, skips, any};
    return queries::meet_mesh(scope.kernels.query, moving.shape.solid, moving.way, other, most, look,
                              met.contact);
  }
  if (!queries::meet(moving.shape.solid, moving.way, other, most, met.contact)) return false;
  return !(met.contact.inside && skips);
}

CastHit describe(const WorldData& data, const Moving& moving, const Met& met) {
  CastHit hit;
  hit.shape = shape_handle(data, met.shape);
  hit.body = body_handle(data, data.shapes.body[met.shape]);
  hit.fraction = static_cast<float>(met.contact.fraction);
  hit.distance = static_cast<float>(met.contact.fraction * queries::length(moving.way));
  hit.starts_inside = met.contact.inside;
  hit.triangle = met.contact.triangle;
  hit.point = queries::to_vec3(met.contact.inside ? moving.shape.solid.position : met.contact.point);
  hit.normal = queries::to_vec3(met.contact.normal);
  return hit;
}

std::optional<Ranged<CastHit>> first_hit(const Scope& scope, const ShapeCast& cast) {
  const Moving moving(cast);
  Met first;
  double most = 1.0;
  queries::walk(scope, scope.kernels.query.cross, moving.task(), 1.0f, [&](std::int32_t shape, float limit) {
    Met met{shape, {}};
    if (!meets(scope, moving, most, false, met)) return limit;
    if (first.shape >= 0 && !comes_first(met, first)) return limit;
    first = met;
    most = met.contact.fraction;
    return std::min(limit, queries::limit_of(most));
  });
  if (first.shape < 0) return std::nullopt;
  return Ranged<CastHit>{describe(scope.data, moving, first), first.contact.fraction};
}

bool meets_any(const Scope& scope, const ShapeCast& cast) {
  const Moving moving(cast);
  bool any = false;
  queries::walk(scope, scope.kernels.query.cross, moving.task(), 1.0f, [&](std::int32_t shape, float limit) {
    Met met{shape, {}};
    any = meets(scope, moving, 1.0, true, met);
    return any ? -1.0f : limit;
  });
  return any;
}

template <class Hits>
void list_hits(const Scope& scope, const ShapeCast& cast, Hits& hits) {
  const Moving moving(cast);
  std::vector<Met> all;
  queries::walk(scope, scope.kernels.query.cross, moving.task(), 1.0f, [&](std::int32_t shape, float limit) {
    Met met{shape, {}};
    if (meets(scope, moving, 1.0, false, met)) all.push_back(met);
    return limit;
  });
  std::sort(all.begin(), all.end(), comes_first);
  for (const Met& met : all) queries::add_hit(hits, describe(scope.data, moving, met), met.contact.fraction);
}

void check_cast(Call call, const ShapeCast& cast) {
  queries::check_placed(call, cast.geometry, cast.pose);
  queries::check_translation(call, cast.translation);
}

void check_casts(Call call, std::span<const ShapeCast> casts) {
  for (std::size_t i = 0; i < casts.size(); ++i) check_cast(item_of(call, casts.size(), i), casts[i]);
}

}  // namespace

std::optional<CastHit> cast_shape(const World& world, const ShapeCast& cast, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_shape");
  check_cast(call, cast);
  return queries::hit_of(first_hit(queries::OwnScope(call, world, options).scope, cast));
}

bool is_cast_blocked(const World& world, const ShapeCast& cast, const QueryOptions& options) {
  constexpr Call call = queries::call_of("is_cast_blocked");
  check_cast(call, cast);
  return meets_any(queries::OwnScope(call, world, options).scope, cast);
}

std::vector<CastHit> cast_shape_all(const World& world, const ShapeCast& cast, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_shape_all");
  check_cast(call, cast);
  std::vector<CastHit> hits;
  list_hits(queries::OwnScope(call, world, options).scope, cast, hits);
  return hits;
}

void cast_shapes(const World& world, std::span<const ShapeCast> casts, std::span<std::optional<CastHit>> hits,
                 Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_shapes", "cast");
  queries::check_length(call, "hits", hits.size(), casts.size());
  check_casts(call, casts);
  queries::ask_all(call, world, casts.size(), workers, options, [&](const Scope& scope, std::size_t i) {
    hits[i] = queries::hit_of(first_hit(scope, casts[i]));
  });
}

void are_casts_blocked(const World& world, std::span<const ShapeCast> casts, std::span<std::uint8_t> blocked,
                       Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("are_casts_blocked", "cast");
  queries::check_length(call, "blocked", blocked.size(), casts.size());
  check_casts(call, casts);
  queries::ask_all(call, world, casts.size(), workers, options, [&](const Scope& scope, std::size_t i) {
    blocked[i] = meets_any(scope, casts[i]) ? 1 : 0;
  });
}

AnswerLists<CastHit> cast_shapes_all(const World& world, std::span<const ShapeCast> casts, Workers& workers,
                                     const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_shapes_all", "cast");
  check_casts(call, casts);
  return queries::list_all<CastHit>(
      call, world, casts.size(), workers, options,
      [&](const Scope& scope, std::size_t i, auto& hits) { list_hits(scope, casts[i], hits); });
}

AnswerLists<Ranged<CastHit>> queries::cast_shapes_ranged(Call call, const World& world,
                                                         std::span<const ShapeCast> casts, Wanted wanted,
                                                         Workers& workers, const QueryOptions& options) {
  check_casts(call, casts);
  return list_all<Ranged<CastHit>>(call, world, casts.size(), workers, options,
                                   [&](const Scope& scope, std::size_t i, auto& hits) {
                                     if (wanted == Wanted::all) return list_hits(scope, casts[i], hits);
                                     if (const auto first = first_hit(scope, casts[i]))
                                       hits.push_back(*first);
                                   });
}

}  // namespace scree
