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
      return speaks_for(border_, static_cast<std::int32_t>(body.index)) && (!given || given(shape, body));
    };
  }
  AskAcross(const AskAcross&) = delete;
  AskAcross& operator=(const AskAcross&) = delete;

  // ask(world, workers, options): this rank's answers. What it throws on any rank, all throw.
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

// ask(world, blocked, workers, options): 1 or 0 for each query.
template <class Ask>
void block_across(Call call, DistributedWorld& world, std::size_t queries, Workers& workers,
                  const QueryOptions& options, std::span<std::uint8_t> blocked, Ask&& ask) {
  AskAcross across(world, workers, options);
  std::vector<std::int64_t> counts =
      across.ask([&](const World& part, Workers& crew, const QueryOptions& own) {
        queries::check_length(call, "blocked", blocked.size(), queries);
        std::vector<std::uint8_t> of_part(queries);
        ask(part, std::span(of_part), crew, own);
        return std::vector<std::int64_t>(of_part.begin(), of_part.end());
      });
  across.add_up(counts);
  for (std::size_t i = 0; i < queries; ++i) blocked[i] = counts[i] > 0 ? 1 : 0;
}

}  // namespace

void cast_rays(DistributedWorld& world, std::span<const Ray> rays, std::span<std::optional<CastHit>> hits,
               Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_rays", "ray");
  find_across<CastHit>(world, workers, options, hits, [&](auto& part, auto& crew, auto& own) {
    queries::check_length(call, "hits", hits.size(), rays.size());
    return queries::cast_rays_ranged(call, part, rays, Wanted::first, crew, own);
  });
}

void are_blocked(DistributedWorld& world, std::span<const Ray> rays, std::span<std::uint8_t> blocked,
                 Workers& workers, const QueryOptions& options) {
  block_across(
      queries::call_of("are_blocked", "ray"), world, rays.size(), workers, options, blocked,
      [&](auto& part, auto of_part, auto& crew, auto& own) { are_blocked(part, rays, of_part, crew, own); });
}

AnswerLists<CastHit> cast_rays_all(DistributedWorld& world, std::span<const Ray> rays, Workers& workers,
                                   const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_rays_all", "ray");
  return list_across<CastHit>(world, workers, options, [&](auto& part, auto& crew, auto& own) {
    return queries::cast_rays_ranged(call, part, rays, Wanted::all, crew, own);
  });
}

void cast_shapes(DistributedWorld& world, std::span<const ShapeCast> casts,
                 std::span<std::optional<CastHit>> hits, Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_shapes", "cast");
  find_across<CastHit>(world, workers, options, hits, [&](auto& part, auto& crew, auto& own) {
    queries::check_length(call, "hits", hits.size(), casts.size());
    return queries::cast_shapes_ranged(call, part, casts, Wanted::first, crew, own);
  });
}

void are_casts_blocked(DistributedWorld& world, std::span<const ShapeCast> casts,
                       std::span<std::uint8_t> blocked, Workers& workers, const QueryOptions& options) {
  block_across(queries::call_of("are_casts_blocked", "cast"), world, casts.size(), workers, options, blocked,
               [&](auto& part, auto of_part, auto& crew, auto& own) {
                 are_casts_blocked(part, casts, of_part, crew, own);
               });
}

AnswerLists<CastHit> cast_shapes_all(DistributedWorld& world, std::span<const ShapeCast> casts,
                                     Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("cast_shapes_all", "cast");
  return list_across<CastHit>(world, workers, options, [&](auto& part, auto& crew, auto& own) {
    return queries::cast_shapes_ranged(call, part, casts, Wanted::all, crew, own);
  });
}

AnswerLists<OverlapHit> overlap_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes,
                                       Workers& workers, const QueryOptions& options) {
  return list_across<OverlapHit>(world, workers, options, [&](auto& part, auto& crew, auto& own) {
    return ranged(overlap_shapes(part, shapes, crew, own));
  });
}

AnswerLists<OverlapHit> overlap_boxes(DistributedWorld& world, std::span<const AxisBox> boxes,
                                      Workers& workers, const QueryOptions& options) {
  return list_across<OverlapHit>(world, workers, options, [&](auto& part, auto& crew, auto& own) {
    return ranged(overlap_boxes(part, boxes, crew, own));
  });
}

AnswerLists<OverlapHit> overlap_points(DistributedWorld& world, std::span<const Vec3> points,
                                       Workers& workers, const QueryOptions& options) {
  return list_across<OverlapHit>(world, workers, options, [&](auto& part, auto& crew, auto& own) {
    return ranged(overlap_points(part, points, crew, own));
  });
}

void closest_to_points(DistributedWorld& world, std::span<const Vec3> points, float most,
                       std::span<std::optional<NearHit>> hits, Workers& workers,
                       const QueryOptions& options) {
  constexpr Call call = queries::call_of("closest_to_points", "point");
  find_across<NearHit>(world, workers, options, hits, [&](auto& part, auto& crew, auto& own) {
    queries::check_length(call, "hits", hits.size(), points.size());
    return queries::near_points_ranged(call, part, points, most, Wanted::first, crew, own);
  });
}

void closest_to_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes, float most,
                       std::span<std::optional<NearHit>> hits, Workers& workers,
                       const QueryOptions& options) {
  constexpr Call call = queries::call_of("closest_to_shapes", "shape");
  find_across<NearHit>(world, workers, options, hits, [&](auto& part, auto& crew, auto& own) {
    queries::check_length(call, "hits", hits.size(), shapes.size());
    return queries::near_shapes_ranged(call, part, shapes, most, Wanted::first, crew, own);
  });
}

AnswerLists<NearHit> near_points(DistributedWorld& world, std::span<const Vec3> points, float most,
                                 Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("near_points", "point");
  return list_across<NearHit>(world, workers, options, [&](auto& part, auto& crew, auto& own) {
    return queries::near_points_ranged(call, part, points, most, Wanted::all, crew, own);
  });
}

AnswerLists<NearHit> near_shapes(DistributedWorld& world, std::span<const PlacedShape> shapes, float most,
                                 Workers& workers, const QueryOptions& options) {
  constexpr Call call = queries::call_of("near_shapes", "shape");
  return list_across<NearHit>(world, workers, options, [&](auto& part, auto& crew, auto& own) {
    return queries::near_shapes_ranged(call, part, shapes, most, Wanted::all, crew, own);
  });
}

}  // namespace scree
