// Laws of error codes: each kind of mistake has its own code in every call.
#include <tests/parallel/recording/recording_fixture.h>

#include <array>
#include <cstdlib>
#include <limits>
#include <optional>
#include <ostream>
#include <span>

namespace scree {

static void PrintTo(ErrorCode code, std::ostream* out) { *out << "code " << static_cast<int>(code); }

namespace test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Empty if the call does not throw.
template <class Work>
std::optional<ErrorCode> code_of(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_STRNE(error.what(), "");
    return error.code();
  }
  return {};
}

// A snapshot's or a recording's bytes with one number replaced.
Bytes changed(Bytes bytes, std::size_t at, std::uint32_t number) {
  std::memcpy(bytes.data() + at, &number, sizeof number);
  return bytes;
}

Bytes recorded_bytes() {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(20);
  recorder.finish();
  return file.bytes();
}

TEST(ErrorCodes, KeepTheirNumbers) {
  constexpr ErrorCode kAll[] = {
      ErrorCode::invalid_value,     ErrorCode::dead_handle,   ErrorCode::foreign_handle,
      ErrorCode::wrong_state,       ErrorCode::moved_from,    ErrorCode::too_many,
      ErrorCode::corrupt_data,      ErrorCode::wrong_version, ErrorCode::io_failure,
      ErrorCode::already_recording, ErrorCode::not_supported, ErrorCode::out_of_memory};
  int number = 0;
  for (const ErrorCode code : kAll) EXPECT_EQ(static_cast<int>(code), ++number);
}

TEST(ErrorCodes, SayThatAValueIsWrong) {
  Heap heap(1);
  World& world = heap.world;
  const BodyId body = heap.bodies.back();
  const ShapeId shape = heap.shapes.back();
  constexpr ErrorCode kCode = ErrorCode::invalid_value;
  EXPECT_EQ(code_of([] { World({.substeps = 0}); }), kCode);
  EXPECT_EQ(code_of([&] { world.create_body({.position = {kNan, 0, 0}}); }), kCode);
  EXPECT_EQ(code_of([&] { world.create_bodies({}, heap.bodies); }), kCode);
  EXPECT_EQ(code_of([&] { world.destroy_bodies(std::array{body, body}); }), kCode);
  EXPECT_EQ(code_of([&] { world.add_shape(body, Sphere{-1.0f}); }), kCode);
  EXPECT_EQ(code_of([&] { world.add_shapes(body, {}, heap.shapes); }), kCode);
  EXPECT_EQ(code_of([&] { world.set_material(shape, {.friction = -1.0f}); }), kCode);
  EXPECT_EQ(code_of([&] { world.set_pose(body, {{}, {0, 0, 0, 2}}); }), kCode);
  EXPECT_EQ(code_of([&] { world.set_body_type(body, static_cast<BodyType>(9)); }), kCode);
  EXPECT_EQ(code_of([&] { world.add_force(body, {1e29f, 0, 0}); }), kCode);
  EXPECT_EQ(code_of([&] { world.set_mass_properties(body, {.inertia = {1, 1, 9, 0, 0, 0}}); }), kCode);
  EXPECT_EQ(code_of([&] { world.set_kinematic_target(heap.bodies[1], {}, 0.0f); }), kCode);
  EXPECT_EQ(code_of([&] { world.create_joint({.body_a = body, .body_b = body}, BallJoint{}); }), kCode);
  EXPECT_EQ(code_of([&] { step(world, -1.0f, heap.workers); }), kCode);
  World* const null[] = {nullptr};
  EXPECT_EQ(code_of([&] { step(null, kDt, heap.workers); }), kCode);
  EXPECT_EQ(code_of([] { Hull(std::array<Vec3, 4>{}); }), kCode);
  EXPECT_EQ(code_of([] { wedge().face(99); }), kCode);
  EXPECT_EQ(code_of([] { Workers(-1); }), kCode);
  EXPECT_EQ(code_of([] { Workers({.isa = static_cast<Isa>(9)}); }), kCode);
  EXPECT_EQ(code_of([&] { Recorder(world, "no file", {.keyframe_spacing = 0}); }), kCode);
  Player player(recorded_bytes());
  EXPECT_EQ(code_of([&] { player.seek(21, heap.workers); }), kCode);
  EXPECT_EQ(code_of([&] { player.verify(2, 1, heap.workers); }), kCode);
  const JointId joint = world.create_joint({.body_a = heap.bodies[1], .body_b = body}, BallJoint{});
  EXPECT_EQ(code_of([&] { world.set_joint(joint, HingeJoint{}); }), kCode);
}

TEST(ErrorCodes, SayThatAHandleIsDead) {
  Heap heap(2);
  World& world = heap.world;
  const BodyId body = heap.bodies.back();
  const ShapeId shape = heap.shapes.back();
  const JointId joint = world.create_joint({.body_a = heap.bodies[2], .body_b = body}, BallJoint{});
  world.destroy_body(body);
  constexpr ErrorCode kCode = ErrorCode::dead_handle;
  EXPECT_EQ(code_of([&] { world.pose(body); }), kCode);
  EXPECT_EQ(code_of([&] { world.pose({}); }), kCode);
  EXPECT_EQ(code_of([&] { world.destroy_body(body); }), kCode);
  EXPECT_EQ(code_of([&] { world.destroy_bodies(std::array{heap.bodies[2], body}); }), kCode);
  EXPECT_EQ(code_of([&] { world.geometry(shape); }), kCode);
  EXPECT_EQ(code_of([&] { world.geometry({}); }), kCode);
  EXPECT_EQ(code_of([&] { world.joint(joint); }), kCode);
  EXPECT_EQ(code_of([&] { world.joint({}); }), kCode);
  EXPECT_EQ(code_of([&] { world.create_joint({.body_a = heap.bodies[2], .body_b = body}, BallJoint{}); }),
            kCode);
}

TEST(ErrorCodes, SayThatAHandleBelongsToAnotherWorld) {
  Heap heap(1), other(1);
  EXPECT_EQ(code_of([&] { heap.world.pose(other.bodies[0]); }), ErrorCode::foreign_handle);
  EXPECT_EQ(code_of([&] { heap.world.geometry(other.shapes[0]); }), ErrorCode::foreign_handle);
}

TEST(ErrorCodes, SayThatTheStateIsWrong) {
  Heap heap;
  World& world = heap.world;
  constexpr ErrorCode kCode = ErrorCode::wrong_state;
  EXPECT_EQ(code_of([&] { world.set_kinematic_target(heap.bodies.back(), {}, kDt); }), kCode);
  EXPECT_EQ(code_of([&] { world.contact_forces({}); }), kCode);
  EXPECT_EQ(code_of([&] { world.contact_forces_of(heap.bodies.back(), {}); }), kCode);
  Snapshot empty, first, second;
  SnapshotChanges changes;
  EXPECT_EQ(code_of([&] { restore(world, empty); }), kCode);
  EXPECT_EQ(code_of([&] { write_snapshot(empty); }), kCode);
  save(world, first);
  heap.run(1);
  save(world, second);
  EXPECT_EQ(code_of([&] { apply_changes(first, changes, second); }), kCode);
  EXPECT_EQ(code_of([&] { keep_changes(first, empty, changes); }), kCode);
  keep_changes(first, second, changes);
  Snapshot third;
  EXPECT_EQ(code_of([&] { apply_changes(second, changes, third); }), kCode);
  EXPECT_EQ(code_of([&] { apply_changes(first, changes, first); }), ErrorCode::invalid_value);
}

TEST(ErrorCodes, SayThatTheWorldWasMovedFrom) {
  Heap heap;
  const World other = std::move(heap.world);
  World& world = heap.world;  // NOLINT(bugprone-use-after-move): the law under test
  constexpr ErrorCode kCode = ErrorCode::moved_from;
  Snapshot snapshot;
  EXPECT_EQ(code_of([&] { world.create_body({}); }), kCode);
  EXPECT_EQ(code_of([&] { world.pose(heap.bodies[0]); }), kCode);
  EXPECT_EQ(code_of([&] { step(world, kDt, heap.workers); }), kCode);
  EXPECT_EQ(code_of([&] { save(world, snapshot); }), kCode);
  EXPECT_EQ(code_of([&] { clone(world); }), kCode);
  EXPECT_EQ(code_of([&] { Recorder(world, "no file"); }), kCode);
  save(other, snapshot);
  EXPECT_EQ(code_of([&] { restore(world, snapshot); }), kCode);
}

TEST(ErrorCodes, SayWhatIsWrongWithASnapshotsBytes) {
  Heap heap;
  heap.run(20);
  Snapshot snapshot;
  save(heap.world, snapshot);
  const Bytes bytes = write_snapshot(snapshot);
  const auto read = [](const Bytes& from) { return code_of([&] { read_snapshot(from); }); };
  EXPECT_EQ(read(bytes), std::nullopt);
  EXPECT_EQ(read({}), ErrorCode::corrupt_data);
  EXPECT_EQ(read(cut(bytes, bytes.size() - 1)), ErrorCode::corrupt_data);
  EXPECT_EQ(read(changed(bytes, 0, 1)), ErrorCode::corrupt_data);
  EXPECT_EQ(read(changed(bytes, bytes.size() - 4, 0x12345678)), ErrorCode::corrupt_data);
  EXPECT_EQ(read(changed(bytes, 8, 999)), ErrorCode::wrong_version);
  EXPECT_EQ(read(changed(bytes, 16, 999)), ErrorCode::wrong_version) << "other columns";
}

TEST(ErrorCodes, SayWhatIsWrongWithARecordingsBytes) {
  const Bytes bytes = recorded_bytes();
  const auto read = [](const Bytes& from) { return code_of([&] { Player player(from); }); };
  EXPECT_EQ(read(bytes), std::nullopt);
  EXPECT_EQ(read({}), ErrorCode::corrupt_data);
  EXPECT_EQ(read(cut(bytes, 100)), ErrorCode::corrupt_data);
  EXPECT_EQ(read(changed(bytes, 0, 1)), ErrorCode::corrupt_data);
  EXPECT_EQ(read(changed(bytes, 8, 999)), ErrorCode::wrong_version);
  TakenApart later(bytes);
  later.chunks.push_back({later.chunks.back().head, {}, 0});
  later.chunks.back().head.kind = static_cast<ChunkKind>(77);
  std::swap(later.chunks.back(), later.chunks[later.chunks.size() - 2]);  // the end stays behind
  EXPECT_EQ(read(later.put_together()), ErrorCode::wrong_version);
}

TEST(ErrorCodes, SayThatARecordedCallIsUnknown) {
  Heap heap;
  const TemporaryFile file;
  Recorder recorder(heap.world, file.path());
  heap.world.destroy_body(heap.bodies.back());
  heap.run(1);
  recorder.finish();
  TakenApart parts(file.bytes());
  Bytes& calls = parts.find(ChunkKind::calls)->content;
  calls[1] = std::byte{99};  // of the handle's index
  Player player(parts.put_together());
  EXPECT_EQ(code_of([&] { player.step(heap.workers); }), ErrorCode::corrupt_data);
}

TEST(ErrorCodes, SayThatAFileFails) {
  World world;
  constexpr ErrorCode kCode = ErrorCode::io_failure;
  EXPECT_EQ(code_of([&] { Recorder(world, "/no such folder/recording"); }), kCode);
  EXPECT_EQ(code_of([&] { Recorder(world, "/dev/full"); }), kCode);
  EXPECT_EQ(code_of([] { Player("/no such folder/recording"); }), kCode);
}

TEST(ErrorCodes, SayThatSomethingIsBeingRecorded) {
  World world, other;
  const TemporaryFile file, another;
  const Recorder recorder(world, file.path());
  EXPECT_EQ(code_of([&] { Recorder(world, another.path()); }), ErrorCode::already_recording);
  EXPECT_EQ(code_of([&] { Recorder(other, file.path()); }), ErrorCode::already_recording);
}

TEST(ErrorCodes, SayThatACountExceedsItsLimit) {
  // No list is that long: the count is checked before the span is read.
  World world;
  const BodyDef def;
  const std::size_t count = std::size_t{1} << 32;
  BodyId id;
  EXPECT_EQ(code_of([&] { world.create_bodies({&def, count}, {&id, count}); }), ErrorCode::too_many);
}

TEST(ErrorCodes, SayThatAnInstructionSetIsMissing) {
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    const std::optional<ErrorCode> code = code_of([isa] { Workers({.isa = isa}); });
    EXPECT_EQ(code, is_supported(isa) ? std::nullopt : std::optional(ErrorCode::not_supported));
  }
}

}  // namespace
}  // namespace test
}  // namespace scree
