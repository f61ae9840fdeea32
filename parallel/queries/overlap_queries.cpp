// Overlaps: the shapes that touch a shape, a box or a point.
#include <parallel/queries/query_distance.h>
#include <parallel/queries/query_mesh.h>
#include <parallel/queries/query_ray.h>
#include <parallel/queries/query_scope.h>

#include <algorithm>

namespace scree {

namespace {

using queries::QueryShape;
using queries::Scope;
using queries::Solid;

// A shape that is touched.
struct Touched {
  std::int32_t shape;
  std::int32_t triangle = -1;  // see OverlapHit
};

// Adds the shapes near the solid that touches(touched) holds for, by index.
template <class Touches>
void list_those(const Scope& scope, const Solid& solid, std::vector<OverlapHit>& hits, Touches&& touches) {
  std::vector<Touched> all;
  queries::walk(scope, scope.kernels.query.meet, queries::task_of(solid), 0.0f,
                [&](std::int32_t shape, float limit) {
                  Touched touched{shape};
                  if (touches(touched)) all.push_back(touched);
                  return limit;
                });
  std::sort(all.begin(), all.end(), [](const Touched& a, const Touched& b) { return a.shape < b.shape; });
  for (const Touched& touched : all) {
    hits.push_back({shape_handle(scope.data, touched.shape),
                    body_handle(scope.data, scope.data.shapes.body[touched.shape]), touched.triangle});
  }
}

void list_touching(const Scope& scope, const Solid& solid, std::vector<OverlapHit>& hits) {
  list_those(scope, solid, hits, [&](Touched& touched) {
    const Solid other = queries::solid_of(scope.data, touched.shape);
    if (other.mesh == nullptr) return !(queries::gap_between(solid, other).distance > 0.0);
    touched.triangle = queries::touched_triangle(scope.kernels.query, solid, other);
    return touched.triangle >= 0;
  });
}

Solid solid_of(Vec3 point) {
  Solid solid;
  solid.position = queries::to_vector(point);
  return solid;
}

Solid solid_of(const AxisBox& box) {
  Solid solid;
  solid.type = ShapeType::box;
  const queries::Vector lower = queries::to_vector(box.lower), upper = queries::to_vector(box.upper);
  solid.position = 0.5 * (lower + upper);
  solid.half = 0.5 * (upper - lower);
  return solid;
}

void list_hits(const Scope& scope, const PlacedShape& placed, std::vector<OverlapHit>& hits) {
  const QueryShape shape(placed.geometry, placed.pose);
  list_touching(scope, shape.solid, hits);
}

void list_hits(const Scope& scope, const AxisBox& box, std::vector<OverlapHit>& hits) {
  list_touching(scope, solid_of(box), hits);
}

// As a ray of no length says; a mesh holds no point.
void list_hits(const Scope& scope, Vec3 point, std::vector<OverlapHit>& hits) {
  const Solid solid = solid_of(point);
  list_those(scope, solid, hits, [&](const Touched& touched) {
    queries::Entry entry;
    const Solid other = queries::solid_of(scope.data, touched.shape);
    return other.mesh == nullptr && queries::meet(scope.kernels.query, other, {solid.position, {}}, entry);
  });
}

void check_query(Call call, const PlacedShape& shape) {
  queries::check_placed(call, shape.geometry, shape.pose);
}

void check_query(Call call, const AxisBox& box) {
  queries::check_point(call, "lower", box.lower);
  for (int axis = 0; axis < 3; ++axis) {
    check_range(call, "upper", box.upper[axis], box.lower[axis], kMaxPosition);
  }
}

void check_query(Call call, Vec3 point) { queries::check_point(call, "point", point); }

template <class Query>
std::vector<OverlapHit> ask(Call call, const World& world, const Query& query, const QueryOptions& options) {
  check_query(call, query);
  std::vector<OverlapHit> hits;
  list_hits(queries::OwnScope(call, world, options).scope, query, hits);
  return hits;
}

template <class Query>
AnswerLists<OverlapHit> ask_each(Call call, const World& world, std::span<const Query> all, Workers& workers,
                                 const QueryOptions& options) {
  for (std::size_t i = 0; i < all.size(); ++i) check_query(item_of(call, all.size(), i), all[i]);
  return queries::list_all<OverlapHit>(
      call, world, all.size(), workers, options,
      [&](const Scope& scope, std::size_t i, auto& hits) { list_hits(scope, all[i], hits); });
}

}  // namespace

std::vector<OverlapHit> overlap_shape(const World& world, const PlacedShape& shape,
                                      const QueryOptions& options) {
  return ask(queries::call_of("overlap_shape"), world, shape, options);
}

std::vector<OverlapHit> overlap_box(const World& world, const AxisBox& box, const QueryOptions& options) {
  return ask(queries::call_of("overlap_box"), world, box, options);
}

std::vector<OverlapHit> overlap_point(const World& world, Vec3 point, const QueryOptions& options) {
  return ask(queries::call_of("overlap_point"), world, point, options);
}

AnswerLists<OverlapHit> overlap_shapes(const World& world, std::span<const PlacedShape> shapes,
                                       Workers& workers, const QueryOptions& options) {
  return ask_each(queries::call_of("overlap_shapes", "shape"), world, shapes, workers, options);
}

AnswerLists<OverlapHit> overlap_boxes(const World& world, std::span<const AxisBox> boxes, Workers& workers,
                                      const QueryOptions& options) {
  return ask_each(queries::call_of("overlap_boxes", "box"), world, boxes, workers, options);
}

AnswerLists<OverlapHit> overlap_points(const World& world, std::span<const Vec3> points, Workers& workers,
                                       const QueryOptions& options) {
  return ask_each(queries::call_of("overlap_points", "point"), world, points, workers, options);
}

}  // namespace scree
