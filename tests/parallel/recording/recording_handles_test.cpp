// Laws of handles and recordings: a recording does not store the world of its handles, and a player's world
// gets a number of its own.
#include <tests/parallel/recording/recording_fixture.h>

#include <algorithm>

namespace scree::test {
namespace {

struct Recorded {
  Bytes calls, states;  // joined over the chunks, which a clock divides
};

Recorded record() {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path());
  const JointId joint = heap.world.create_joint({.body_a = heap.bodies[3], .body_b = kWorld}, BallJoint{});
  heap.world.set_user_data(heap.bodies[4], 7);
  heap.world.set_filter(heap.shapes[4], {});
  heap.run(20);
  heap.world.destroy_joint(joint);
  heap.world.destroy_bodies(std::span(heap.bodies).last(2));
  heap.run(1);
  recorder.finish();
  Recorded recorded;
  for (const TakenApart::Chunk& chunk : TakenApart(file.bytes()).chunks) {
    Bytes& to = chunk.head.kind == ChunkKind::calls ? recorded.calls : recorded.states;
    to.insert(to.end(), chunk.content.begin(), chunk.content.end());
  }
  return recorded;
}

TEST(RecordedHandles, DoNotDependOnTheNumberOfEarlierWorlds) {
  const Recorded first = record();
  for (int i = 0; i < 100; ++i) World();
  const Recorded second = record();
  EXPECT_TRUE(first.calls == second.calls);
  EXPECT_TRUE(first.states == second.states);
  EXPECT_GT(first.calls.size(), 21 * kStepRecordBytes);
}

TEST(RecordedHandles, OfAPlayerStayValidAfterSeeksAndInBranches) {
  const TemporaryFile file;
  Heap heap;
  Recorder recorder(heap.world, file.path(), kOften);
  heap.run(40);
  recorder.finish();
  Player player(file.path());
  const BodyId body = player.world().body_at(heap.bodies[5].index);
  EXPECT_TRUE(player.world().is_alive(body));
  EXPECT_FALSE(player.world().is_alive(heap.bodies[5])) << "of the world that was recorded";
  player.seek(33, heap.workers);
  EXPECT_TRUE(player.world().is_alive(body));
  player.seek(2, heap.workers);
  EXPECT_TRUE(player.world().is_alive(body));
  EXPECT_TRUE(player.branch().is_alive(body));
}

}  // namespace
}  // namespace scree::test
