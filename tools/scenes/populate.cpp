// Scene -> world.
#include <tools/scenes/scene.h>

#include <algorithm>
#include <utility>

namespace scree::scenes {
namespace {

constexpr std::size_t kBatch =
    1u << 16;  // bodies or joints a bulk call; bounds the copies of their definitions

bool same_surface(const SceneShape& left, const SceneShape& right) {
  return left.material == right.material && left.options == right.options;
}

// How many bodies from `first` on have one shape each and one surface in common.
std::size_t bulk_run(const Scene& scene, std::size_t first) {
  const std::size_t last = std::min(scene.bodies.size(), first + kBatch);
  std::size_t end = first;
  while (end < last && scene.bodies[end].shape_count == 1 &&
         same_surface(scene.shapes[scene.bodies[end].first_shape],
                      scene.shapes[scene.bodies[first].first_shape])) {
    ++end;
  }
  return end - first;
}

std::vector<JointId> create_joints(World& world, const Scene& scene, std::span<const BodyId> bodies) {
  const auto handle_of = [&](std::uint32_t body) { return body == kWorldItself ? BodyId{} : bodies[body]; };
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
  }
  return ids;
}

}  // namespace

std::vector<BodyId> populate(World& world, const Scene& scene, std::vector<JointId>* joints) {
  std::vector<BodyId> ids(scene.bodies.size());
  std::vector<BodyDef> defs;
  std::vector<Geometry> geometries;
  for (std::size_t i = 0; i < scene.bodies.size();) {
    const std::size_t run = bulk_run(scene, i);
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
  std::vector<JointId> joint_ids = create_joints(world, scene, ids);
  if (joints != nullptr) *joints = std::move(joint_ids);
  return ids;
}

}  // namespace scree::scenes
