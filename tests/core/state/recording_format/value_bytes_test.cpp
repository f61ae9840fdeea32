// Laws of values as bytes: what is written is read back bit for bit, and what is no value is refused.
#include <core/geometry/hull/hull_build.h>
#include <core/state/recording_format/call_bytes.h>
#include <core/state/recording_format/value_bytes.h>
#include <tests/core/constraints/joint_samples.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace scree::test {
namespace {

using Bytes = std::vector<std::byte>;

// What the values of a test share: the hulls that they name by number.
struct Solids {
  SolidList list;

  template <class Value>
  Bytes bytes_of(const Value& value) {
    ByteWriter bytes;
    CallWriter writer(bytes, list);
    write_value(writer, value);
    return bytes.take();
  }
  // Reads one value, which must be all that the bytes hold.
  template <class Value>
  Value value_of(const Bytes& bytes) {
    CallReader reader(bytes, list.solids());
    Value value{};
    read_value(reader, value);
    EXPECT_EQ(reader.left(), 0u);
    return value;
  }
};

Hull tetrahedron(float size) {
  return Hull(std::vector<Vec3>{{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}});
}

TriangleMesh triangle(float size) {
  return TriangleMesh(std::vector<Vec3>{{0, 0, 0}, {size, 0, 0}, {0, size, 0}},
                      std::vector<MeshTriangle>{{0, 1, 2}});
}

// The members of values that cannot be compared by themselves. A new member does not compile until it is
// here.
auto members(const Sphere& sphere) { return std::tuple(sphere.radius); }
auto members(const Capsule& capsule) {
  const auto& [half_height, radius] = capsule;
  return std::tuple(half_height, radius);
}
auto members(const Box& box) {
  const auto& [half_extents, rounding] = box;
  return std::tuple(half_extents, rounding);
}
auto members(const Cylinder& cylinder) {
  const auto& [half_height, radius] = cylinder;
  return std::tuple(half_height, radius);
}
auto members(const Cone& cone) {
  const auto& [half_height, radius] = cone;
  return std::tuple(half_height, radius);
}
auto members(const MassProperties& properties) {
  const auto& [mass, center, inertia] = properties;
  return std::tuple(mass, center, std::to_array(inertia));
}
auto members(const BodyDef& def) {
  const auto& [type, position, rotation, linear_velocity, angular_velocity, linear_damping, angular_damping,
               gravity_factor, locks, mass, can_sleep, user_data] = def;
  return std::tuple(type, position, rotation, linear_velocity, angular_velocity, linear_damping,
                    angular_damping, gravity_factor, locks, mass, can_sleep, user_data);
}
auto members(const WorldSettings& settings) {
  const auto& [gravity, substeps, contact_hertz, contact_damping_ratio, push_speed, restitution_threshold,
               max_linear_speed, max_angular_speed, continuous, warm_start, sleeping, sleep_linear_speed,
               sleep_angular_speed, sleep_time, contact_events, hit_event_speed, contact_forces,
               measure_residual, measure_penetration, solver, solver_options] = settings;
  return std::tuple(gravity, substeps, contact_hertz, contact_damping_ratio, push_speed,
                    restitution_threshold, max_linear_speed, max_angular_speed, continuous, warm_start,
                    sleeping, sleep_linear_speed, sleep_angular_speed, sleep_time, contact_events,
                    hit_event_speed, contact_forces, measure_residual, measure_penetration, solver,
                    solver_options);
}

template <class Value>
bool same(const Value& a, const Value& b) {
  if constexpr (requires { members(a); }) {
    return members(a) == members(b);
  } else {
    return a == b;
  }
}
bool same(const HalfSpace&, const HalfSpace&) { return true; }
bool same(const Geometry& a, const Geometry& b) {
  if (a.index() != b.index()) return false;
  return std::visit(
      [&b](const auto& kind) { return same(kind, std::get<std::remove_cvref_t<decltype(kind)>>(b)); }, a);
}
bool same(const ShapeDef& a, const ShapeDef& b) {
  return same(a.geometry, b.geometry) && a.material == b.material && a.options == b.options;
}

const Pose kPose{{1.5f, -2.5f, 3.5f}, {0.5f, -0.5f, 0.5f, 0.5f}};
const Material kMaterial{.friction = 0.25f,
                         .restitution = 0.125f,
                         .rolling_resistance = 0.75f,
                         .density = 7.0f,
                         .patch_radius = 0.375f,
                         .surface_velocity = {4, 5, 6},
                         .friction_mix = MixRule::maximum,
                         .restitution_mix = MixRule::average};
const Filter kFilter{.category = 6, .mask = 0x80000001u, .group = -3};
const ShapeOptions kOptions{.local_pose = kPose,
                            .filter = kFilter,
                            .user_data = 0xfedcba9876543210u,
                            .contact_events = ContactEvents::persist,
                            .contact_hooks = ContactHooks::rule};
const MassProperties kMass{.mass = 2.0f, .center = {1, 2, 3}, .inertia = {4, 5, 6, 7, 8, 9}};
const BodyDef kBody{.type = BodyType::kinematic,
                    .position = {1, 2, 3},
                    .rotation = {0.5f, 0.5f, -0.5f, 0.5f},
                    .linear_velocity = {4, 5, 6},
                    .angular_velocity = {7, 8, 9},
                    .linear_damping = 10.0f,
                    .angular_damping = 11.0f,
                    .gravity_factor = 12.0f,
                    .locks = AxisLocks::rotation_z | AxisLocks::translation_x,
                    .mass = 13.0f,
                    .can_sleep = false,
                    .user_data = 0x0123456789abcdefu};
const WorldSettings kSettings{.gravity = {1, 2, 3},
                              .substeps = 5,
                              .contact_hertz = 6.0f,
                              .contact_damping_ratio = 7.0f,
                              .push_speed = 8.0f,
                              .restitution_threshold = 9.0f,
                              .max_linear_speed = 10.0f,
                              .max_angular_speed = 11.0f,
                              .continuous = false,
                              .warm_start = false,
                              .sleeping = false,
                              .sleep_linear_speed = 12.0f,
                              .sleep_angular_speed = 13.0f,
                              .sleep_time = 14.0f,
                              .contact_events = ContactEvents::all,
                              .hit_event_speed = 14.5f,
                              .contact_forces = true,
                              .measure_residual = true,
                              .measure_penetration = true,
                              .solver = Solver::direct,
                              .solver_options = {.iterations = 15,
                                                 .tolerance = 0.0625f,
                                                 .relaxation = 1.25f,
                                                 .baumgarte = 0.5f,
                                                 .slop = 0.03125f,
                                                 .shuffle_seed = 0xfedcba98u,
                                                 .points_together = true}};
const JointDef kJoint{.body_a = {5, 77},
                      .body_b = {6, 78},
                      .frame_a = kPose,
                      .frame_b = {{7, 8, 9}, {0, 0, 1, 0}},
                      .collide_connected = true,
                      .enabled = false,
                      .hertz = 10.0f,
                      .damping_ratio = 11.0f,
                      .break_force = 12.0f,
                      .break_torque = 13.0f,
                      .event_force = 14.0f,
                      .event_torque = 15.0f,
                      .user_data = 0x0011223344556677u};

std::vector<Geometry> geometries() {
  return {Sphere{1.5f},
          Capsule{2.5f, 3.5f},
          Box{{4, 5, 6}},
          ConvexHull{tetrahedron(1.0f), {2, 3, 4}},
          ConvexHull{tetrahedron(2.0f), {1, 1, 1}},
          HalfSpace{},
          Box{{4, 5, 6}, 0.25f},
          ConvexHull{tetrahedron(2.0f), {1, 1, 1}, 0.125f},
          Cylinder{6.5f, 7.5f},
          Cone{8.5f, 9.5f},
          triangle(1.0f),
          triangle(2.0f)};
}
std::vector<ShapeDef> shapes() {
  std::vector<ShapeDef> defs;
  for (const Geometry& geometry : geometries()) {
    defs.push_back({geometry, kMaterial, kOptions});
    defs.push_back({geometry, {}, {}});
  }
  return defs;
}

class ValueBytes : public testing::Test {
 protected:
  template <class Value>
  void expect_back(const Value& value) {
    const Bytes bytes = solids.bytes_of(value);
    const Value back = solids.value_of<Value>(bytes);
    EXPECT_TRUE(same(back, value));
    EXPECT_EQ(solids.bytes_of(back), bytes);
  }
  // Expects a refusal at `offset` for the reason, and none of `value`.
  template <class Value>
  void expect_refused(const Bytes& bytes, std::size_t offset, const std::string& reason) {
    try {
      static_cast<void>(solids.value_of<Value>(bytes));
    } catch (const RefusedBytes& refused) {
      EXPECT_EQ(refused.offset, offset);
      EXPECT_EQ(refused.reason, reason);
      return;
    }
    ADD_FAILURE() << "not refused: " << reason;
  }
  template <class Value>
  void expect_refused_at_every_length(const Value& value) {
    const Bytes bytes = solids.bytes_of(value);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      expect_refused<Value>(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)), length,
                            "the chunk ends too early");
    }
  }
  // Changes each byte of a value in turn. What makes it another value makes other bytes, so none of its
  // members is left out.
  template <class Value>
  void expect_all_of_it_written(const Value& value) {
    const Bytes bytes = solids.bytes_of(value);
    int others = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) {
      auto memory = std::bit_cast<std::array<std::byte, sizeof value>>(value);
      memory[i] ^= std::byte{1};  // valid for a bool, too
      const auto other = std::bit_cast<Value>(memory);
      if (same(other, value)) continue;  // padding
      ++others;
      EXPECT_NE(solids.bytes_of(other), bytes) << "byte " << i << " of " << sizeof value;
    }
    EXPECT_GE(static_cast<std::size_t>(others), bytes.size());
  }

  Solids solids;
};

TEST_F(ValueBytes, NumbersLieOneBehindTheOtherInLittleEndianOrder) {
  const auto hex = [](const Bytes& bytes) {
    std::string text;
    for (const std::byte byte : bytes) {
      text += "0123456789abcdef"[static_cast<unsigned>(byte) >> 4];
      text += "0123456789abcdef"[static_cast<unsigned>(byte) & 15];
    }
    return text;
  };
  EXPECT_EQ(hex(solids.bytes_of(Vec3{1, 2, -0.0f})), "0000803f0000004000000080");
  EXPECT_EQ(hex(solids.bytes_of(BodyId{0x01020304, 5, 99})), "0403020105000000");
  EXPECT_EQ(hex(solids.bytes_of(std::optional<float>{})), "00");
  EXPECT_EQ(hex(solids.bytes_of(std::optional<float>{1.0f})), "010000803f");
  EXPECT_EQ(hex(solids.bytes_of(Geometry{Capsule{1, 2}})), "010000803f00000040");
  EXPECT_EQ(hex(solids.bytes_of(Joint{GearJoint{2.0f}})), "0900000040");
  const std::vector<ShapeId> list{{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(hex(solids.bytes_of(std::span<const ShapeId>(list))),
            "02000000000000000100000002000000"
            "0400000005000000");
  const Bytes world_as_end = solids.bytes_of(JointDef{.body_a = kWorld, .body_b = {6, 78}});
  EXPECT_EQ(hex(Bytes(world_as_end.begin(), world_as_end.begin() + 16)), "0000000000000000060000004e000000");
}

TEST_F(ValueBytes, EveryValueIsReadAsItWasWritten) {
  for (const bool value : {false, true}) expect_back(value);
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic, BodyType::dynamic}) expect_back(type);
  for (const std::uint64_t number : {std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max()}) {
    expect_back(number);
  }
  for (const std::int32_t number : {-1, std::numeric_limits<std::int32_t>::min()}) expect_back(number);
  expect_back(Vec3{1, 2, 3});
  expect_back(Quat{1, 2, 3, 4});
  expect_back(kPose);
  expect_back(BodyId{5, 77});
  expect_back(ShapeId{6, 78});
  expect_back(JointId{7, 79});
  expect_back(std::optional<float>{});
  expect_back(std::optional<float>{2.5f});
  expect_back(kMass);
  expect_back(kFilter);
  expect_back(kMaterial);
  expect_back(Material{});
  expect_back(kOptions);
  expect_back(kSettings);
  expect_back(kBody);
  expect_back(BodyDef{});
  expect_back(kJoint);
  for (const Geometry& geometry : geometries()) expect_back(geometry);
  for (const ShapeDef& shape : shapes()) expect_back(shape);
  for (const Joint& joint : filled_joints()) expect_back(joint);
  for (const Joint& joint : plain_joints()) expect_back(joint);
}

TEST_F(ValueBytes, NoMemberIsLeftOut) {
  expect_all_of_it_written(kPose);
  expect_all_of_it_written(Sphere{2.0f});
  expect_all_of_it_written(Capsule{2.0f, 3.0f});
  expect_all_of_it_written(Box{{2, 3, 4}, 5.0f});
  expect_all_of_it_written(Cylinder{2.0f, 3.0f});
  expect_all_of_it_written(Cone{2.0f, 3.0f});
  expect_all_of_it_written(kMass);
  expect_all_of_it_written(kFilter);
  expect_all_of_it_written(kMaterial);
  expect_all_of_it_written(kOptions);
  expect_all_of_it_written(kSettings);
  expect_all_of_it_written(kBody);
  for (const Joint& joint : filled_joints()) {
    std::visit([this](const auto& kind) { expect_all_of_it_written(kind); }, joint);
  }
}

TEST_F(ValueBytes, FloatsKeepTheirBits) {
  for (const std::uint32_t bits : {0x00000000u, 0x80000000u, 0x00000001u, 0x807fffffu, 0x7f7fffffu,
                                   0x7f800000u, 0xff800000u, 0x7fc00001u, 0xffabcdefu}) {
    const auto number = std::bit_cast<float>(bits);
    const auto back = solids.value_of<Vec3>(solids.bytes_of(Vec3{0, number, 0}));
    EXPECT_EQ(std::bit_cast<std::uint32_t>(back.y), bits);
  }
}

TEST_F(ValueBytes, TheWorldIsAnEndOfAJointAndOtherwiseHandlesLoseTheirWorld) {
  for (const auto& [a, b] : {std::pair{kWorld, BodyId{6, 78}}, std::pair{BodyId{6, 78}, kWorld}}) {
    JointDef def = kJoint;
    def.body_a = a;
    def.body_b = b;
    expect_back(def);
  }
  EXPECT_EQ(solids.value_of<BodyId>(solids.bytes_of(BodyId{5, 77, 123})), (BodyId{5, 77, 0}));
  JointDef def = kJoint;
  def.body_a.world = 123;
  EXPECT_EQ(solids.value_of<JointDef>(solids.bytes_of(def)), kJoint);
}

TEST_F(ValueBytes, ListsOfAnyLengthAreReadAsTheyWereWritten) {
  const auto expect_list_back = [this]<class Value>(const std::vector<Value>& values) {
    for (std::size_t count = 0; count <= values.size(); ++count) {
      const Bytes bytes = solids.bytes_of(std::span<const Value>(values).first(count));
      const auto back = solids.value_of<std::vector<Value>>(bytes);
      ASSERT_EQ(back.size(), count);
      for (std::size_t i = 0; i < count; ++i) EXPECT_TRUE(same(back[i], values[i]));
    }
  };
  expect_list_back(std::vector<BodyId>{{1, 2}, {3, 4}, {5, 6}});
  expect_list_back(std::vector<BodyDef>{kBody, {}, kBody});
  expect_list_back(std::vector<JointDef>{kJoint, {.body_a = kWorld, .body_b = {1, 2}}});
  expect_list_back(filled_joints());
  expect_list_back(geometries());
  expect_list_back(shapes());
}

TEST_F(ValueBytes, WhatIsNoValueIsRefusedAtItsByte) {
  for (const unsigned wrong : {2u, 128u, 255u}) {
    const auto byte = static_cast<std::byte>(wrong);
    const std::string yes_or_no = "a yes or no is " + std::to_string(wrong);
    expect_refused<bool>({byte}, 0, yes_or_no);
    Bytes bytes = solids.bytes_of(std::optional<float>{1.0f});
    bytes[0] = byte;
    expect_refused<std::optional<float>>(bytes, 0, yes_or_no);
    bytes = solids.bytes_of(kJoint);
    const std::size_t collide_connected = 2 * 8 + 2 * 28;
    bytes[collide_connected] = byte;
    expect_refused<JointDef>(bytes, collide_connected, yes_or_no);
  }
  for (const std::size_t kind : {std::variant_size_v<Geometry>, std::size_t{255}}) {
    const std::string no_geometry = "there is no geometry of kind " + std::to_string(kind);
    Bytes bytes = solids.bytes_of(Geometry{Box{}});
    bytes[0] = static_cast<std::byte>(kind);
    expect_refused<Geometry>(bytes, 0, no_geometry);
    const std::vector<ShapeDef> two(2);
    bytes = solids.bytes_of(std::span(two));
    const std::size_t second = 8 + (bytes.size() - 8) / 2;
    bytes[second] = static_cast<std::byte>(kind);
    expect_refused<std::vector<ShapeDef>>(bytes, second, no_geometry);
  }
  for (const std::size_t kind : {std::size_t{kJointTypeCount}, std::size_t{255}}) {
    Bytes bytes = solids.bytes_of(Joint{MouseJoint{}});
    bytes[0] = static_cast<std::byte>(kind);
    expect_refused<Joint>(bytes, 0, "there is no joint of kind " + std::to_string(kind));
  }
}

TEST_F(ValueBytes, AHullThatIsNotKnownIsRefused) {
  Bytes bytes = solids.bytes_of(Geometry{ConvexHull{tetrahedron(1.0f), {1, 1, 1}}});
  ASSERT_EQ(solids.list.solids().hulls.size(), 1u);
  for (const std::int32_t number : {-1, 1, std::numeric_limits<std::int32_t>::min()}) {
    const auto wrong = std::bit_cast<std::array<std::byte, sizeof number>>(number);
    std::copy(wrong.begin(), wrong.end(), bytes.begin() + 1);
    expect_refused<Geometry>(bytes, 1, "there is no hull " + std::to_string(number) + " so far");
  }
}

TEST_F(ValueBytes, AMeshThatIsNotKnownIsRefused) {
  Bytes bytes = solids.bytes_of(Geometry{triangle(1.0f)});
  ASSERT_EQ(solids.list.solids().meshes.size(), 1u);
  for (const std::int32_t number : {-1, 1, std::numeric_limits<std::int32_t>::min()}) {
    const auto wrong = std::bit_cast<std::array<std::byte, sizeof number>>(number);
    std::copy(wrong.begin(), wrong.end(), bytes.begin() + 1);
    expect_refused<Geometry>(bytes, 1, "there is no mesh " + std::to_string(number) + " so far");
  }
}

TEST_F(ValueBytes, ThatEndTooEarlyAreRefusedAtTheirEnd) {
  expect_refused_at_every_length(kMass);
  expect_refused_at_every_length(kBody);
  expect_refused_at_every_length(kSettings);
  expect_refused_at_every_length(kJoint);
  for (const ShapeDef& shape : shapes()) expect_refused_at_every_length(shape);
  for (const Joint& joint : filled_joints()) expect_refused_at_every_length(joint);
}

TEST_F(ValueBytes, AListLongerThanWhatFollowsIsRefusedBeforeItTakesMemory) {
  const auto expect_limit = [this]<class Value>(const std::vector<Value>& shortest) {
    const Bytes bytes = solids.bytes_of(std::span<const Value>(shortest));
    ASSERT_EQ(bytes.size(), 8 + shortest.size() * LeastBytes<Value>::count());
    for (const std::uint64_t count : {std::uint64_t{shortest.size() + 1}, std::uint64_t{1} << 40,
                                      std::numeric_limits<std::uint64_t>::max()}) {
      const auto wrong = std::bit_cast<std::array<std::byte, sizeof count>>(count);
      // Behind another number, so that the place of the list shows.
      Bytes longer(5, std::byte{7});
      longer.insert(longer.end(), wrong.begin(), wrong.end());
      longer.insert(longer.end(), bytes.begin() + 8, bytes.end());
      CallReader reader(longer, solids.list.solids());
      reader.take_bytes(5);
      std::vector<Value> values;
      try {
        read_value(reader, values);
        ADD_FAILURE() << "not refused: " << count;
      } catch (const RefusedBytes& refused) {
        EXPECT_EQ(refused.offset, 5u);
        EXPECT_EQ(refused.reason, "a list is longer than what follows");
      }
      EXPECT_EQ(values.capacity(), 0u);
    }
  };
  expect_limit(std::vector<BodyId>(3));
  expect_limit(std::vector<BodyDef>(3));
  expect_limit(std::vector<JointDef>(3));
  expect_limit(std::vector<Geometry>(3, HalfSpace{}));
  expect_limit(std::vector<ShapeDef>(3, {HalfSpace{}}));
  expect_limit(std::vector<Joint>(3, GearJoint{}));
}

TEST_F(ValueBytes, TheLeastNumberOfBytesIsThatOfTheShortestValue) {
  const auto shortest = [this](const auto&... values) {
    return std::min({solids.bytes_of(values).size()...});
  };
  EXPECT_EQ(LeastBytes<BodyId>::count(), shortest(BodyId{5, 77}));
  EXPECT_EQ(LeastBytes<BodyDef>::count(), shortest(kBody, BodyDef{}));
  EXPECT_EQ(LeastBytes<JointDef>::count(), shortest(kJoint, JointDef{}));
  EXPECT_EQ(LeastBytes<Material>::count(), shortest(kMaterial, Material{}));
  EXPECT_EQ(LeastBytes<std::optional<float>>::count(), shortest(std::optional<float>{}, std::optional{1.0f}));
  const auto shortest_of = [this](const auto& values) {
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (const auto& value : values) least = std::min(least, solids.bytes_of(value).size());
    return least;
  };
  EXPECT_EQ(LeastBytes<Geometry>::count(), shortest_of(geometries()));
  EXPECT_EQ(LeastBytes<ShapeDef>::count(), shortest_of(shapes()));
  EXPECT_EQ(LeastBytes<Joint>::count(), shortest_of(plain_joints()));
  EXPECT_EQ(LeastBytes<Joint>::count(), shortest_of(filled_joints()));
}

}  // namespace
}  // namespace scree::test
