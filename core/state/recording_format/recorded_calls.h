// The calls of World that change it, in one table: what a recording numbers, writes, reads and makes again.
//
// A call's number in a recording is its place here, so new calls come at the end. Calls that change something
// hold a CallRecord.
#pragma once

#include <core/state/recording_format/call_sink.h>
#include <core/world/world_data.h>
#include <scree/world.h>

#include <cstdint>
#include <exception>
#include <span>
#include <tuple>
#include <type_traits>

namespace scree {

// Name in recordings, function of World, types of its arguments except lists of ids that it fills in.
#define SCREE_RECORDED_CALLS(X)                                                                              \
  X(create_body, create_body, BodyDef)                                                                       \
  X(create_bodies, create_bodies, std::span<const BodyDef>)                                                  \
  X(create_bodies_with_shapes, create_bodies, std::span<const BodyDef>, std::span<const Geometry>, Material, \
    ShapeOptions)                                                                                            \
  X(destroy_body, destroy_body, BodyId)                                                                      \
  X(destroy_bodies, destroy_bodies, std::span<const BodyId>)                                                 \
  X(set_body_type, set_body_type, BodyId, BodyType)                                                          \
  X(set_pose, set_pose, BodyId, Pose)                                                                        \
  X(set_linear_velocity, set_linear_velocity, BodyId, Vec3)                                                  \
  X(set_angular_velocity, set_angular_velocity, BodyId, Vec3)                                                \
  X(set_kinematic_target, set_kinematic_target, BodyId, Pose, float)                                         \
  X(set_mass_properties, set_mass_properties, BodyId, MassProperties)                                        \
  X(reset_mass, reset_mass, BodyId)                                                                          \
  X(set_linear_damping, set_linear_damping, BodyId, float)                                                   \
  X(set_angular_damping, set_angular_damping, BodyId, float)                                                 \
  X(set_gravity_factor, set_gravity_factor, BodyId, float)                                                   \
  X(set_locks, set_locks, BodyId, AxisLocks)                                                                 \
  X(set_can_sleep, set_can_sleep, BodyId, bool)                                                              \
  X(set_full_sweep, set_full_sweep, BodyId, bool)                                                            \
  X(wake, wake, BodyId)                                                                                      \
  X(set_body_user_data, set_user_data, BodyId, std::uint64_t)                                                \
  X(add_force, add_force, BodyId, Vec3)                                                                      \
  X(add_force_at, add_force_at, BodyId, Vec3, Vec3)                                                          \
  X(add_torque, add_torque, BodyId, Vec3)                                                                    \
  X(add_impulse, add_impulse, BodyId, Vec3)                                                                  \
  X(add_impulse_at, add_impulse_at, BodyId, Vec3, Vec3)                                                      \
  X(add_angular_impulse, add_angular_impulse, BodyId, Vec3)                                                  \
  X(add_shape, add_shape, BodyId, Geometry, Material, ShapeOptions)                                          \
  X(destroy_shape, destroy_shape, ShapeId)                                                                   \
  X(set_geometry, set_geometry, ShapeId, Geometry)                                                           \
  X(set_material, set_material, ShapeId, Material)                                                           \
  X(set_filter, set_filter, ShapeId, Filter)                                                                 \
  X(set_contact_events, set_contact_events, ShapeId, ContactEvents)                                          \
  X(set_local_pose, set_local_pose, ShapeId, Pose)                                                           \
  X(set_shape_user_data, set_user_data, ShapeId, std::uint64_t)                                              \
  X(set_settings, set_settings, WorldSettings)                                                               \
  X(create_joint, create_joint, JointDef, Joint)                                                             \
  X(create_joints, create_joints, std::span<const JointDef>, std::span<const Joint>)                         \
  X(destroy_joint, destroy_joint, JointId)                                                                   \
  X(set_joint, set_joint, JointId, Joint)                                                                    \
  X(set_joint_frames, set_joint_frames, JointId, Pose, Pose)                                                 \
  X(set_joint_stiffness, set_joint_stiffness, JointId, float, float)                                         \
  X(set_joint_strength, set_joint_strength, JointId, float, float)                                           \
  X(set_joint_enabled, set_joint_enabled, JointId, bool)                                                     \
  X(set_collide_connected, set_collide_connected, JointId, bool)                                             \
  X(set_joint_user_data, set_user_data, JointId, std::uint64_t)                                              \
  X(add_shapes, add_shapes, BodyId, std::span<const ShapeDef>)                                               \
  X(set_user_rows, set_user_rows, JointId, std::span<const UserRow>)                                         \
  X(refresh_user_rows, refresh_user_rows, std::span<const JointId>, std::span<const UserRow>)                \
  X(set_contact_hooks, set_contact_hooks, ShapeId, ContactHooks)                                             \
  X(answer_contact_hooks, answer_contact_hooks, std::span<const ContactAnswer>)                              \
  X(set_joint_event_thresholds, set_joint_event_thresholds, JointId, float, float)

#define SCREE_NAME_CALL(call, function, ...) call,
// 0 stands for a step.
enum class RecordedCall : std::uint8_t { step, SCREE_RECORDED_CALLS(SCREE_NAME_CALL) count };
#undef SCREE_NAME_CALL

const char* name_of(RecordedCall call);

// The types of a call's arguments, as a tuple.
template <RecordedCall kCall>
struct CallArguments;
#define SCREE_DECLARE_ARGUMENTS(call, function, ...) \
  template <>                                        \
  struct CallArguments<RecordedCall::call> {         \
    using Types = std::tuple<__VA_ARGS__>;           \
  };
SCREE_RECORDED_CALLS(SCREE_DECLARE_ARGUMENTS)
#undef SCREE_DECLARE_ARGUMENTS

// `arguments` is a tuple of references to them.
template <RecordedCall kCall>
void write_arguments(const void* arguments, CallWriter& writer);

// Marks what a call names: it may write to it. The handle has not been checked yet and may name nothing.
template <class Store>
void mark_index(Store& store, std::uint32_t index) {
  if (index < store.flags.size()) store.marks.mark(static_cast<std::int32_t>(index));
}
inline void mark_named(WorldData& data, BodyId body) { mark_index(data.bodies, body.index); }
inline void mark_named(WorldData& data, ShapeId shape) { mark_index(data.shapes, shape.index); }
inline void mark_named(WorldData& data, JointId joint) { mark_index(data.joints, joint.index); }
template <class Other>
void mark_named(WorldData&, const Other&) {}

// Tells the world's sink, if it has one, when the call that holds this returns; a call that throws has
// changed nothing and is not recorded.
template <RecordedCall kCall, class Types = typename CallArguments<kCall>::Types>
class CallRecord;

template <RecordedCall kCall, class... Arguments>
class CallRecord<kCall, std::tuple<Arguments...>> {
 public:
  template <class... Given>
  explicit CallRecord(WorldData& data, const Given&... given)
      : sink_(data.recording.sink), arguments_(given...) {
    static_assert((std::is_same_v<Given, Arguments> && ...),
                  "a converted argument would not live long enough");
    (mark_named(data, given), ...);
    if (sink_ != nullptr) exceptions_ = std::uncaught_exceptions();
  }
  ~CallRecord() {
    if (sink_ == nullptr || std::uncaught_exceptions() > exceptions_) return;
    sink_->called({kCall, &arguments_, &write_arguments<kCall>});
  }
  CallRecord(const CallRecord&) = delete;
  CallRecord& operator=(const CallRecord&) = delete;

 private:
  CallSink* sink_;
  std::tuple<const Arguments&...> arguments_;
  int exceptions_ = 0;
};

}  // namespace scree
