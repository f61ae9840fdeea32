// See scree/distributed_queries.h. Each rank asks its own bodies, and rank 0 those that are everybody's. All
// tell all others what they have found, and put it into the order that it has in a single process.
#include <core/world/check.h>
#include <parallel/distributed/agree.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/queries/query_scope.h>
#include <parallel/queries/ranged_queries.h>
#include <scree/distributed_queries.h>

#include <algorithm>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace scree {

namespace {

using queries::Ranged;
using queries::Wanted;

template <class Hit>
struct FoundHit {
  Ranged<Hit> found;
  std::int64_t query;
};

// What the ranks do together. Of a query's options this rank's have a predicate that passes its bodies alone.
class AskAcross {
 public:
  AskAcross(DistributedWorld& world, Workers& workers, const QueryOptions& options)
      : world_(world.world()),
        data_(internals(world_, "a query of all ranks")),
        border_(*border_of(data_)),
        workers_(workers),
        options_(options) {
    check_not_giving(border_);
    adopt_calls(data_, border_);
    options_.predicate = [this, given = options.predicate](ShapeId shape, BodyId body) {
      const std::int32_t owner = border_.owner_of(static_cast<std::int32_t>(body.index));
      const bool is_asked = owner == border_.here || (owner == kEveryRank && border_.here == 0);
      return is_asked && (!given || given(shape, body));
    };
  }
  AskAcross(const AskAcross&) = delete;
  AskAcross& operator=(const AskAcross&) = delete;

  // ask(world, workers, options): this rank's answers.
  template <class Ask>
  auto ask(Ask&& ask) {
    std::invoke_result_t<Ask, const World&, Workers&, const QueryOptions&> own;
    const std::optional<Error> problem = attempt([&] { own = ask(world_, workers_, options_); });
    if (const std::optional<Error> of_any = agree(border_.transport, problem)) throw *of_any;
    return own;
  }

  // Those of all ranks, by query, then in their order.
  template <class Hit>
  std::vector<FoundHit<Hit>> gather(const AnswerLists<Ranged<Hit>>& own) {
    std::vector<FoundHit<Hit>> found;
    for (std::size_t query = 0; query < own.size(); ++query) {
      for (const Ranged<Hit>& hit : own[query]) found.push_back({hit, static_cast<std::int64_t>(query)});
    }
    found = gather_lists(border_.transport, found, [&](const FoundHit<Hit>& one) {
      return one.query >= 0 && std::cmp_less(one.query, own.size()) &&
             one.found.hit.shape.index < data_.shapes.flags.size();
    });
    const auto order = [](const FoundHit<Hit>& one) {
      return std::tuple(one.query, one.found.at, one.found.hit.shape.index);
    };
    std::sort(found.begin(), found.end(), [&](const FoundHit<Hit>& one, const FoundHit<Hit>& other) {
      return order(one) < order(other);
    });
    for (FoundHit<Hit>& one : found) {  // whose handles are those of another rank's part
      Hit& hit = one.found.hit;
      const auto shape = static_cast<std::int32_t>(hit.shape.index);
      hit.shape = shape_handle(data_, shape);
      hit.body = body_handle(data_, data_.shapes.body[shape]);
    }
    return found;
  }

  void add_up(std::span<std::int64_t> counts) { border_.transport.add_up(counts); }

 private:
  World& world_;
  WorldData& data_;
  Border& border_;
  Workers& workers_;
  QueryOptions options_;
};

template <class Hit, class Ask>
AnswerLists<Hit> list_across(DistributedWorld& world, Workers& workers, const QueryOptions& options,
                             Ask&& ask) {
  AskAcross across(world, workers, options);
  const auto own = across.ask(ask);
  AnswerLists<Hit> all;
  all.begins.assign(own.begins.size(), 0);
  for (const FoundHit<Hit>& one : across.gather(own)) {
    all.answers.push_back(one.found.hit);
    ++all.begins[static_cast<std::size_t>(one.query) + 1];
  }
  for (std::size_t i = 1; i < all.begins.size(); ++i) all.begins[i] += all.begins[i - 1];
  return all;
}

// The first one of each query.
template <class Hit, class Ask>
void find_across(DistributedWorld& world, Workers& workers, const QueryOptions& options,
                 std::span<std::optional<Hit>> hits, Ask&& ask) {
  const AnswerLists<Hit> all = list_across<Hit>(world, workers, options, ask);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    hits[i].reset();
    if (!all[i].empty()) hits[i] = all[i].front();
  }
}

// As if each were at the same distance.
AnswerLists<Ranged<OverlapHit>> ranged(const AnswerLists<OverlapHit>& lists) {
  AnswerLists<Ranged<OverlapHit>> all;
  all.begins = lists.begins;
  for (const OverlapHit& hit : lists.answers) all.answers.push_back({hit, 0.0});
  return all;
}

// ask(world, blocked, workers, options): 1 or 0 for each query of which `blocked` has an entry.
template <class Ask>
void block_across(DistributedWorld& world, Workers& workers, const QueryOptions& options,
                  std::span<std::uint8_t> blocked, Ask&& ask) {
  AskAcross across(world, workers, options);
  std::vector<std::int64_t> counts(blocked.size());
  across.ask([&](const World& part, Workers& own_workers, const QueryOptions& own_options) {
    std::vector<std::uint8_t> own(blocked.size());
    ask(part, std::span(own), own_workers, own_options);
    std::copy(own.begin(), own.end(), counts.begin());
    return 0;
  });
  across.add_up(counts);
  for (std::size_t i = 0; i < blocked.size(); ++i) blocked[i] = counts[i] > 0 ? 1 : 0;
}

}  // namespace

void cast_rays(DistributedWorld& world, std::span<const Ray> rays, std::span<std::optional<CastHit>> hits,
               Workers& workers, const QueryOptions& options) {
  queries::check_length(queries::call_of("cast_rays", "ray"), "hits", hits.size(), rays.size());
  find_across<CastHit>(world, workers, options, hits,
                       [&](const World& part, Workers& crew, const QueryOptions& own) {
                         return queries::cast_rays_ranged(part, rays, Wanted::first, crew, own);
                       });
}

void are_blocked(DistributedWorld& world, std::span<const Ray> rays, std::span<std::uint8_t> blocked,
                 Workers& workers, const QueryOptions& options) {
  queries::check_length(queries::call_of("are_blocked", "ray"), "blocked", blocked.size(), rays.size());
  block_across(world, workers, options, blocked,
               [&](const World& part, std::span<std::uint8_t> of_part, Workers& crew,
                   const QueryOptions& own) { are_blocked(part, rays, of_part, crew, own); });
}

AnswerLists<CastHit> cast_rays_all(DistributedWorld& world, std::span<const Ray> rays, Workers& workers,
                                   const QueryOptions& options) {
  return list_across<CastHit>(world, workers, options,
                              [&](const World& part, Workers& crew, const QueryOptions& own) {
                                return queries::cast_rays_ranged(part, rays, Wanted::all, crew, own);
                              });
}

void cast_shapes(DistributedWorld& world, std::span<const ShapeCast> casts,
                 std::span<std::optional<CastHit>> hits, Workers& workers, const QueryOptions& options) {
  queries::check_length(queries::call_of("cast_shapes", "cast"), "hits", hits.size(), casts.size());
  find_across<CastHit>(world, workers, options, hits,
                       [&](const World& part, Workers& crew, const QueryOptions& own) {
                         return queries::cast_shapes_ranged(part, casts, Wanted::first, crew, own);
                       });
}

void are_casts_blocked(DistributedWorld& world, std::span<const ShapeCast> casts,
                       std::span<std::uint8_t> blocked, Workers& workers, const QueryOptions& options) {
  queries::check_length(queries::call_of("are_casts_blocked", "cast"), "blocked", blocked.size(),
                        casts.size());
  block_across(world, workers, options, blocked,
               [&](const World& part, std::span<std::uint8_t> of_part, Workers& crew,
                   const QueryOptions& own) { are_casts_blocked(part, casts, of_part, crew, own); });
}

AnswerLists<CastHit> cast_shapes_all(DistributedWorld& world, std::span<const ShapeCast> casts,
                                     Workers& workers, const QueryOptions& options) {
  return list_across<CastHit>(world, workers, options,
                              [&](const World& part, Workers& crew, const QueryOptions& own) {
                                return queries::cast_shapes_ranged(part, casts, Wanted::all, crew, own);
                              });
}

AnswerLists<OverlapHit> overlap_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes,
                                       Workers& workers, const QueryOptions& options) {
  return list_across<OverlapHit>(world, workers, options,
                                 [&](const World& part, Workers& crew, const QueryOptions& own) {
                                   return ranged(overlap_shapes(part, shapes, crew, own));
                                 });
}

AnswerLists<OverlapHit> overlap_boxes(DistributedWorld& world, std::span<const AxisBox> boxes,
                                      Workers& workers, const QueryOptions& options) {
  return list_across<OverlapHit>(world, workers, options,
                                 [&](const World& part, Workers& crew, const QueryOptions& own) {
                                   return ranged(overlap_boxes(part, boxes, crew, own));
                                 });
}

AnswerLists<OverlapHit> overlap_points(DistributedWorld& world, std::span<const Vec3> points,
                                       Workers& workers, const QueryOptions& options) {
  return list_across<OverlapHit>(world, workers, options,
                                 [&](const World& part, Workers& crew, const QueryOptions& own) {
                                   return ranged(overlap_points(part, points, crew, own));
                                 });
}

void closest_to_points(DistributedWorld& world, std::span<const Vec3> points, float most,
                       std::span<std::optional<NearHit>> hits, Workers& workers,
                       const QueryOptions& options) {
  queries::check_length(queries::call_of("closest_to_points", "point"), "hits", hits.size(), points.size());
  find_across<NearHit>(world, workers, options, hits,
                       [&](const World& part, Workers& crew, const QueryOptions& own) {
                         return queries::near_points_ranged(part, points, most, Wanted::first, crew, own);
                       });
}

void closest_to_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes, float most,
                       std::span<std::optional<NearHit>> hits, Workers& workers,
                       const QueryOptions& options) {
  queries::check_length(queries::call_of("closest_to_shapes", "shape"), "hits", hits.size(), shapes.size());
  find_across<NearHit>(world, workers, options, hits,
                       [&](const World& part, Workers& crew, const QueryOptions& own) {
                         return queries::near_shapes_ranged(part, shapes, most, Wanted::first, crew, own);
                       });
}

AnswerLists<NearHit> near_points(DistributedWorld& world, std::span<const Vec3> points, float most,
                                 Workers& workers, const QueryOptions& options) {
  return list_across<NearHit>(
      world, workers, options, [&](const World& part, Workers& crew, const QueryOptions& own) {
        return queries::near_points_ranged(part, points, most, Wanted::all, crew, own);
      });
}

AnswerLists<NearHit> near_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes, float most,
                                 Workers& workers, const QueryOptions& options) {
  return list_across<NearHit>(
      world, workers, options, [&](const World& part, Workers& crew, const QueryOptions& own) {
        return queries::near_shapes_ranged(part, shapes, most, Wanted::all, crew, own);
      });
}

}  // namespace scree
