// Scene -> world, at its beginning and while it runs.
#include <tools/scenes/digest.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <utility>

namespace scree::scenes {
namespace {

constexpr std::size_t kBatch =
    1u << 16;  // bodies or joints a bulk call; bounds the copies of their definitions

bool same_surface(const SceneShape& left, const SceneShape& right) {
  return left.material == right.material && left.options == right.options;
}

// How many bodies of [first, end) from `first` on have one shape each and one surface in common.
std::size_t bulk_run(const Scene& scene, std::size_t first, std::size_t behind) {
  const std::size_t last = std::min(behind, first + kBatch);
  std::size_t end = first;
  while (end < last && scene.bodies[end].shape_count == 1 &&
         scene.bodies[end].comes_later == scene.bodies[first].comes_later &&
         same_surface(scene.shapes[scene.bodies[end].first_shape],
                      scene.shapes[scene.bodies[first].first_shape])) {
    ++end;
  }
  return end - first;
}

// Creates the bodies [begin, end) that come at first, or later.
void create_range(World& world, const Scene& scene, std::size_t begin, std::size_t end, bool later,
                  std::vector<BodyId>& ids) {
  std::vector<BodyDef> defs;
  std::vector<Geometry> geometries;
  for (std::size_t i = begin; i < end;) {
    if (scene.bodies[i].comes_later != later) {
      ++i;
      continue;
    }
    const std::size_t run = bulk_run(scene, i, end);
    if (run > 1) {
      defs.clear();
      geometries.clear();
      for (std::size_t k = i; k < i + run; ++k) {
        defs.push_back(scene.bodies[k].def);
        geometries.push_back(scene.shapes[scene.bodies[k].first_shape].geometry);
      }
      const SceneShape& first = scene.shapes[scene.bodies[i].first_shape];
      world.create_bodies(defs, geometries, first.material, first.options, std::span(ids).subspan(i, run));
      i += run;
      continue;
    }
    const SceneBody& body = scene.bodies[i];
    ids[i] = world.create_body(body.def);
    for (std::uint32_t k = 0; k < body.shape_count; ++k) {
      const SceneShape& shape = scene.shapes[body.first_shape + k];
      world.add_shape(ids[i], shape.geometry, shape.material, shape.options);
    }
    ++i;
  }
}

std::vector<JointId> create_joints(World& world, const Scene& scene, std::span<const BodyId> bodies) {
  const auto handle_of = [&](std::uint32_t body) { return body == kWorldItself ? kWorld : bodies[body]; };
  std::vector<JointId> ids(scene.joints.size());
  std::vector<JointDef> defs;
  std::vector<Joint> joints;
  for (std::size_t first = 0; first < ids.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, ids.size() - first);
    defs.clear();
    joints.clear();
    for (std::size_t i = first; i < first + count; ++i) {
      const SceneJoint& joint = scene.joints[i];
      defs.push_back(joint.def);
      defs.back().body_a = handle_of(joint.body_a);
      defs.back().body_b = handle_of(joint.body_b);
      joints.push_back(joint.joint);
    }
    world.create_joints(defs, joints, std::span(ids).subspan(first, count));
    for (std::size_t i = first; i < first + count; ++i) {
      if (!scene.joints[i].rows.empty()) world.set_user_rows(ids[i], scene.joints[i].rows);
    }
  }
  return ids;
}

}  // namespace

std::vector<BodyId> populate(World& world, const Scene& scene, std::vector<JointId>* joints) {
  std::vector<BodyId> ids(scene.bodies.size());
  create_range(world, scene, 0, ids.size(), false, ids);
  std::vector<JointId> joint_ids = create_joints(world, scene, ids);
  if (joints != nullptr) *joints = std::move(joint_ids);
  return ids;
}

std::vector<BodyId> populate(DistributedWorld& world, const Scene& scene, Workers& workers) {
  const std::size_t count = scene.bodies.size();
  const auto rank = static_cast<std::size_t>(world.rank()), ranks = static_cast<std::size_t>(world.ranks());
  std::vector<BodyId> ids(count);
  auto row = static_cast<std::uint32_t>(world.world().poses().size());
  world.give(
      [&](World& part) {
        create_range(part, scene, count * rank / ranks, count * (rank + 1) / ranks, false, ids);
      },
      workers);
  for (std::size_t i = 0; i < count; ++i) {
    if (!scene.bodies[i].comes_later) ids[i] = world.world().body_at(row++);
  }
  create_joints(world.world(), scene, ids);
  return ids;
}

std::uint64_t digest_of(const Scene& scene) {
  Digest digest;
  const auto add = [&](auto... numbers) {
    (digest.add(std::bit_cast<std::uint64_t>(static_cast<double>(numbers))), ...);
  };
  const auto add_vector = [&](const Vec3& vector) { add(vector.x, vector.y, vector.z); };
  add(scene.bodies.size(), scene.shapes.size(), scene.joints.size());
  for (const SceneBody& body : scene.bodies) {
    add(static_cast<int>(body.def.type), body.first_shape, body.shape_count, body.comes_later ? 1 : 0);
    add_vector(body.def.position);
    add_vector(body.def.linear_velocity);
  }
  for (const SceneShape& shape : scene.shapes)
    add(shape.geometry.index(), shape.material.friction, shape.material.restitution, shape.material.density);
  for (const SceneJoint& joint : scene.joints) add(joint.joint.index(), joint.body_a, joint.body_b);
  return digest.value();
}

std::span<const SceneChange> changes_at(const Scene& scene, std::int64_t steps_done) {
  const auto [begin, end] = std::equal_range(
      scene.changes.begin(), scene.changes.end(), SceneChange{.step = static_cast<int>(steps_done)},
      [](const SceneChange& left, const SceneChange& right) { return left.step < right.step; });
  return {begin, end};
}

void make_change(World& world, const Scene& scene, const SceneChange& change, std::vector<BodyId>& bodies) {
  const std::size_t begin = change.first, end = begin + change.count;
  if (change.creates) {
    create_range(world, scene, begin, end, true, bodies);
    return;
  }
  std::vector<BodyId> leaving;
  std::copy_if(bodies.begin() + static_cast<std::ptrdiff_t>(begin),
               bodies.begin() + static_cast<std::ptrdiff_t>(end), std::back_inserter(leaving),
               [&](BodyId body) { return world.is_alive(body); });
  world.destroy_bodies(leaving);
}

void direct(World& world, const Scene& scene, std::vector<BodyId>& bodies, std::int64_t steps_done,
            float dt) {
  for (const SceneChange& change : changes_at(scene, steps_done)) make_change(world, scene, change, bodies);
  drive(world, scene.drives, bodies, steps_done, dt);
}

Scene script_of(const Scene& scene) {
  Scene script;
  script.drives = scene.drives;
  script.changes = scene.changes;
  if (script.changes.empty()) return script;
  script.bodies = scene.bodies;
  script.shapes = scene.shapes;
  return script;
}

}  // namespace scree::scenes
