// Scenes: engine-neutral lists of bodies and joints that tests, benchmarks and the command share.
//
// A scene is data: an engine's adapter walks the lists (populate() does it for Scree, bench/ for the peers).
// A few scenes consist of many independent worlds, hence the vector.
#pragma once

#include <scree/distributed_world.h>
#include <scree/scree.h>

#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace scree::scenes {

struct SceneShape {
  Geometry geometry;
  Material material;
  ShapeOptions options;
};

/// A body and its run of shapes. Bodies may share a run: equal bricks need one entry in Scene::shapes.
struct SceneBody {
  BodyDef def;
  std::uint32_t first_shape = 0;  ///< into Scene::shapes
  std::uint32_t shape_count = 0;
  bool comes_later = false;  ///< does not exist at first: one of Scene::changes creates it
};

/// Index that stands for the world itself instead of a body.
inline constexpr std::uint32_t kWorldItself = std::numeric_limits<std::uint32_t>::max();

/// A joint between two bodies of the scene, or between one of them and the world.
struct SceneJoint {
  JointDef def;  ///< its handles stay empty: the bodies are the two below
  Joint joint;
  std::uint32_t body_a = kWorldItself;  ///< into Scene::bodies
  std::uint32_t body_b = kWorldItself;
  std::vector<UserRow> rows{};  ///< of a user joint: its numbers, which stay
};

/// A kinematic body that turns steadily about an axis. Every step moves it to its pose at the step's end; see
/// drive_target.
struct SceneDrive {
  std::uint32_t body = 0;  ///< into Scene::bodies
  Pose start;              ///< of the body
  Vec3 center;             ///< m, a point of the axis
  Vec3 axis{0.0f, 1.0f, 0.0f};
  double degrees_per_second = 0.0;
  bool turns_body = true;  ///< or the body keeps its rotation and only its origin goes round
};

/// Bodies that arrive or leave together while the scene runs. No joint may name them.
struct SceneChange {
  int step = 0;             ///< before the step that follows so many
  std::uint32_t first = 0;  ///< into Scene::bodies
  std::uint32_t count = 0;  ///< of bodies from there on
  bool creates = true;      ///< or destroys
};

struct Scene {
  std::string name;
  WorldSettings settings;
  std::vector<SceneShape> shapes;
  std::vector<SceneBody> bodies;
  std::vector<SceneJoint> joints;
  std::vector<SceneDrive> drives;
  std::vector<SceneChange> changes;  ///< in the order in which they are made
  int steps = 200;  ///< a sensible length, the protocol's where the scene comes from a published benchmark
  float dt = 1.0f / 60.0f;
};

/// Parameters by name, as `--set key=value` gives them. A builder rejects names that it does not know.
using Parameters = std::map<std::string, double>;

struct SceneInfo {
  std::string name;
  std::string summary;    ///< one line
  Parameters parameters;  ///< names and defaults
};

/// The built-in scenes in the order in which they are listed.
const std::vector<SceneInfo>& catalog();

/// Builds a built-in scene; one element, or one per world. Throws scree::Error for an unknown name or
/// parameter and for impossible values.
std::vector<Scene> build(const std::string& name, const Parameters& parameters = {});

/// Throws what build would throw for the name and the parameters, without building anything.
void check(const std::string& name, const Parameters& parameters = {});

/// The pose of a driven body after that many seconds; the same bits on every machine.
Pose drive_target(const SceneDrive& drive, double seconds);

/// Call before a step of `dt` and after `steps_done` steps: makes the step move the driven bodies to their
/// poses at its end. `bodies` is the result of populate.
void drive(World& world, std::span<const SceneDrive> drives, std::span<const BodyId> bodies,
           std::int64_t steps_done, float dt);

/// Creates the scene's bodies and joints in an empty world. Returns the bodies' handles in the scene's order,
/// with empty ones for bodies that arrive later. The joints' handles go to `joints` if it is given.
std::vector<BodyId> populate(World& world, const Scene& scene, std::vector<JointId>* joints = nullptr);

/// As the other one, in an empty world that many ranks have, by DistributedWorld::give: each rank gives an
/// equal share of the bodies, one run of the list, and all ranks create the joints. All ranks call it
/// together, with the same scene.
std::vector<BodyId> populate(DistributedWorld& world, const Scene& scene, Workers& workers);

/// The same number for equal scenes, another one where bodies are at other places, or have other types or
/// materials, or where numbers or kinds of shapes and joints differ; scenes may still differ elsewhere.
std::uint64_t digest_of(const Scene& scene);

/// The changes that are due after this many steps.
std::span<const SceneChange> changes_at(const Scene& scene, std::int64_t steps_done);

/// Makes a change; `bodies` is the result of populate. Skips bodies that have already left.
void make_change(World& world, const Scene& scene, const SceneChange& change, std::vector<BodyId>& bodies);

/// Call before each step: makes the changes that are due, then drives bodies.
void direct(World& world, const Scene& scene, std::vector<BodyId>& bodies, std::int64_t steps_done, float dt);

/// The part of a scene that `direct` needs. Leaves out its bodies and shapes if no body arrives or leaves.
Scene script_of(const Scene& scene);

}  // namespace scree::scenes
