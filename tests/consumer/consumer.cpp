// Uses the library as an outside project does: public headers, one link target, errors caught across its
// border.
#include <scree/scree.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace {

int failures = 0;

void expect(bool condition, const char* law) {
  if (condition) return;
  std::printf("failed: %s\n", law);
  ++failures;
}

struct Drop {
  scree::World world;
  std::vector<scree::BodyId> boxes;
};

Drop make_drop() {
  Drop drop;
  const scree::BodyId ground =
      drop.world.create_body({.type = scree::BodyType::fixed, .position = {0, -1, 0}});
  drop.world.add_shape(ground, scree::Box{.half_extents = {20, 1, 20}});
  std::vector<scree::BodyDef> defs(8);
  const std::vector<scree::Geometry> shapes(defs.size(), scree::Box{});
  for (std::size_t i = 0; i < defs.size(); ++i) defs[i].position = {2.0f * static_cast<float>(i), 1, 0};
  drop.boxes.resize(defs.size());
  drop.world.create_bodies(defs, shapes, {}, {}, drop.boxes);
  return drop;
}

std::uint64_t hash_after_second(scree::Workers& workers) {
  Drop drop = make_drop();
  for (int i = 0; i < 60; ++i) scree::step(drop.world, 1.0f / 60.0f, workers);
  for (const scree::BodyId box : drop.boxes) {
    expect(std::abs(drop.world.pose(box).position.y - 0.5f) < 0.01f, "a dropped box lies on the ground");
  }
  expect(drop.world.stats().step == 60, "every step is counted");
  return drop.world.hash();
}

// Containers that cross the library's border, in both directions.
void expect_snapshots_and_recordings_to_cross(scree::Workers& workers, const std::string& file) {
  Drop drop = make_drop();
  scree::Recorder recorder(drop.world, file, {.keyframe_spacing = 10});
  for (int i = 0; i < 30; ++i) scree::step(drop.world, 1.0f / 60.0f, workers);
  recorder.finish();
  scree::Snapshot snapshot;
  scree::save(drop.world, snapshot);
  const std::vector<std::byte> bytes = scree::write_snapshot(snapshot);
  scree::World restored;
  scree::restore(restored, scree::read_snapshot(bytes));
  expect(restored.hash() == drop.world.hash(), "a snapshot crosses as bytes");
  scree::Player player(file);
  std::vector<std::uint64_t> keyframes;
  for (const std::uint64_t step : player.keyframe_steps()) keyframes.push_back(step);
  expect(keyframes == std::vector<std::uint64_t>{0, 10, 20, 30}, "a recording says where its keyframes are");
  const scree::RecordingInfo info = player.info();
  expect(info.finished && info.last_step == 30 && info.writer.rfind("Scree ", 0) == 0,
         "a recording says what it is");
  expect(!player.verify(0, 30, workers), "a recording plays to the same bits");
  expect(player.world().hash() == drop.world.hash(), "a recording ends where its world did");
  scree::Player other(file);
  expect(!scree::compare(player, other, workers), "a recording is like itself");
  expect(scree::first_difference(drop.world, player.world()).empty(),
         "worlds of the same state do not differ");
  std::remove(file.c_str());
}

}  // namespace

int main(int, char** arguments) {
  scree::Workers one(1);
  scree::Workers three(scree::WorkersOptions{.threads = 3, .isa = scree::Isa::scalar});
  expect(one.threads() == 1, "Workers have the threads that were asked for");
  expect(three.isa() == scree::Isa::scalar, "Workers have the instruction set that was asked for");
  const std::uint64_t hash = hash_after_second(one);
  expect(hash == hash_after_second(three), "threads and instruction set do not change bits");
  std::printf("hash %016llx\n", static_cast<unsigned long long>(hash));
  expect_snapshots_and_recordings_to_cross(one, std::string(arguments[0]) + ".scree");
  scree::World world;
  bool caught = false;
  try {
    world.pose(scree::BodyId{12345, 1});
  } catch (const scree::Error&) {
    caught = true;
  }
  expect(caught, "a foreign handle throws scree::Error");
  // Needs Qhull behind the library.
  std::vector<scree::Vec3> points;
  for (int i = 0; i < 1000; ++i) {
    points.push_back(
        {static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100)});
  }
  const scree::Hull hull(points);
  expect(hull.vertices().size() == 8 && hull.face_count() == 6, "the hull of a lattice is a box");
  const scree::ShapeId shape = world.add_shape(world.create_body({}), scree::ConvexHull{hull, {1, 2, 3}});
  expect(std::get<scree::ConvexHull>(world.geometry(shape)).hull == hull, "a hull comes back from its shape");
  const float heights[4] = {0, 0, 0, 1};
  const scree::TriangleMesh land = scree::height_field_mesh({.columns = 2, .rows = 2, .heights = heights});
  expect(land.triangle_count() == 2, "a cell of a height field has two triangles");
  const scree::Pose quarter{{1, 0, 0}, scree::from_axis_angle({0, 0, 1}, 1.5707963f)};
  expect(scree::distance(scree::transform(quarter, {1, 0, 0}), {1, 1, 0}) < 1e-6f, "a quarter turn is one");
  static_assert(scree::Vec3{1, 2, 3} + 2.0f * scree::cross({1, 0, 0}, {0, 1, 0}) == scree::Vec3{1, 2, 5});
  scree::World moved = std::move(world);
  expect(moved.body_count() == 1, "worlds can be moved");
  return failures == 0 ? 0 : 1;
}
