// libFuzzer's program for scene files. Its dictionary is scene.dict.
#include <tests/fuzz/memory_watch.h>

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  scree::fuzz::tell_memory_at_exit();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t bytes) {
  scree::fuzz::scene_target({data, bytes});
  return 0;
}
