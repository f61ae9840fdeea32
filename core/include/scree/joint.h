// Joints: what holds two bodies together, or drives one against the other.
//
// A joint has a frame in each of its bodies: an anchor (the frame's position) and axes. All that is said
// about a joint is said about frame b as seen from frame a: the offset of the anchors along the axes of frame
// a, and the rotation that takes the axes of frame a to those of frame b. The x axis is the main one: hinges
// turn about it, sliders slide along it, cones open and shafts spin about it.
//
// What a joint holds it holds as stiffly as the step allows, or as softly as JointDef::hertz asks. The step
// allows less the more joints a body has and the heavier what they hold is against it. What a joint leaves
// free may have a limit and a drive, see JointAxis.
#pragma once

#include <scree/ids.h>
#include <scree/joint_type.h>
#include <scree/math_types.h>
#include <scree/user_joint.h>

#include <cstdint>
#include <limits>
#include <variant>

namespace scree {

/// An infinite limit or force.
inline constexpr float kNoLimit = std::numeric_limits<float>::infinity();

/// What moves a free axis of a joint.
enum class Drive : std::uint8_t {
  none,   ///< nothing moves the axis
  motor,  ///< brings the axis to `speed` with at most `max_force`; with speed 0 it is dry friction
  /// Pulls the axis to `target` with at most `max_force`. The target is where the step begins and moves at
  /// `speed` while it lasts: to follow a trajectory, set both before each step.
  spring,
};

/// One coordinate of a joint, along an axis (m) or about one (rad): its limits and its drive. Values are
/// within +-1e6, limits of angles within +-pi; limits and forces may be infinite.
struct JointAxis {
  float lower = -kNoLimit;     ///< m or rad; at most `upper`. Equal limits hold the axis where they say.
  float upper = kNoLimit;      ///< m or rad
  Drive drive = Drive::none;   ///< what moves the axis
  float target = 0.0f;         ///< m or rad, of the spring
  float speed = 0.0f;          ///< m/s or rad/s
  float hertz = 1.0f;          ///< Hz, of the spring, in [1e-3, 1e4]; at most 1/(4 substep) is used
  float damping_ratio = 1.0f;  ///< of the spring, in [0, 1e4]; 1 is critical
  float max_force = kNoLimit;  ///< N or N m, of the drive, at least 0

  friend bool operator==(const JointAxis&, const JointAxis&) = default;
};

/// Drives a relative rotation.
struct RotationDrive {
  Drive drive = Drive::none;  ///< none, a motor with `velocity`, or a spring to `target`
  Quat target{};              ///< rotation of frame b in frame a; unit length within 1e-3 (renormalized)
  Vec3 velocity{};     ///< rad/s, of frame b against frame a, in the axes of frame a; each within +-1e6
  float hertz = 1.0f;  ///< as in JointAxis
  float damping_ratio = 1.0f;   ///< as in JointAxis
  float max_torque = kNoLimit;  ///< N m, at least 0

  friend bool operator==(const RotationDrive&, const RotationDrive&) = default;
};

/// Ball and socket: holds the anchors together.
struct BallJoint {
  /// rad, in [0, pi]: the x axes of the frames enclose at most this angle.
  float cone_limit = kNoLimit;
  /// rad, within +-pi, lower at most upper: turn of frame b about its x axis, once the shortest turn that
  /// brings the x axes together is taken away.
  float twist_lower = -kNoLimit;
  float twist_upper = kNoLimit;  ///< rad, as twist_lower
  RotationDrive drive{};         ///< drives the rotation of frame b in frame a

  friend bool operator==(const BallJoint&, const BallJoint&) = default;
};

/// Holds the anchors and the x axes together. The axis is the angle about x, in (-pi, pi]; limits that are
/// not infinite lie within +-pi, a spring takes the shorter way.
struct HingeJoint {
  JointAxis angle{};  ///< about the x axis, rad

  friend bool operator==(const HingeJoint&, const HingeJoint&) = default;
};

/// Holds the rotations together and anchor b on the x axis of frame a.
struct SliderJoint {
  JointAxis offset{};  ///< of anchor b along the x axis of frame a, m

  friend bool operator==(const SliderJoint&, const SliderJoint&) = default;
};

/// Limits or drives the distance of the anchors: a rod where both limits are equal, a rope with an upper one
/// alone, a spring with a drive.
struct DistanceJoint {
  JointAxis length{.lower = 0.0f};  ///< m, neither finite limits nor the target below 0

  friend bool operator==(const DistanceJoint&, const DistanceJoint&) = default;
};

/// Holds the frames together. JointDef::hertz softens the anchors' offset, `angular_hertz` the rotation.
struct WeldJoint {
  float angular_hertz = 0.0f;          ///< Hz, in [1e-3, 1e4], or 0: as stiff as the step allows
  float angular_damping_ratio = 1.0f;  ///< of the rotation, in [0, 1e4]; 1 is critical

  friend bool operator==(const WeldJoint&, const WeldJoint&) = default;
};

/// Each of the six coordinates free, limited, held (equal limits), driven or sprung. Offsets are those of
/// anchor b along the axes of frame a; the angles are the components of the rotation vector of frame b in
/// frame a (its axis times its angle, at most pi in length).
struct SixDegreeJoint {
  JointAxis offset[3]{};  ///< m
  JointAxis angle[3]{};   ///< rad

  friend bool operator==(const SixDegreeJoint&, const SixDegreeJoint&) = default;
};

/// A wheel, body b, on a chassis, body a. The suspension goes along the x axis of frame a, steering turns
/// about it; the wheel spins about the z axis of frame b, which stays square to the suspension. The hertz of
/// the suspension's spring are those at which body a bounces on it over a wheel that stands.
struct WheelJoint {
  JointAxis suspension{.drive = Drive::spring, .hertz = 2.0f, .damping_ratio = 0.7f};  ///< m
  JointAxis steering{.lower = 0.0f, .upper = 0.0f};  ///< limits within +-pi/2; held straight unless set
  JointAxis spin{};                                  ///< rad/s only: a motor or nothing, no limits

  friend bool operator==(const WheelJoint&, const WheelJoint&) = default;
};

/// Cardan joint: holds the anchors together and the x axis of frame a square to the y axis of frame b.
struct UniversalJoint {
  JointAxis first{};   ///< about the x axis of frame a, rad
  JointAxis second{};  ///< about the y axis of frame b, rad

  friend bool operator==(const UniversalJoint&, const UniversalJoint&) = default;
};

/// Holds anchor b in the plane of the y and z axes of frame a, and the x axes together.
struct PlanarJoint {
  JointAxis offset_y{};  ///< m
  JointAxis offset_z{};  ///< m
  JointAxis angle{};     ///< about x, rad

  friend bool operator==(const PlanarJoint&, const PlanarJoint&) = default;
};

/// Ties the turns of two bodies, each about the x axis of its frame: (turn of a) + ratio (turn of b) stays
/// as it was when the joint was made, over any number of turns. The bodies need hinges of their own. Motion
/// that continuous collision takes back at the end of a step counts, as if it had been made.
struct GearJoint {
  float ratio = 1.0f;  ///< within +-1e3, at least 1e-3 in size

  friend bool operator==(const GearJoint&, const GearJoint&) = default;
};

/// Ties the turn of body a, the pinion, about the x axis of its frame to the way of body b, the rack, along
/// the x axis of its frame: way - radius * turn stays as it was. The way is that of anchor b against anchor
/// a. The bodies need a hinge and a slider of their own.
struct RackAndPinionJoint {
  float radius = 1.0f;  ///< m a radian, within +-1e3, at least 1e-3 in size

  friend bool operator==(const RackAndPinionJoint&, const RackAndPinionJoint&) = default;
};

/// A rope over two points of the world: (distance of anchor a from `point_a`) + ratio (distance of anchor b
/// from `point_b`) is at most `length`; exactly that with `rigid`.
struct PulleyJoint {
  Vec3 point_a{};       ///< m, in world coordinates, each within +-1e7
  Vec3 point_b{};       ///< m, in world coordinates, each within +-1e7
  float ratio = 1.0f;   ///< in [1e-3, 1e3]
  float length = 1.0f;  ///< m, in [0, 1e6]
  bool rigid = false;   ///< true: the rope also pushes

  friend bool operator==(const PulleyJoint&, const PulleyJoint&) = default;
};

/// Drives frame b to a pose in frame a with bounded force and torque. The hertz of the offset are those of
/// the bodies' masses alone, wherever the anchors are.
struct MotorJoint {
  RotationDrive rotation{.drive = Drive::spring};  ///< of frame b in frame a
  Drive drive = Drive::spring;                     ///< of the anchors' offset
  Vec3 target{};               ///< m, of anchor b along the axes of frame a; each within +-1e6
  Vec3 velocity{};             ///< m/s, in the axes of frame a; each within +-1e6
  float hertz = 1.0f;          ///< Hz, of the offset's spring, as in JointAxis
  float damping_ratio = 1.0f;  ///< of the offset's spring, as in JointAxis
  float max_force = kNoLimit;  ///< N

  friend bool operator==(const MotorJoint&, const MotorJoint&) = default;
};

/// Drags the anchor of body b to a moving point of the world. Body a must be the world. The hertz are those
/// of the body's mass alone.
struct MouseJoint {
  Vec3 target{};               ///< m, in world coordinates, each within +-1e7
  float hertz = 5.0f;          ///< Hz, in [1e-3, 1e4]; at most 1/(4 substep) is used
  float damping_ratio = 0.7f;  ///< of the spring, in [0, 1e4]; 1 is critical
  float max_force = kNoLimit;  ///< N

  friend bool operator==(const MouseJoint&, const MouseJoint&) = default;
};

namespace detail {
template <class Nothing, class... Kinds>
struct OneOf {
  using Type = std::variant<Kinds...>;
};
}  // namespace detail

#define SCREE_JOINT_TYPE(kind, Struct) , Struct
/// What a joint holds, limits and drives: std::variant<BallJoint, HingeJoint, ...>, in the order of
/// JointType.
using Joint = detail::OneOf<void SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)>::Type;
#undef SCREE_JOINT_TYPE
static_assert(std::variant_size_v<Joint> == kJointTypeCount);

/// What a joint has whatever its kind. Both ends must be set: to two bodies, or one of them to kWorld.
struct JointDef {
  BodyId body_a{};  ///< the first end: a body or kWorld
  BodyId body_b{};  ///< the second end: a body or kWorld
  /// In the frame of body a; position within +-1e5 m (+-1e7 m in the world), rotation of unit length within
  /// 1e-3 (renormalized).
  Pose frame_a{};
  Pose frame_b{};                  ///< in the frame of body b
  bool collide_connected = false;  ///< shapes of the two bodies collide with each other
  bool enabled = true;             ///< false: the joint does nothing
  /// Hz, stiffness of what is held and of limits, in [1e-3, 1e4], or 0: as the step allows.
  float hertz = 0.0f;
  float damping_ratio = 1.0f;  ///< in [0, 1e4], where hertz is not 0
  /// N, N m: a joint whose reaction in a substep is above is disabled, see World::broken_joints. Above 0.
  float break_force = kNoLimit;
  float break_torque = kNoLimit;  ///< N m, as break_force
  /// N, N m: World::joint_events lists the joint after each step in a substep of which its reaction was above
  /// one of them. At least 0; infinite thresholds cost nothing.
  float event_force = kNoLimit;
  float event_torque = kNoLimit;  ///< N m, as event_force
  std::uint64_t user_data = 0;    ///< any number of the caller's; the library never reads it

  friend bool operator==(const JointDef&, const JointDef&) = default;
};

/// What a joint did to body b in the last substep of the last step. Body a got the opposite, except from
/// gears, racks and pulleys: these act on each body along or about an axis of its own.
struct JointReaction {
  Vec3 force{};   ///< N, at anchor b, in world axes
  Vec3 torque{};  ///< N m, about anchor b, in world axes

  friend bool operator==(const JointReaction&, const JointReaction&) = default;
};

}  // namespace scree
