// The table of the broad phase's kernels: bounds from pair_bounds.cpp, trees and joins from pair_join.cpp.
#include <simd/broad_phase/pair_kernels.h>

#ifndef SCREE_SIMD_NAMESPACE
#error "compiled once per instruction set"
#endif

namespace scree::simd::SCREE_SIMD_NAMESPACE {

int update_bounds(const BoundsTask& task, int begin, int end);
void refit_leaves(const RefitTask& task, int begin, int end);
void refit_nodes(const NodeBlock* children, NodeBlock* parents, int begin, int end);
void join(const JoinTask& task, int end, JoinState& state);
void rank_rows(const RankTask& task);

PairKernels make_pair_kernels() { return {update_bounds, refit_leaves, refit_nodes, join, rank_rows}; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
