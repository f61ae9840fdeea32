// Checks of columns from outside; see snapshot_check.h.
//
// What is alive must be what calls can make: values within the limits of check.h, indices of what is there,
// lists without repetitions. The dead need only name rows that exist. Numbers of contacts are not checked:
// where a body's state becomes non-finite its contacts' impulses do, too, and a step copes with that.
//
// The state table has a rule for most columns (snapshot_rules.cpp). What stands here is what no rule of one
// column can tell:
//   bodies    the world's own rows; flags by type; motion by locks and joints; local_mass by type; core
//   shapes    body, which lives; flags; hull, mesh, extent, given_pose and pose by type; material; tree by
//             body; what meshes may belong to
//   hulls     content and shapes; of meshes, too
//   pairs     that they ascend, stand in one list only, and have their contacts to themselves; manifolds
//   joints    what create_joint checks (snapshot_check_joints.cpp)
//   events    by pair
//   lists     of a body's shapes and joints; of free slots and dirty shapes, which must be complete
#include <core/geometry/balls.h>
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/hull/hull_store.h>
#include <core/geometry/mesh/mesh_build.h>
#include <core/geometry/mesh/mesh_store.h>
#include <core/plain/rows.h>
#include <core/state/snapshot/absent_rows.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_check.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/state/snapshot/snapshot_refusal.h>
#include <core/world/check.h>
#include <core/world/contact_hooks.h>
#include <core/world/edit.h>
#include <core/world/pair_key.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

namespace scree {

namespace {

bool within(float x, float low, float high) { return x >= low && x <= high; }

// The world's own rows are there, and both lists of pairs together can be numbered.
void check_least_counts(const SavedColumns& saved, const Refusal& refusal) {
  constexpr std::size_t kMostRows = std::numeric_limits<std::int32_t>::max();
  refusal.require(saved.find("bodies", "flags").rows >= at(kFirstBody), "bodies", "flags", 0,
                  "wrong number of rows");
  const std::size_t pairs = saved.find("contacts.pairs", "pair").rows;
  refusal.require(saved.find("contacts.resting", "pair").rows <= kMostRows - pairs, "contacts.resting",
                  "pair", 0, "wrong number of rows");
}

void check_living_body(const Bodies& bodies, std::size_t row, const Refusal& refusal) {
  const auto require = [&](bool holds, const char* name, const char* problem) {
    refusal.require(holds, "bodies", name, row, problem);
  };
  const bool dynamic = given_type(bodies, static_cast<std::int32_t>(row)) == BodyType::dynamic;
  const unsigned quarantined = bodies.flags[row] & kBodyQuarantined;
  require((bodies.flags[row] & kBodyAsleep) == 0 || bodies.type[row] == BodyType::dynamic, "flags",
          "only dynamic bodies sleep");
  require(quarantined == 0 || bodies.type[row] == BodyType::fixed, "flags",
          "quarantined bodies take part as fixed");
  if (bodies.is_absent[row] != 0)
    return require((bodies.flags[row] & kBodyAsleep) == 0, "flags", "bodies that are absent do not sleep");
  require(quarantined != kBodyQuarantined, "flags", "a quarantined body was given one type only");
  const MotionRow& motion = bodies.motion[row];
  const auto locks = static_cast<std::uint32_t>(bodies.locks[row]);
  require(within(motion.linear_damping, 0.0f, kMaxRate) && within(motion.angular_damping, 0.0f, kMaxRate) &&
              within(motion.gravity_factor, -kMaxGravityFactor, kMaxGravityFactor),
          "motion", "is out of range");
  const std::uint32_t jointed = bodies.first_joint[row] != -1 ? std::uint32_t{kMotionJointed} : 0u;
  constexpr std::uint32_t kAsIs = std::uint32_t{kMotionGyroscopic} | std::uint32_t{kMotionSweptWhole};
  require((motion.flags & ~kAsIs) == ((dynamic ? locks : 0u) | jointed), "motion",
          "has other locks than the body, or the wrong flag for joints");
  const InertiaRow& inverse = bodies.local_mass[row];
  require(dynamic ? is_finite_row(inverse) && inverse.inverse_mass > 0.0f : is_zero_row(inverse),
          "local_mass", "is not that of such a body");
}

// The bodies' rows that all worlds have: as they are in a new one.
void check_reserved_bodies(Bodies& bodies, const Refusal& refusal) {
  World fresh;
  Bodies& expected = internals(fresh).bodies;
  const auto check = [&](const char* name, const auto& column, const auto& right) {
    using Row = std::remove_cvref_t<decltype(column[0])>;
    for (std::size_t row = 0; row < at(kFirstBody); ++row) {
      const auto* bytes = reinterpret_cast<const std::byte*>(&column[row]);
      const bool same = std::memcmp(bytes, &right[row], sizeof(Row)) == 0;
      refusal.require(same, "bodies", name, row, "the fixed world's rows cannot be changed");
    }
  };
#define SCREE_CHECK_RESERVED(kind, Type, name, ...) \
  if (ColumnKind::kind == ColumnKind::state) check(#name, bodies.name, expected.name);
  SCREE_BODY_MEMBERS(SCREE_CHECK_RESERVED, SCREE_NOTHING, SCREE_NOTHING, SCREE_NOTHING, SCREE_NOTHING)
#undef SCREE_CHECK_RESERVED
}

void check_bodies(const Bodies& bodies, const Refusal& refusal) {
  const auto is_alive = [&](std::size_t row) { return (bodies.flags[row] & kBodyAlive) != 0; };
  for (std::size_t row = at(kFirstBody); row < bodies.flags.size(); ++row) {
    if (is_alive(row)) check_living_body(bodies, row, refusal);
  }
  check_free_slots(bodies, at(kFirstBody), "bodies", refusal, is_alive);
}

bool is_material(const MaterialRow& material) {
  constexpr auto kMostRule = static_cast<std::uint32_t>(MixRule::maximum);
  const bool moves = material.surface_velocity[0] != 0.0f || material.surface_velocity[1] != 0.0f ||
                     material.surface_velocity[2] != 0.0f;
  const std::uint32_t mixing = material.rules & ~(std::uint32_t{kMaterialMoves} | kMaterialPatch);
  const bool has_patch = (material.rules & kMaterialPatch) != 0;
  return within(material.friction, 0.0f, kMaxFriction) && within(material.restitution, 0.0f, 1.0f) &&
         within(material.rolling_resistance, 0.0f, kMaxRollingResistance) &&
         (has_patch ? within(material.patch_radius, 0.0f, kMaxPatchRadius)
                    : material.patch_radius == kAutomaticPatch) &&
         std::all_of(std::begin(material.surface_velocity), std::end(material.surface_velocity),
                     [](float x) { return within(x, -kMaxSurfaceSpeed, kMaxSurfaceSpeed); }) &&
         (mixing & 0xff) <= kMostRule && mixing >> 8 <= kMostRule &&
         ((material.rules & kMaterialMoves) != 0) == moves;
}

bool is_extent(const WorldData& data, std::size_t row) {
  const ExtentRow& extent = data.shapes.extent[row];
  const auto fits = [](float x) { return within(x, kMinExtent, kMaxExtent); };
  switch (data.shapes.type[row]) {
    case ShapeType::sphere:
      return is_finite_row(extent) && fits(extent.radius);
    case ShapeType::capsule:
      return is_finite_row(extent) && fits(extent.half[1]) && fits(extent.radius);
    case ShapeType::box:
      return is_finite_row(extent) && fits(extent.half[0]) && fits(extent.half[1]) && fits(extent.half[2]);
    case ShapeType::rounded_box:
      return fits(extent.half[0]) && fits(extent.half[1]) && fits(extent.half[2]) && extent.radius > 0.0f &&
             extent.radius <= kMaxExtent;
    case ShapeType::cylinder:
    case ShapeType::cone:
      return fits(extent.half[0]) && fits(extent.half[1]) && extent.half[2] == extent.half[0] &&
             extent.radius == 0.0f;
    case ShapeType::half_space:
      return std::memcmp(&extent, &kHalfSpaceExtent, sizeof extent) == 0;
    case ShapeType::hull:
    case ShapeType::rounded_hull:
    case ShapeType::mesh:
      break;
  }
  const ExtentRow right = has_hull(data.shapes.type[row])
                              ? extent_of(data.hulls.shared[at(data.shapes.hull[row])])
                              : data.meshes.shared[at(data.shapes.mesh[row])].solid->extent;
  return std::memcmp(&extent, &right, sizeof right) == 0;
}

// Of a shape that has one, or else none.
template <class Store>
bool is_slot(const Store& store, std::int32_t slot, bool has_one) {
  if (!has_one) return slot == -1;
  return slot >= 0 && at(slot) < store.shared.size() && store.shared[at(slot)].solid != nullptr;
}

void check_living_shape(const WorldData& data, std::size_t row, const Refusal& refusal) {
  const Shapes& shapes = data.shapes;
  const auto require = [&](bool holds, const char* name, const char* problem) {
    refusal.require(holds, "shapes", name, row, problem);
  };
  require((data.bodies.flags[shapes.body[row]] & kBodyAlive) != 0, "body", "is dead");
  require((shapes.flags[row] & kShapeNew) == 0 || (shapes.flags[row] & kShapeDirty) != 0, "flags",
          "a new shape is dirty, too");
  const bool is_hull = has_hull(shapes.type[row]);
  require(is_slot(data.hulls, shapes.hull[row], is_hull), "hull", "is not that of such a shape");
  require(!is_hull || (data.hulls.shared[at(shapes.hull[row])].geometry.rounding > 0.0f) ==
                          (shapes.type[row] == ShapeType::rounded_hull),
          "hull", "is not that of such a shape");
  const bool is_mesh = shapes.type[row] == ShapeType::mesh;
  require(is_slot(data.meshes, shapes.mesh[row], is_mesh), "mesh", "is not that of such a shape");
  require(!is_mesh || (given_type(data.bodies, shapes.body[row]) != BodyType::dynamic &&
                       (shapes.flags[row] & kShapeSensor) == 0),
          "mesh", "belongs to a dynamic body, or to a sensor");
  require(shapes.type[row] != ShapeType::half_space ||
              (given_type(data.bodies, shapes.body[row]) != BodyType::dynamic &&
               (shapes.flags[row] & kShapeSensor) == 0),
          "type", "belongs to a dynamic body, or to a sensor");
  if (is_absent(data.bodies, shapes.body[row]))
    return require(shapes.tree[row] == TreeKind::none, "tree", "is another than its body's");
  require(is_extent(data, row), "extent", "is not that of such a shape");
  const Pose& given = shapes.given_pose[row];
  const auto near = [](float x) { return within(x, -kMaxLocalPosition, kMaxLocalPosition); };
  require(
      near(given.position.x) && near(given.position.y) && near(given.position.z) && is_unit(given.rotation),
      "given_pose", "is no placement");
  require(is_material(shapes.material[row]), "material", "is out of range");
  require(shapes.tree[row] == tree_of(data.bodies, shapes.body[row]), "tree", "is another than its body's");
  require((shapes.flags[row] & kShapeDirty) != 0 || is_placed(shapes.pose[row]), "pose", "is no placement");
}

// Every living shape stands once in the list of its body.
void check_shape_lists(const WorldData& data, const Refusal& refusal) {
  const Shapes& shapes = data.shapes;
  std::vector<bool> listed(shapes.flags.size());
  for (std::size_t body = 0; body < data.bodies.flags.size(); ++body) {
    std::int32_t from = -1;
    for (std::int32_t shape = data.bodies.first_shape[body]; shape != -1; shape = shapes.next[shape]) {
      const bool fits = shape >= 0 && at(shape) < listed.size() && !listed[at(shape)] &&
                        (shapes.flags[shape] & kShapeAlive) != 0 && at(shapes.body[shape]) == body;
      refusal.require(fits, from < 0 ? "bodies" : "shapes", from < 0 ? "first_shape" : "next",
                      from < 0 ? body : at(from), "is no shape of the body, or stands in its list twice");
      listed[at(shape)] = true;
      from = shape;
    }
  }
  for (std::size_t row = 0; row < listed.size(); ++row) {
    const bool fits = listed[row] || (shapes.flags[row] & kShapeAlive) == 0;
    refusal.require(fits, "shapes", "body", row, "does not list the shape");
  }
}

void check_shapes(const WorldData& data, const Refusal& refusal) {
  const Shapes& shapes = data.shapes;
  const auto is_alive = [&](std::size_t row) { return (shapes.flags[row] & kShapeAlive) != 0; };
  const auto is_dirty = [&](std::size_t row) { return (shapes.flags[row] & kShapeDirty) != 0; };
  std::size_t dirty = 0;
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    dirty += is_dirty(row) ? 1 : 0;
    if (is_alive(row)) check_living_shape(data, row, refusal);
  }
  check_shape_lists(data, refusal);
  check_free_slots(shapes, 0, "shapes", refusal, is_alive);
  check_listed(shapes.dirty, "shapes", "dirty", refusal, is_dirty);
  refusal.require(shapes.dirty.size() == dirty, "shapes", "dirty", 0, "does not list all dirty shapes");
}

std::uint64_t recomputed_content(const SharedHull& shared) { return hull_content(shared.geometry); }
std::uint64_t recomputed_content(const SharedMesh& shared) { return mesh_content(*shared.solid); }

// Of hulls or meshes; the column has the slots of shapes.
template <class Store>
void check_slots(const Store& store, const Column<std::int32_t>& of_shapes, const char* name,
                 const Refusal& refusal) {
  std::vector<std::int32_t> shapes(store.shared.size());
  for (const std::int32_t slot : of_shapes) {
    if (slot >= 0) ++shapes[at(slot)];
  }
  for (std::size_t slot = 0; slot < shapes.size(); ++slot) {
    const auto& shared = store.shared[slot];
    const bool used = shared.solid != nullptr;
    refusal.require(store.content[slot] == (used ? recomputed_content(shared) : 0), name, "content", slot,
                    "is that of another slot");
    refusal.require(store.shapes[slot] == shapes[slot] && used == (shapes[slot] > 0), name, "shapes", slot,
                    "is not the number of shapes that have what is in the slot");
  }
  check_listed(store.free_slots, name, "free_slots", refusal,
               [&](std::size_t slot) { return shapes[slot] == 0; });
}

// They are not state, but saved: see snapshot_columns.h.
void check_cores(WorldData& data, const Refusal& refusal) {
  data.shapes.local_pose.resize(data.shapes.flags.size());
  for (std::size_t row = 0; row < data.shapes.flags.size(); ++row) {
    if ((data.shapes.flags[row] & kShapeAlive) != 0 && !is_absent_row(data, SheetId::shapes, row))
      place_shape_in_body(data, static_cast<std::int32_t>(row));
  }
  for (std::size_t row = 0; row < data.bodies.flags.size(); ++row) {
    if ((data.bodies.flags[row] & kBodyAlive) == 0 || data.bodies.is_absent[row] != 0) continue;
    const CoreRow saved = data.bodies.core[row];
    measure_core(data, static_cast<std::int32_t>(row));
    const bool same = std::memcmp(&saved, &data.bodies.core[row], sizeof saved) == 0;
    refusal.require(same, "bodies", "core", row, "is not that of the body's shapes");
  }
}

// The rows that a manifold names, which the solver writes to, must be those of its pair's bodies.
bool has_own_bodies(const WorldData& data, const ShapePair& pair, const Manifold& manifold) {
  const auto is_body = [&](std::int32_t row) {
    return row >= kFirstBody && at(row) < data.bodies.flags.size();
  };
  if (!is_body(manifold.row_b) || (manifold.row_a != kFixedRow && !is_body(manifold.row_a))) return false;
  const auto is_known = [&](std::int32_t shape) {
    return (data.shapes.flags[shape] & (kShapeAlive | kShapeNew)) == kShapeAlive;
  };
  if (!is_known(pair.a) || !is_known(pair.b)) return true;  // it will not be inherited
  const std::int32_t first = data.shapes.body[pair.a], second = data.shapes.body[pair.b];
  if (first == second || (manifold.row_b != first && manifold.row_b != second)) return false;
  const std::int32_t other = manifold.row_b == first ? second : first;
  const BodyType type = data.bodies.type[other];
  return data.bodies.type[manifold.row_b] == BodyType::dynamic &&
         manifold.row_a == (type == BodyType::fixed ? kFixedRow : other) &&
         ((manifold.info & kManifoldStatic) != 0) == (type != BodyType::dynamic);
}

// The contact of a row of pairs, which no other row may have.
void check_contact(const WorldData& data, const SavedColumns& saved, const PackedColumns& packed,
                   const Refusal& refusal, const ShapePair& pair, std::int32_t contact) {
  const std::byte* manifolds = packed.bytes.data() + saved.find("contacts.now", "manifold").begin;
  Manifold manifold;
  std::memcpy(static_cast<void*>(&manifold),
              manifolds + place_of_contact(packed, at(contact)) * sizeof manifold, sizeof manifold);
  const std::uint8_t points = data.contacts.now.points[contact];
  const std::uint32_t info = manifold.info & ~std::uint32_t{kManifoldRich | kManifoldStatic};
  refusal.require(points <= kMaxManifoldPoints && info == points, "contacts.now", "manifold", at(contact),
                  "has another number of points");
  refusal.require(has_own_bodies(data, pair, manifold), "contacts.now", "manifold", at(contact),
                  "is not between the bodies of its pair");
}

// The contact behind another one of the same pair.
std::int32_t saved_next(const SavedColumns& saved, const PackedColumns& packed, std::int32_t contact) {
  const std::byte* rows = packed.bytes.data() + saved.find("contacts.now", "next").begin;
  std::uint32_t next = 0;
  std::memcpy(&next, rows + place_of_contact(packed, at(contact)) * sizeof next, sizeof next);
  return static_cast<std::int32_t>(next - 1u);
}

bool may_have_several(const WorldData& data, const ShapePair& pair) {
  return data.shapes.type[pair.a] == ShapeType::mesh || data.shapes.type[pair.b] == ShapeType::mesh;
}

// One of the two lists, of which only that of `pairs` ascends. `taken` has the contacts that belong to pairs.
void check_list_of_pairs(const WorldData& data, const PairRows& pairs, const char* store,
                         const SavedColumns& saved, const PackedColumns& packed, const Refusal& refusal,
                         std::vector<bool>& taken) {
  const auto shapes = static_cast<std::int32_t>(data.shapes.flags.size());
  const Column<std::uint8_t>& points = data.contacts.now.points;
  const bool rest = &pairs == &data.contacts.resting;
  for (std::size_t row = 0; row < pairs.pair.size(); ++row) {
    const ShapePair pair = pairs.pair[row];
    const bool ascends = rest || row == 0 || comes_before(pairs.pair[row - 1], pair);
    refusal.require(pair.a >= 0 && pair.a < pair.b && pair.b < shapes && ascends, store, "pair", row,
                    "names no two shapes, or does not ascend");
    const bool has_hull = data.shapes.hull[pair.a] >= 0 || data.shapes.hull[pair.b] >= 0;
    const bool is_new = ((data.shapes.flags[pair.a] | data.shapes.flags[pair.b]) & kShapeNew) != 0;
    refusal.require(!pairs.axis.empty() || !has_hull || is_new, store, "axis", 0,
                    "a pair with a hull has none");
    for (std::int32_t contact = pairs.contact[row]; contact != -1;) {
      const bool fits =
          contact >= 0 && at(contact) < points.size() && !taken[at(contact)] && points[contact] != 0;
      refusal.require(fits, store, "contact", row, "is no contact, or another pair's");
      taken[at(contact)] = true;
      check_contact(data, saved, packed, refusal, pair, contact);
      const std::int32_t next = saved_next(saved, packed, contact);
      refusal.require(next == -1 || is_new || may_have_several(data, pair), "contacts.now", "next",
                      at(contact), "follows the contact of a pair without a mesh");
      contact = next;
    }
  }
}

void check_pairs(const WorldData& data, const SavedColumns& saved, const PackedColumns& packed,
                 const Refusal& refusal) {
  const Column<std::uint8_t>& points = data.contacts.now.points;
  const Column<ShapePair>&pairs = data.contacts.pairs.pair, &resting = data.contacts.resting.pair;
  std::vector<bool> taken(points.size());
  check_list_of_pairs(data, data.contacts.pairs, "contacts.pairs", saved, packed, refusal, taken);
  check_list_of_pairs(data, data.contacts.resting, "contacts.resting", saved, packed, refusal, taken);
  std::vector<std::size_t> order(resting.size());
  for (std::size_t row = 0; row < order.size(); ++row) order[row] = row;
  std::sort(order.begin(), order.end(),
            [&](std::size_t x, std::size_t y) { return comes_before(resting[x], resting[y]); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t row = order[i];
    refusal.require(i == 0 || comes_before(resting[order[i - 1]], resting[row]), "contacts.resting", "pair",
                    row, "stands there twice");
    refusal.require(!std::binary_search(pairs.begin(), pairs.end(), resting[row], comes_before),
                    "contacts.resting", "pair", row, "stands in both lists");
  }
  const auto contacts = static_cast<std::size_t>(std::count(taken.begin(), taken.end(), true));
  refusal.require(contacts == packed.contacts.size(), "contacts.now", "points", 0,
                  "some contact belongs to no pair");
  check_listed(data.contacts.free_rows, "contacts", "free_rows", refusal,
               [&](std::size_t row) { return points[row] == 0; });
  // Restoring makes whole rows of them.
  refusal.require(data.contacts.free_rows.size() + contacts == points.size(), "contacts", "free_rows", 0,
                  "some free row is not listed");
}

void check_events(const WorldData& data, const Refusal& refusal) {
  const Column<TouchRow>& touching = data.events.touching;
  for (std::size_t row = 0; row < touching.size(); ++row) {
    const bool fits = touching[row].events >= 1 && touching[row].events <= kTouchEvents &&
                      (row == 0 || key_of(touching[row - 1]) < key_of(touching[row]));
    refusal.require(fits, "events", "touching", row, "asks for nothing, or does not ascend");
  }
  const PairRows& pairs = data.contacts.resting;
  for (std::size_t row = 0; row < data.events.resting.size(); ++row) {
    const TouchRow& rests = data.events.resting[row];
    if (is_zero_row(rests)) continue;
    const bool fits = rests.events >= 1 && rests.events <= kTouchEvents &&
                      key_of(rests) == key_of(pairs.pair[row]) && pairs.contact[row] >= 0;
    refusal.require(fits, "events", "resting", row, "asks for nothing, or is another pair's");
    const bool moves =
        std::binary_search(touching.begin(), touching.end(), rests,
                           [](const TouchRow& x, const TouchRow& y) { return key_of(x) < key_of(y); });
    refusal.require(!moves, "events", "resting", row, "stands among those that move, too");
  }
}

void check_hooks(const WorldData& data, const Refusal& refusal) {
  const Column<HookAnswer>& answers = data.hooks.answers;
  const auto place = [](const HookAnswer& answer) { return std::pair(key_of(answer), answer.contact); };
  for (std::size_t row = 0; row < answers.size(); ++row) {
    const HookAnswer& answer = answers[row];
    const bool fits = answer.shape_a.index < answer.shape_b.index && answer.contact >= -1 &&
                      answer.acts <= 1 && is_sound(rules_of(answer)) &&
                      (row == 0 || place(answers[row - 1]) < place(answer));
    refusal.require(fits, "hooks", "answers", row, "is no answer, or does not ascend");
  }
}

struct Offset {
  std::size_t value;
};

void refuse_number(const void* context, std::size_t offset, const char* reason) {
  refuse_bytes(static_cast<const Offset*>(context)->value + offset, reason);
}

}  // namespace

SavedColumns check_columns(PackedColumns& packed, const SnapshotData& snapshot, std::size_t offset) {
  const Offset context{offset};
  const SavedColumns saved = find_columns(packed.bytes, refuse_number, &context);
  const SavedColumn& points = saved.find("contacts.now", "points");
  list_contacts(reinterpret_cast<const std::uint8_t*>(packed.bytes.data() + points.begin), points.rows,
                packed.contacts);
  const Refusal refusal(packed, saved, offset);
  check_counts(packed, snapshot.hulls.size(), snapshot.meshes.size(), saved, refusal);
  check_least_counts(saved, refusal);
  WorldData data;
  load_columns(packed, saved, data);
  data.hulls.shared = snapshot.hulls;
  data.meshes.shared = snapshot.meshes;
  data.bodies.is_absent.resize(data.bodies.flags.size());
  if (snapshot.is_part) find_absent_bodies(data.bodies);
  check_reserved_bodies(data.bodies, refusal);
  check_rules(data, snapshot.is_part, refusal);
  check_bodies(data.bodies, refusal);
  check_shapes(data, refusal);
  check_slots(data.hulls, data.shapes.hull, "hulls", refusal);
  check_slots(data.meshes, data.shapes.mesh, "meshes", refusal);
  check_cores(data, refusal);
  check_pairs(data, saved, packed, refusal);
  check_joints(data, refusal);
  check_events(data, refusal);
  check_hooks(data, refusal);
  return saved;
}

}  // namespace scree
