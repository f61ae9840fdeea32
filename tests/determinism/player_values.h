// Arguments of random calls: drawn from the call's own random numbers, printed for its log.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/random.h>

#include <ostream>

namespace scree::determinism {

// Draws the same values under any rounding mode of the caller: only the world's calls run under that mode.
class Random : public scenes::Random {
 public:
  using scenes::Random::Random;
  float between(float low, float high);
  Quat rotation();
};

Vec3 random_vector(Random& random, float limit);
Pose random_pose(Random& random);  // somewhere in the pit
Geometry random_geometry(Random& random);
TriangleMesh random_mesh(Random& random);
Material random_material(Random& random);
Filter random_filter(Random& random);
ShapeOptions random_options(Random& random);
// Sets hooks whose answers depend on the pair and the contact alone; some are out of range.
void hook_up(World& world);
AxisLocks random_locks(Random& random);
BodyDef random_body_def(Random& random);
MassProperties random_mass_properties(Random& random);
float random_time_step(Random& random);  // s
WorldSettings random_settings(Random& random);
Joint random_joint(Random& random, JointType type);
// A joint without its bodies. Its frames are near each other for bodies with these poses.
UserRow random_user_row(Random& random);
JointDef random_joint_def(Random& random, const Pose& at_a, const Pose& at_b);

// Half the width of the pit in which the calls create bodies, and the height of its walls.
inline constexpr float kPitHalfWidth = 6.0f;  // m
inline constexpr float kPitHeight = 12.0f;    // m

void print(std::ostream& out, float value);
void print(std::ostream& out, int value);
void print(std::ostream& out, std::uint32_t value);
void print(std::ostream& out, bool value);
void print(std::ostream& out, const char* value);
void print(std::ostream& out, Vec3 value);
void print(std::ostream& out, Quat value);
void print(std::ostream& out, const Pose& value);
void print(std::ostream& out, const Geometry& value);
void print(std::ostream& out, const Material& value);
void print(std::ostream& out, const Filter& value);
void print(std::ostream& out, const BodyDef& value);
void print(std::ostream& out, const MassProperties& value);
void print(std::ostream& out, const WorldSettings& value);
void print(std::ostream& out, BodyId value);
void print(std::ostream& out, ShapeId value);
void print(std::ostream& out, JointId value);
void print(std::ostream& out, const Joint& value);  // its kind
void print(std::ostream& out, const JointDef& value);

}  // namespace scree::determinism
