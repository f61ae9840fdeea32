// See snapshot_solids.h.
#include <core/state/snapshot/snapshot_solids.h>

namespace scree {

SlotNumbers SolidList::numbers_of(const std::vector<SharedHull>& hulls,
                                  const std::vector<SharedMesh>& meshes) {
  SlotNumbers numbers;
  for (const SharedHull& hull : hulls) {
    numbers.hulls.push_back(number_of(HullAccess::solid(hull.geometry.hull)));
    numbers.hulls.push_back(number_of(hull.solid));
  }
  for (const SharedMesh& mesh : meshes) numbers.meshes.push_back(number_of(mesh.solid));
  return numbers;
}

}  // namespace scree
