// Smooth and rounded shapes against triangles of a mesh: one triangle after the other, as a core without
// margin (collide_smooth.h).
//
// The normal is that of the closest points, or that of the least depth, if the mesh supports it. Else the
// triangle pushes along its own normal, and no deeper than along the least axis; or not at all, if it is much
// deeper along its own: then it lies beside the shape, and others hold that; where none does, the one that is
// the least deep. These are the rules of boxes and hulls (collide_mesh_polytope.cpp).
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

struct Triangle {
  D3 corner[3], normal, behind[3];
};

// The triangles of a batch as plain numbers.
struct Lanes {
  alignas(64) float corner[3][3][kLanes], normal[3][kLanes], behind[3][3][kLanes];

  explicit Lanes(const WideTriangles& t) {
    put(normal, t.normal);
    for (int k = 0; k < 3; ++k) {
      put(corner[k], t.corner[k]);
      put(behind[k], t.behind[k]);
    }
  }
  Triangle get(int lane) const {
    Triangle t;
    t.normal = get(normal, lane);
    for (int k = 0; k < 3; ++k) {
      t.corner[k] = get(corner[k], lane);
      t.behind[k] = get(behind[k], lane);
    }
    return t;
  }

 private:
  static void put(float (&to)[3][kLanes], V3 v) {
    store(to[0], v.x);
    store(to[1], v.y);
    store(to[2], v.z);
  }
  static D3 get(const float (&from)[3][kLanes], int lane) {
    return {double{from[0][lane]}, double{from[1][lane]}, double{from[2][lane]}};
  }
};

// As of many triangles at once, see collide_mesh.h.
bool is_supported(const Triangle& t, D3 d, double tolerance) {
  const double slack{kTurnSlack};
  if (dot(d, t.normal) < -slack) return false;
  const double height[3] = {dot(d, t.corner[0]), dot(d, t.corner[1]), dot(d, t.corner[2])};
  const double least = greater_of(height[0], greater_of(height[1], height[2])) - tolerance;
  const bool top[3] = {height[0] >= least, height[1] >= least, height[2] >= least};
  const int tops = (top[0] ? 1 : 0) + (top[1] ? 1 : 0) + (top[2] ? 1 : 0);
  if (tops == 3) return true;
  for (int k = 0; k < 3; ++k) {
    const bool both = top[k] && top[(k + 1) % 3], one = top[k] || top[(k + 1) % 3];
    if ((tops == 2 ? both : one) && dot(d, t.behind[k]) > slack) return false;
  }
  return true;
}

// The name of a corner of the shape, or one that is mixed with the triangle's.
std::uint32_t name_of(std::uint32_t id, std::int32_t triangle) {
  return is_first_corner(id) ? 1u + first_name(id) : mixed_name(triangle, id);
}

// How the shape touches a triangle.
struct Push {
  Gap gap;         // along the direction in which the triangle pushes
  bool is_own;     // the direction of the closest points, or of the least depth
  double largest;  // m, gap along any direction, whether the mesh supports it or not
};

// False: no point is within reach.
bool put_contact(const MeshPair& pair, const Core& core, const Push& push, std::int32_t triangle,
                 TriangleContact& to) {
  const double reach{pair.hulls.reach};
  SmoothContact contact;
  find_points(pair.smooth, core, push.gap, reach, pair.motion, contact);
  to = {};
  to.triangle = triangle;
  to.normal[0] = static_cast<float>(push.gap.normal.x);
  to.normal[1] = static_cast<float>(push.gap.normal.y);
  to.normal[2] = static_cast<float>(push.gap.normal.z);
  for (float& separation : to.separation) separation = kAbsentSeparation;
  int count = 0;
  for (int k = 0; k < contact.count; ++k) {
    const double separation = greater_of(contact.separation[k], push.largest);
    if ((!push.is_own && is_of_search(contact.id[k])) || separation > reach) continue;
    const D3 p = contact.point[k];
    to.point[count][0] = static_cast<float>(p.x);
    to.point[count][1] = static_cast<float>(p.y);
    to.point[count][2] = static_cast<float>(p.z);
    to.separation[count] = static_cast<float>(separation);
    to.id[count++] = name_of(contact.id[k], triangle);
  }
  return count > 0;
}

bool touch(const MeshPair& pair, const Triangle& t, std::int32_t triangle, MeshBeside& beside,
           TriangleContact& to) {
  const double reach{pair.hulls.reach};
  const Core core = triangle_core(t.corner[0], t.corner[1], t.corner[2]);
  const D3 down = -t.normal;
  Push push;
  Gap& gap = push.gap;
  if (!find_gap(pair.smooth, core, &down, reach, gap)) return false;
  push.largest = gap.separation - pair.smooth.margin;
  push.is_own = is_supported(t, -gap.normal, tolerance_of(pair.smooth, core));
  if (!push.is_own) {
    gap.normal = down;
    measure_along(pair.smooth, core, gap);
    const double separation = gap.separation - pair.smooth.margin;
    if (push.largest > separation + double{kBeside}) {
      if (push.largest > 0.0 || (beside.triangle >= 0 && !(separation > beside.separation))) return false;
      TriangleContact made;
      if (!put_contact(pair, core, push, triangle, made)) return false;
      beside.contact = made;
      beside.triangle = triangle;
      beside.separation = separation;
      return false;
    }
  }
  if (!put_contact(pair, core, push, triangle, to)) return false;
  beside.is_held = beside.is_held || push.largest <= 0.0;
  return true;
}

// Vectors of the world in the shape's frame.
void turn_into(const Core& shape, BodyMotion& motion) {
  motion.linear = shape.turn_back(motion.linear);
  motion.angular = shape.turn_back(motion.angular);
  motion.center = shape.turn_back(motion.center);
  motion.whole_angular = shape.turn_back(motion.whole_angular);
}

}  // namespace

bool set_smooth(const CollideColumns& columns, const CollideItem& item, MeshPair& pair) {
  const PoseRow &shape = columns.shape_pose[item.shape_1], &mesh = columns.shape_pose[item.shape_2];
  Core core, frame;
  pair.smooth.kind = CoreKind::point;
  if (!make_core(columns, item.shape_1, {0.0, 0.0, 0.0}, core)) return false;
  if (!make_frame(mesh, to_d3(mesh.position) - to_d3(shape.position), frame)) return false;
  pair.motion = motion_of(columns, item.body_1, item.body_2, shape.position, core, frame);
  for (BodyMotion& motion : pair.motion.body) turn_into(core, motion);
  pair.smooth = core;
  pair.smooth.axis[0] = {1.0, 0.0, 0.0};
  pair.smooth.axis[1] = {0.0, 1.0, 0.0};
  pair.smooth.axis[2] = {0.0, 0.0, 1.0};
  return true;
}

int touch_smooth(const MeshPair& pair, const TriangleBatch& batch, MeshBeside& beside, TriangleContact* out) {
  if (pair.smooth.size < 0.0) return 0;
  const Lanes lanes(place_triangles(pair, batch));
  int count = 0;
  for (int lane = 0; lane < batch.count; ++lane) {
    if (touch(pair, lanes.get(lane), batch.triangle[lane], beside, out[count])) ++count;
  }
  return count;
}

void store_smooth_mesh_manifolds(const CollideColumns& columns, const CollideItem* items,
                                 const MeshManifold* found, int count, const CollideColumns& own,
                                 const CollideItem* own_items) {
  SmoothStore contacts(own, own_items);
  for (int i = 0; i < count; ++i) {
    Core core;
    if (!make_core(columns, items[i].shape_1, {0.0, 0.0, 0.0}, core)) continue;
    const TriangleContact& from = found[i].contact;
    SmoothContact contact;
    contact.normal = core.turn(to_d3(from.normal));
    contact.count = 0;
    for (int k = 0; k < kMaxManifoldPoints && from.id[k] != 0; ++k) {
      contact.point[k] = core.turn(to_d3(from.point[k]));
      contact.separation[k] = double{from.separation[k]};
      contact.id[k] = from.id[k];
      ++contact.count;
    }
    Feature feature;
    find_feature(core, contact.normal, {lean_of(core, contact.normal), false, contact.normal}, feature);
    const D3 spin = to_d3(columns.body_velocity[items[i].body_1].angular);
    const Roundness round = find_roundness(core, feature, contact, 1.0, spin);
    contact.core_1 = round.core;
    contact.core_2 = 0.0;
    contact.curvature_radius = round.curvature;
    contact.at_edges = contact.in_strip = false;
    contacts.put(i, contact);
  }
  contacts.flush();
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
