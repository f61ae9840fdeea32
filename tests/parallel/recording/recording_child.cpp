// A process that records and steps forever, for a test that kills it: scree_recording_child FILE. It prints
// the number of steps after each of them.
#include <tests/parallel/recording/recording_fixture.h>

#include <chrono>
#include <cstdio>
#include <thread>

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: scree_recording_child FILE\n");
    return 2;
  }
  scree::test::Heap heap;
  scree::Recorder recorder(heap.world, arguments[1], {.flush_interval = 0.1f});
  for (;;) {
    heap.world.add_force(heap.bodies[3], {1, 0, 0});
    heap.run(1);
    std::printf("%llu\n", static_cast<unsigned long long>(recorder.steps()));
    std::fflush(stdout);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}
