// Reads the forces of contacts, in any number of threads at once. The first query after a step makes the
// lists of contacts by shape, so that worlds that are only stepped do not pay for them. They hold contacts of
// moving shapes; resting pairs have lists of their own.
#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <core/world/pair_key.h>
#include <core/world/resting_pairs.h>
#include <scree/world.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

const WorldData& opened_for_forces(Call call, const std::unique_ptr<WorldData>& owner) {
  const WorldData& data = opened(call, owner);
  if (!data.settings.contact_forces) {
    fail(call, "WorldSettings::contact_forces is off", ErrorCode::wrong_state);
  }
  return data;
}

// Rows of state, or zero while they are not measured.
ContactForceRow force_row(const Contacts& contacts, std::int32_t contact) {
  return std::cmp_less(contact, contacts.forces.size()) ? contacts.forces[contact] : ContactForceRow{};
}

bool bore(const Manifold& manifold, const ContactForceRow& forces, unsigned point) {
  return manifold.normal_impulse[point] > 0.0f || forces.normal_impulse[point] > 0.0f;
}

float nearest_of(const Manifold& manifold) {
  return *std::min_element(std::begin(manifold.separation), std::end(manifold.separation));
}

// Leaves out points ahead of time, and shapes that a call has replaced since the step.
bool is_present(const WorldData& data, std::int32_t contact) {
  const ShapePair pair = data.contacts.now.pair[contact];
  for (const std::int32_t shape : {pair.a, pair.b}) {
    const std::uint8_t flags = data.shapes.flags[shape];
    if ((flags & (kShapeAlive | kShapeNew)) != kShapeAlive) return false;
  }
  const Manifold& manifold = data.contacts.now.manifold[contact];
  if (nearest_of(manifold) <= kLinearSlop) return true;
  const ContactForceRow forces = force_row(data.contacts, contact);
  for (unsigned k = 0; k < (manifold.info & kManifoldPointMask); ++k) {
    if (bore(manifold, forces, k)) return true;
  }
  return false;
}

ContactForces describe(const WorldData& data, std::int32_t contact) {
  const ShapePair pair = data.contacts.now.pair[contact];
  const Manifold& manifold = data.contacts.now.manifold[contact];
  const ContactForceRow forces = force_row(data.contacts, contact);
  ContactForces found{};
  const auto name = [&](std::int32_t shape, ShapeId& shape_id, BodyId& body_id) {
    shape_id = shape_handle(data, shape);
    body_id = body_handle(data, data.shapes.body[shape]);
  };
  name(pair.a, found.shape_a, found.body_a);
  name(pair.b, found.shape_b, found.body_b);
  // The manifold's body B is the dynamic one if only one is; here it is that of the shape of higher index.
  const bool flipped = static_cast<std::uint32_t>(manifold.row_b) == found.body_a.index;
  const float side = flipped ? -1.0f : 1.0f;
  const Vec3 normal = to_vec3(manifold.normal);
  const Vec3 tangent_1 = tangent_of(normal), tangent_2 = cross(normal, tangent_1);
  found.normal = side * normal;
  // A contact that is not measured has not moved either: it sleeps, or the step had no length.
  const Vec3 now = to_vec3(data.bodies.pose[manifold.row_b].position) + to_vec3(manifold.arm_b);
  found.friction_center = forces.is_set != 0.0f ? to_vec3(forces.center) : now;
  found.friction_impulse =
      side * (forces.friction_impulse[0] * tangent_1 + forces.friction_impulse[1] * tangent_2);
  found.twist_impulse = forces.twist_impulse;  // about a normal that is turned round as the body is
  found.rolling_impulse = side * to_vec3(forces.rolling_impulse);
  const std::uint8_t color = data.contacts.now.color[contact];
  if (color != kNoColor) found.color = color;
  const float near = std::max(nearest_of(manifold), kSpeculativeDistance);
  for (unsigned k = 0; k < (manifold.info & kManifoldPointMask); ++k) {
    if (!(manifold.separation[k] <= near || bore(manifold, forces, k))) continue;
    found.points[found.point_count++] = {
        found.friction_center + manifold.point_u[k] * tangent_1 + manifold.point_v[k] * tangent_2,
        manifold.separation[k], forces.normal_impulse[k]};
  }
  return found;
}

// The rows of pairs at rest, by pair: shape by shape, because what a shape has is mostly in order.
void order_resting(const WorldData& data) {
  const Contacts& contacts = data.contacts;
  Column<std::int32_t>& order = contacts.resting_order;
  const auto comes_first = [&](std::int32_t x, std::int32_t y) {
    return comes_before(contacts.resting.pair[x], contacts.resting.pair[y]);
  };
  order.clear();
  for (std::int32_t shape = 0; shape < static_cast<std::int32_t>(data.shapes.flags.size()); ++shape) {
    const std::size_t first = order.size();
    for_each_resting(data, shape, [&](std::int32_t row, std::int32_t other) {
      if (shape < other) order.push_back(row);
    });
    if (!std::is_sorted(order.begin() + first, order.end(), comes_first))
      std::sort(order.begin() + first, order.end(), comes_first);
  }
}

const Column<std::int32_t>& ordered_resting(const WorldData& data) {
  data.contacts.resting_order_made.ensure([&data] { order_resting(data); });
  return data.contacts.resting_order;
}

// Calls visit(contact) for the contacts of both lists of pairs, in the order of the pairs.
template <class Visit>
void for_each_contact(const WorldData& data, Visit&& visit) {
  const Contacts& contacts = data.contacts;
  const PairRows &moving = contacts.pairs, &resting = contacts.resting;
  const Column<std::int32_t>& order = ordered_resting(data);
  std::size_t m = 0, r = 0;
  while (m < moving.pair.size() || r < order.size()) {
    const bool rests =
        m == moving.pair.size() || (r < order.size() && comes_before(resting.pair[order[r]], moving.pair[m]));
    scree::for_each_contact(contacts, rests ? resting.contact[order[r++]] : moving.contact[m++], visit);
  }
}

// The contacts of each shape that do not rest, in the order of their pairs.
void list_by_shape(const WorldData& data) {
  const Contacts& contacts = data.contacts;
  Column<std::int32_t>& end = contacts.by_shape_end;
  end.clear();
  end.resize(data.shapes.flags.size() + 1);  // to zero
  const auto for_each_end = [&](auto&& visit) {
    for (const std::int32_t first : contacts.pairs.contact) {
      scree::for_each_contact(contacts, first, [&](std::int32_t contact) {
        const ShapePair pair = contacts.now.pair[contact];
        visit(pair.a, contact);
        visit(pair.b, contact);
      });
    }
  };
  for_each_end([&](std::int32_t shape, std::int32_t) { ++end[shape + 1]; });
  std::int32_t sum = 0;
  for (std::int32_t& count : end) count = sum += count;  // -> where the shape's list begins
  contacts.by_shape.resize_discarding(sum);
  // Afterwards each entry is the end of its own shape's list.
  for_each_end([&](std::int32_t shape, std::int32_t contact) { contacts.by_shape[end[shape]++] = contact; });
}

std::span<const std::int32_t> moving_contacts_of(const Contacts& contacts, std::int32_t shape) {
  if (std::cmp_greater_equal(shape + 1, contacts.by_shape_end.size())) return {};  // younger than the lists
  const std::int32_t begin = shape == 0 ? 0 : contacts.by_shape_end[shape - 1];
  return std::span(contacts.by_shape.begin() + begin,
                   contacts.by_shape.begin() + contacts.by_shape_end[shape]);
}

// The contacts of one body or shape. Each thread has a list of its own, and keeps its memory.
Column<std::int32_t>& empty_list(const WorldData& data) {
  data.contacts.by_shape_made.ensure([&data] { list_by_shape(data); });
  thread_local Column<std::int32_t> found;
  found.clear();
  return found;
}

// Adds the contacts of a shape to `found`.
void find_contacts(const WorldData& data, std::int32_t shape, Column<std::int32_t>& found) {
  const Contacts& contacts = data.contacts;
  found.append(moving_contacts_of(contacts, shape));
  for_each_resting(data, shape, [&](std::int32_t row, std::int32_t) {
    scree::for_each_contact(contacts, contacts.resting.contact[row],
                            [&](std::int32_t contact) { found.push_back(contact); });
  });
}

void write_forces(const WorldData& data, std::int32_t contact, std::span<ContactForces> out,
                  std::size_t& count) {
  if (!is_present(data, contact)) return;
  if (count < out.size()) out[count] = describe(data, contact);
  ++count;
}

// Those found, in the order of their pairs. Returns how many there are.
std::size_t write_found(const WorldData& data, Column<std::int32_t>& found, std::span<ContactForces> out) {
  const Contacts& contacts = data.contacts;
  // Those of one pair keep their order.
  std::stable_sort(found.begin(), found.end(), [&](std::int32_t x, std::int32_t y) {
    return comes_before(contacts.now.pair[x], contacts.now.pair[y]);
  });
  std::size_t count = 0;
  for (const std::int32_t contact : found) write_forces(data, contact, out, count);
  return count;
}

}  // namespace

std::size_t World::contact_forces(std::span<ContactForces> out) const {
  const FpEnvironment environment;
  const WorldData& data = opened_for_forces({"contact_forces"}, data_);
  std::size_t count = 0;
  for_each_contact(data, [&](std::int32_t contact) { write_forces(data, contact, out, count); });
  return count;
}

std::size_t World::contact_forces_of(ShapeId shape, std::span<ContactForces> out) const {
  constexpr Call call{"contact_forces_of"};
  const FpEnvironment environment;
  const WorldData& data = opened_for_forces(call, data_);
  const std::int32_t row = checked_row(call, data, shape);
  Column<std::int32_t>& found = empty_list(data);
  find_contacts(data, row, found);
  return write_found(data, found, out);
}

std::size_t World::contact_forces_of(BodyId body, std::span<ContactForces> out) const {
  constexpr Call call{"contact_forces_of"};
  const FpEnvironment environment;
  const WorldData& data = opened_for_forces(call, data_);
  const std::int32_t row = checked_row(call, data, body);
  Column<std::int32_t>& found = empty_list(data);
  for (std::int32_t shape = data.bodies.first_shape[row]; shape >= 0; shape = data.shapes.next[shape]) {
    find_contacts(data, shape, found);
  }
  return write_found(data, found, out);
}

}  // namespace scree
