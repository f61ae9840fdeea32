// Brings the bodies that sensors of other ranks see unforeseen; part of ../bodies/finish_step.cpp.
//
// Ghosts were found by the bounds at the beginning of the step, which forces of the step may have led shapes
// out of. Where a sensor on a body of one rank meets a shape of another one then, both ranks tell of it: so
// each gets the other's body before ../events/list_sensor_events.cpp looks.
//
// A shape strays if it has left its bounds or comes so far that it is cast along its way. Of a sensor and a
// visitor that meet unforeseen, one strays at least. Ranks count these and tell each other the boxes around
// what they have; most steps end there. Else
//   1. a rank sends its sensors to those whose visitors they may meet,
//   2. these answer with the bodies of such visitors, and name the bodies of sensors that they lack,
//   3. which they get.
// More may come than is seen, as filters are not asked. What has come is in no Halo: owners decide before the
// next pairs whether it stays.
#include <core/world/edit.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/box_index.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/send_bodies.h>
#include <parallel/events/way_in_step.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

namespace scree {

namespace {

// A sensor or a visitor of one rank. `reach`: around the shape, and its way in the step.
struct SightShape {
  BoundsRow reach;
  std::int32_t shape, strays;  // 1: it does
};

// What a rank has that may meet what others have.
struct SightBoxes {
  BoundsRow sensors, visitors;
};

struct Answer {
  std::vector<std::int32_t> lent = {};    // own bodies that have a visitor, ascending
  std::vector<std::int32_t> wanted = {};  // that rank's bodies that have a sensor, ascending
};

class BringSights {
 public:
  BringSights(WorldData& data, Border& border, Crew& crew) : data_(data), border_(border), crew_(crew) {}
  void run();

 private:
  bool is_own(std::int32_t shape) const { return border_.owns(data_.shapes.body[shape]); }
  bool has_sensors() const;
  BoundsRow reach_of(std::int32_t shape) const;
  void list_strays();
  void list_sensors();
  bool share_boxes();
  template <class Work>
  void for_each_other(Work&& work) const;
  bool sends_to(std::int32_t rank) const { return bounds_meet(own().sensors, of(rank).visitors); }
  bool hears_from(std::int32_t rank) const { return bounds_meet(of(rank).sensors, own().visitors); }
  const SightBoxes& of(std::int32_t rank) const { return boxes_[static_cast<std::size_t>(rank)]; }
  const SightBoxes& own() const { return of(border_.here); }
  Answer answer_to(std::int32_t rank, const std::vector<SightShape>& sensors) const;
  void send(std::int32_t to, const std::vector<std::int32_t>& bodies) const;
  void receive(std::int32_t from, const std::vector<std::int32_t>& bodies);

  WorldData& data_;
  Border& border_;
  Crew& crew_;
  Column<std::int32_t> strays_ = {};       // own shapes, ascending
  std::vector<SightShape> sensors_ = {};   // own ones that may meet somebody unforeseen
  std::vector<SightShape> visitors_ = {};  // own ones that stray
  bool any_sensor_strays_ = false;         // in the whole world, as ...
  bool any_visitor_strays_ = false;
  std::vector<SightBoxes> boxes_ = {};  // by rank
  std::vector<std::int32_t> come_ = {};
};

// All ranks find the same.
bool BringSights::has_sensors() const {
  const Shapes& shapes = data_.shapes;
  if (shapes.sensors == 0) return false;
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    if ((shapes.flags[row] & kShapeSensor) != 0 && border_.owner_of(shapes.body[row]) != kEveryRank)
      return true;
  }
  return false;
}

// Around the shape where it is, and where it has come from. The bounds have room for what is rounded.
BoundsRow BringSights::reach_of(std::int32_t shape) const {
  BoundsRow reach = data_.shapes.fat_bounds[shape];
  const queries::Vector way = sensing::way_of(data_, shape);
  for (int axis = 0; axis < 3; ++axis) {
    const auto back = static_cast<float>(-way[axis]);
    (back < 0.0f ? reach.lower : reach.upper)[axis] += back;
  }
  return reach;
}

void BringSights::list_strays() {
  const Column<std::int32_t>& moving = data_.shapes.moving;
  const Column<std::uint8_t>& has_left = broad_phase_of(data_).has_left;
  SCREE_ASSERT(has_left.size() == moving.size());
  list_where(
      crew_, moving.size(), border_.places, strays_,
      [&](std::int32_t i) {
        return is_own(moving[i]) &&
               (has_left[i] != 0 || sensing::is_fast(data_.bodies, data_.shapes.body[moving[i]]));
      },
      [&](std::int32_t i) { return moving[i]; });
  for (const std::int32_t shape : strays_) {
    if (!is_sensor(data_.shapes, shape)) visitors_.push_back({reach_of(shape), shape, 1});
  }
}

void BringSights::list_sensors() {
  const Shapes& shapes = data_.shapes;
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    const auto shape = static_cast<std::int32_t>(row);
    if ((shapes.flags[row] & kShapeSensor) == 0 || !is_own(shape)) continue;
    const bool strays = std::binary_search(strays_.begin(), strays_.end(), shape);
    sensors_.push_back({reach_of(shape), shape, strays ? 1 : 0});
  }
}

// Returns whether any two shapes of the whole world may have met unforeseen.
bool BringSights::share_boxes() {
  std::int64_t strays[2] = {std::count_if(sensors_.begin(), sensors_.end(),
                                          [](const SightShape& sensor) { return sensor.strays != 0; }),
                            static_cast<std::int64_t>(visitors_.size())};
  border_.transport.add_up(strays);
  any_sensor_strays_ = strays[0] > 0;
  any_visitor_strays_ = strays[1] > 0;
  if (!any_sensor_strays_ && !any_visitor_strays_) return false;
  if (!any_visitor_strays_)
    std::erase_if(sensors_, [](const SightShape& sensor) { return sensor.strays == 0; });
  SightBoxes own{empty_box(), empty_box()};
  for (const SightShape& sensor : sensors_) include(own.sensors, sensor.reach);
  for (const SightShape& visitor : visitors_) include(own.visitors, visitor.reach);
  if (any_sensor_strays_) {
    include(own.visitors, border_.resting.box);
    for (const std::int32_t shape : border_.own_shapes) include(own.visitors, reach_of(shape));
  }
  boxes_ = gather_rows(border_.transport, own);
  return true;
}

template <class Work>
void BringSights::for_each_other(Work&& work) const {
  for (std::int32_t rank = 0; rank < border_.transport.ranks(); ++rank) {
    if (rank != border_.here) work(rank);
  }
}

Answer BringSights::answer_to(std::int32_t rank, const std::vector<SightShape>& sensors) const {
  Answer answer;
  std::vector<BoundsRow> all, straying;
  for (const SightShape& sensor : sensors) {
    all.push_back(sensor.reach);
    if (sensor.strays != 0) straying.push_back(sensor.reach);
  }
  const BoxIndex all_boxes(std::move(all)), straying_boxes(std::move(straying));
  const auto look = [&](std::int32_t shape, const BoundsRow& reach, bool strays) {
    if (!(strays ? all_boxes : straying_boxes).meets(reach)) return;
    answer.lent.push_back(data_.shapes.body[shape]);
    for (const SightShape& sensor : sensors) {
      if ((strays || sensor.strays != 0) && bounds_meet(sensor.reach, reach))
        answer.wanted.push_back(data_.shapes.body[sensor.shape]);
    }
  };
  for (const SightShape& visitor : visitors_) look(visitor.shape, visitor.reach, true);
  if (any_sensor_strays_) {
    const auto look_at_all = [&](const Column<std::int32_t>& shapes) {
      for (const std::int32_t shape : shapes) {
        if (is_own(shape) && !is_sensor(data_.shapes, shape)) look(shape, reach_of(shape), false);
      }
    };
    look_at_all(border_.own_shapes);
    look_at_all(border_.resting.shapes);
  }
  keep_each_once(answer.lent);
  keep_each_once(answer.wanted);
  const std::vector<std::int32_t>& known = border_.halos[static_cast<std::size_t>(rank)].lent;
  std::erase_if(answer.lent,
                [&](std::int32_t body) { return std::binary_search(known.begin(), known.end(), body); });
  std::erase_if(answer.wanted, [&](std::int32_t body) { return !is_absent(data_.bodies, body); });
  return answer;
}

// Bodies::delta is scratch, which send_bodies() leaves out.
void BringSights::send(std::int32_t to, const std::vector<std::int32_t>& bodies) const {
  send_bodies(border_.transport, to, data_, bodies);
  send_rows<DeltaRow>(border_.transport, to, bodies,
                      [&](std::int32_t body) { return data_.bodies.delta[body]; });
}

void BringSights::receive(std::int32_t from, const std::vector<std::int32_t>& bodies) {
  receive_bodies(border_.transport, from, data_, bodies);
  receive_rows<DeltaRow>(border_.transport, from, bodies,
                         [&](std::int32_t body, const DeltaRow& delta) { data_.bodies.delta[body] = delta; });
  come_.insert(come_.end(), bodies.begin(), bodies.end());
}

void BringSights::run() {
  if (!has_sensors()) return;
  list_strays();
  list_sensors();
  if (!share_boxes()) return;
  CountedTransport& transport = border_.transport;
  for_each_other([&](std::int32_t to) {
    if (!sends_to(to)) return;
    std::vector<SightShape> near;
    std::copy_if(sensors_.begin(), sensors_.end(), std::back_inserter(near),
                 [&](const SightShape& sensor) { return bounds_meet(sensor.reach, of(to).visitors); });
    send_list<SightShape>(transport, to, near);
  });
  std::vector<std::vector<std::int32_t>> wanted(boxes_.size());
  for_each_other([&](std::int32_t from) {
    if (!hears_from(from)) return;
    const std::vector<SightShape> sensors = receive_list<SightShape>(transport, from);
    for (const SightShape& sensor : sensors) {
      if (sensor.shape < 0 || std::cmp_greater_equal(sensor.shape, data_.shapes.flags.size()))
        refuse_world_of(from);
      check_owner(border_, from, data_.shapes.body[sensor.shape]);
    }
    Answer answer = answer_to(from, sensors);
    send_list<std::int32_t>(transport, from, answer.wanted);
    send_list<std::int32_t>(transport, from, answer.lent);
    send(from, answer.lent);
    wanted[static_cast<std::size_t>(from)] = std::move(answer.wanted);
  });
  for_each_other([&](std::int32_t to) {
    if (!sends_to(to)) return;
    const std::vector<std::int32_t> asked_for = receive_list<std::int32_t>(transport, to);
    for (const std::int32_t body : asked_for) {
      if (body < 0 || std::cmp_greater_equal(body, border_.owner.size()) || !border_.owns(body))
        refuse_world_of(to);
    }
    const std::vector<std::int32_t> lent = receive_list<std::int32_t>(transport, to);
    for (const std::int32_t body : lent) check_owner(border_, to, body);
    receive(to, lent);
    send(to, asked_for);
  });
  for_each_other([&](std::int32_t from) {
    if (hears_from(from)) receive(from, wanted[static_cast<std::size_t>(from)]);
  });
  if (!come_.empty()) enter_ghosts(data_, come_, crew_);
}

}  // namespace

void bring_sights(WorldData& data, Crew& crew) {
  if (Border* const border = border_of(data)) BringSights(data, *border, crew).run();
}

}  // namespace scree
