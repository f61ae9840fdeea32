// Lists what sensors see at the end of a step, and what has entered and left them.
//
// Runs last, when poses and the boxes of shapes are those of the next step, so that queries find shapes where
// callers will see them. A world without sensors pays nothing; one with sensors pays for the index that its
// next query would need, and for each sensor a walk and the distances of what is near.
//
// A shape that moves in a step by more than the radius of a ball within it may be in front of a sensor before
// and behind it afterwards. Such shapes are cast along their way (way_in_step.h), past sensors as these move.
// A sensor that moves as fast is cast past the others.
#include <parallel/distributed/border.h>
#include <parallel/distributed/give_events.h>
#include <parallel/events/way_in_step.h>
#include <parallel/queries/query_distance.h>
#include <parallel/queries/query_mesh.h>
#include <parallel/queries/query_ray.h>
#include <parallel/queries/query_scope.h>
#include <parallel/stages.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace scree {

namespace {

using queries::Scope;
using queries::Solid;
using queries::Vector;
using sensing::has_moved;
using sensing::is_fast;
using sensing::kMostWay;
using sensing::path_of;
using sensing::way_of;

constexpr int kSensorsPerChunk = 2;
constexpr int kFastPerChunk = 8;

// Rows of shapes.
struct Sight {
  std::int32_t sensor, visitor;

  friend auto operator<=>(const Sight&, const Sight&) = default;
};
using Sights = std::vector<Sight>;

bool sees(const WorldData& data, std::int32_t sensor, std::int32_t visitor) {
  const Shapes& shapes = data.shapes;
  const auto is_here = [&](std::int32_t shape) { return data.bodies.is_absent[shapes.body[shape]] == 0; };
  return !is_sensor(shapes, visitor) && is_here(sensor) && is_here(visitor) &&
         shapes.body[sensor] != shapes.body[visitor] &&
         queries::agree(shapes.filter[sensor], shapes.filter[visitor]) &&
         tells_of(border_of(data), shapes.body[sensor], shapes.body[visitor]);
}

bool touch(const Scope& scope, const Solid& sensor, const Solid& visitor) {
  if (visitor.mesh != nullptr) return queries::touched_triangle(scope.kernels.query, sensor, visitor) >= 0;
  queries::Entry entry;
  // A shape's position lies within it. For most of what a large sensor sees, this is all.
  if (queries::meet(scope.kernels.query, sensor, {visitor.position, {}}, entry)) return true;
  return !(queries::gap_between(sensor, visitor).distance > 0.0);
}

// Calls work(i, sights) for i in [0, count), and returns all sights in the order of i.
template <class Work>
Sights collect(Crew& crew, std::size_t count, int chunk_size, Work&& work) {
  const auto size = static_cast<std::size_t>(chunk_size);
  std::vector<Sights> by_chunk((count + size - 1) / size);
  crew.run_ranges(static_cast<int>(count), chunk_size, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) work(i, by_chunk[static_cast<std::size_t>(begin / chunk_size)]);
  });
  Sights all;
  for (const Sights& sights : by_chunk) all.insert(all.end(), sights.begin(), sights.end());
  return all;
}

std::vector<std::int32_t> list_sensors(const WorldData& data) {
  const Shapes& shapes = data.shapes;
  std::vector<std::int32_t> sensors;
  sensors.reserve(static_cast<std::size_t>(shapes.sensors));
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    if ((shapes.flags[row] & kShapeSensor) != 0 && !is_absent(data.bodies, shapes.body[row]))
      sensors.push_back(static_cast<std::int32_t>(row));
  }
  return sensors;
}

Sights list_overlaps(const Scope& scope, Crew& crew, const std::vector<std::int32_t>& sensors) {
  const WorldData& data = scope.data;
  return collect(crew, sensors.size(), kSensorsPerChunk, [&](int i, Sights& sights) {
    const std::int32_t sensor = sensors[static_cast<std::size_t>(i)];
    const Solid solid = queries::solid_of(data, sensor);
    const std::size_t before = sights.size();
    queries::walk(
        scope, scope.kernels.query.meet, queries::task_of(solid), 0.0f,
        [&](std::int32_t visitor, float limit) {
          if (sees(data, sensor, visitor) && touch(scope, solid, queries::solid_of(data, visitor))) {
            sights.push_back({sensor, visitor});
          }
          return limit;
        });
    std::sort(sights.begin() + static_cast<std::ptrdiff_t>(before), sights.end());
  });
}

float length_of(Vector way) { return static_cast<float>(queries::length(way)); }

// Whether the visitor, moved by `way` relative to the sensor, came past it within the step. Sides of
// triangles do not matter.
bool comes_past(const Scope& scope, Solid sensor, Solid visitor, Vector way) {
  constexpr queries::MeshLook kAnyTriangle{.back_sides = true, .any = true};
  queries::Contact contact;
  if (visitor.mesh != nullptr) {
    sensor.position = sensor.position + way;
    return queries::meet_mesh(scope.kernels.query, sensor, -way, visitor, 1.0, kAnyTriangle, contact);
  }
  if (visitor.type == ShapeType::half_space) {  // which cannot be moved against something
    sensor.position = sensor.position + way;
    return queries::meet(sensor, -way, visitor, 1.0, contact);
  }
  visitor.position = visitor.position - way;
  return queries::meet(visitor, way, sensor, 1.0, contact);
}

// Calls ask(shape) for shapes whose boxes, grown by `margin`, the shape has met on its way to where it is.
template <class Ask>
void walk_way(const Scope& scope, Solid solid, Vector way, float margin, Ask&& ask) {
  solid.position = solid.position - way;
  simd::CrossTask task = queries::task_of(solid, queries::to_vec3(way));
  for (float& half : task.half) half += margin;
  queries::walk(scope, scope.kernels.query.cross, task, 1.0f, [&](std::int32_t shape, float limit) {
    ask(shape);
    return limit;
  });
}

// Fast shapes past sensors, and fast sensors past what is not fast itself. Those that have stayed in a sensor
// are listed, too.
Sights list_passes(const Scope& scope, Crew& crew, const std::vector<std::int32_t>& sensors) {
  const WorldData& data = scope.data;
  const Bodies& bodies = data.bodies;
  std::vector<std::int32_t> fast;  // shapes
  float slow_path = 0.0f;          // m, the longest one of bodies that are not fast
  for (const auto* list : {&bodies.awake, &bodies.kinematic}) {
    for (const std::int32_t body : *list) {
      if (!has_moved(bodies, body)) continue;
      if (!is_fast(bodies, body)) {
        if (const float path = path_of(bodies, body); path < kMostWay) slow_path = std::max(slow_path, path);
        continue;
      }
      for (std::int32_t shape = bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape])
        fast.push_back(shape);
    }
  }
  if (fast.empty()) return {};
  float sensor_path = 0.0f;  // m, the longest one of sensors
  for (const std::int32_t sensor : sensors)
    sensor_path = std::max(sensor_path, length_of(way_of(data, sensor)));
  Sights passes = collect(crew, fast.size(), kFastPerChunk, [&](int i, Sights& sights) {
    const std::int32_t shape = fast[static_cast<std::size_t>(i)];
    const Solid solid = queries::solid_of(data, shape);
    const Vector way = way_of(data, shape);
    const bool is_seeing = is_sensor(data.shapes, shape);
    walk_way(scope, solid, way, is_seeing ? slow_path : sensor_path, [&](std::int32_t other) {
      const std::int32_t sensor = is_seeing ? shape : other, visitor = is_seeing ? other : shape;
      if (!is_sensor(data.shapes, sensor) || !sees(data, sensor, visitor)) return;
      const Vector relative = way - way_of(data, other);
      const Solid met = queries::solid_of(data, other);
      const bool past =
          is_seeing ? comes_past(scope, solid, met, -relative) : comes_past(scope, met, solid, relative);
      if (past) sights.push_back({sensor, visitor});
    });
  });
  std::sort(passes.begin(), passes.end());
  passes.erase(std::unique(passes.begin(), passes.end()), passes.end());
  return passes;
}

TouchingPair named(const WorldData& data, const Sight& sight) {
  const auto name_of = [](const auto& rows, std::int32_t row) {
    return SlotName{static_cast<std::uint32_t>(row), rows.generation[row]};
  };
  return {name_of(data.shapes, sight.sensor), name_of(data.shapes, sight.visitor),
          name_of(data.bodies, data.shapes.body[sight.sensor]),
          name_of(data.bodies, data.shapes.body[sight.visitor])};
}

Sight sight_of(const TouchingPair& row) {
  return {static_cast<std::int32_t>(row.shape_a.index), static_cast<std::int32_t>(row.shape_b.index)};
}

SensorEvent event_of(const WorldData& data, const TouchingPair& row) {
  return {handle_of<ShapeId>(data, row.shape_a), handle_of<ShapeId>(data, row.shape_b),
          handle_of<BodyId>(data, row.body_a), handle_of<BodyId>(data, row.body_b)};
}

// Both lists ascend. A slot that has another shape by now ends one sight and begins another.
void list_changes(const WorldData& data, const Sights& seen, const Sights& passes, Events& events) {
  std::size_t last = 0, pass = 0;
  const auto end_before = [&](const Sight* sight) {
    while (last < events.sensed.size() && (sight == nullptr || sight_of(events.sensed[last]) < *sight)) {
      events.sensor_ends.push_back(event_of(data, events.sensed[last++]));
    }
  };
  const auto begin_and_end = [&](const Sight& sight) {
    const SensorEvent event = event_of(data, named(data, sight));
    events.sensor_begins.push_back(event);
    events.sensor_ends.push_back(event);
  };
  // Passes before a sight; those that were seen before end as the others do.
  const auto pass_before = [&](const Sight* sight) {
    for (; pass < passes.size() && (sight == nullptr || passes[pass] < *sight); ++pass) {
      end_before(&passes[pass]);
      const bool was_seen = last < events.sensed.size() && sight_of(events.sensed[last]) == passes[pass] &&
                            events.sensed[last] == named(data, passes[pass]);
      if (!was_seen) begin_and_end(passes[pass]);
    }
  };
  for (const Sight& sight : seen) {
    pass_before(&sight);
    end_before(&sight);
    if (pass < passes.size() && passes[pass] == sight) ++pass;
    const TouchingPair now = named(data, sight);
    const bool is_known = last < events.sensed.size() && sight_of(events.sensed[last]) == sight;
    const bool goes_on = is_known && events.sensed[last] == now;
    if (is_known && !goes_on) events.sensor_ends.push_back(event_of(data, events.sensed[last]));
    if (is_known) ++last;
    if (!goes_on) events.sensor_begins.push_back(event_of(data, now));
  }
  pass_before(nullptr);
  end_before(nullptr);
}

}  // namespace

void list_sensor_events(WorldData& data, float dt, Crew& crew) {
  Events& events = data.events;
  Border* const border = border_of(data);
  if (border != nullptr && std::exchange(border->events_stale, false))
    forget_untold(data, *border, events.sensed);
  if (data.shapes.sensors == 0 && events.sensed.empty()) return;
  Sights seen, passes;
  if (data.shapes.sensors > 0) {
    const QueryOptions options{.sensors = true};
    const Scope scope(data, crew.kernels(), options);
    const std::vector<std::int32_t> sensors = list_sensors(data);
    seen = list_overlaps(scope, crew, sensors);
    if (dt > 0.0f) passes = list_passes(scope, crew, sensors);
  }
  list_changes(data, seen, passes, events);
  events.sensed.resize_discarding(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) events.sensed[i] = named(data, seen[i]);
}

}  // namespace scree
