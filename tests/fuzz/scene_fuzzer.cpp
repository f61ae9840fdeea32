// libFuzzer's program for scene files. Its dictionary is scene.dict.
#include <tests/fuzz/targets.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t bytes) {
  scree::fuzz::scene_target({data, bytes});
  return 0;
}
