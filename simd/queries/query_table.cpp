// The table of the kernels of queries.
#include <simd/queries/query_kernels.h>

#ifndef SCREE_SIMD_NAMESPACE
#error "compiled once per instruction set"
#endif

namespace scree::simd::SCREE_SIMD_NAMESPACE {

float cross_tree(const TreeView& tree, const CrossTask& task, float limit, AskShape ask, void* context);
float meet_tree(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context);
float approach_tree(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context);
float cross_mesh_by_ray(const MeshData& mesh, const MeshRayTask& task, float limit, AskShape ask,
                        void* context);
float cross_mesh(const MeshData& mesh, const CrossTask& task, float limit, AskShape ask, void* context);
float meet_mesh(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask, void* context);
float approach_mesh(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask, void* context);
int cut_hull(const HullData& hull, const HullStretch& stretch, std::int32_t* faces);

QueryKernels make_query_kernels() {
  return {cross_tree, meet_tree, approach_tree, cross_mesh_by_ray,
          cross_mesh, meet_mesh, approach_mesh, cut_hull};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
