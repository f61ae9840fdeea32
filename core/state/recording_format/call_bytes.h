// Calls as bytes: the number of the call, then its arguments; see value_bytes.h. A hull is the number that
// its solid has among those of the recording, and so is a mesh.
#pragma once

#include <core/state/recording_format/recorded_calls.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_solids.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace scree {

class CallWriter {
 public:
  CallWriter(ByteWriter& bytes, SolidList& solids) : bytes_(bytes), solids_(solids) {}
  template <class Number>
  void put(Number number) {
    bytes_.put(number);
  }
  void put_hull(const Hull& hull);
  void put_mesh(const TriangleMesh& mesh);

 private:
  ByteWriter& bytes_;
  SolidList& solids_;
};

class CallReader : public ByteReader {
 public:
  // Without solids all hulls and meshes are empty.
  CallReader(std::span<const std::byte> bytes, std::optional<SolidViews> solids)
      : ByteReader(bytes, "the chunk"), solids_(solids) {}
  Hull take_hull();
  TriangleMesh take_mesh();

 private:
  std::optional<SolidViews> solids_;
};

void write_call(const MadeCall& call, CallWriter& writer);
// Reads the arguments of a call and, if there is a world, makes it there. Throws RefusedBytes for what is no
// call, and what the world's call throws.
void take_call(RecordedCall call, CallReader& reader, World* world);

}  // namespace scree
