// Queries of many whose answers say, too, in full precision, how far they are. So answers of several parts of
// a world can be put in order (../distributed/queries_across.cpp). See scree/queries.h for what is asked.
#pragma once

#include <core/world/check.h>
#include <scree/queries.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace scree::queries {

// A hit, and what hits of a query are ordered by, before ShapeId::index.
template <class Hit>
struct Ranged {
  Hit hit;
  double at;  // the fraction of a cast, or m
};

// Of each query.
enum class Wanted : std::uint8_t { first, all };

template <class Hit>
std::optional<Hit> hit_of(const std::optional<Ranged<Hit>>& first) {
  return first ? std::optional(first->hit) : std::nullopt;
}

template <class Hit>
AnswerLists<Hit> lists_of(const std::vector<std::optional<Hit>>& first) {
  AnswerLists<Hit> lists;
  lists.begins.push_back(0);
  for (const std::optional<Hit>& hit : first) {
    if (hit) lists.answers.push_back(*hit);
    lists.begins.push_back(lists.answers.size());
  }
  return lists;
}

// To a list of either kind.
template <class Hit>
void add_hit(std::vector<Ranged<Hit>>& hits, const Hit& hit, double at) {
  hits.push_back({hit, at});
}
template <class Hit>
void add_hit(std::vector<Hit>& hits, const Hit& hit, double) {
  hits.push_back(hit);
}

// `call`: names itself in errors, and a query of it.
AnswerLists<Ranged<CastHit>> cast_rays_ranged(Call call, const World& world, std::span<const Ray> rays,
                                              Wanted wanted, Workers& workers, const QueryOptions& options);
AnswerLists<Ranged<CastHit>> cast_shapes_ranged(Call call, const World& world,
                                                std::span<const ShapeCast> casts, Wanted wanted,
                                                Workers& workers, const QueryOptions& options);
AnswerLists<Ranged<NearHit>> near_points_ranged(Call call, const World& world, std::span<const Vec3> points,
                                                float most, Wanted wanted, Workers& workers,
                                                const QueryOptions& options);
AnswerLists<Ranged<NearHit>> near_shapes_ranged(Call call, const World& world,
                                                std::span<const PlacedShape> shapes, float most,
                                                Wanted wanted, Workers& workers, const QueryOptions& options);

}  // namespace scree::queries
