// Sweeps of the soft step that solve the normal impulses of a contact together; see
// simd/constraints/contact/contact_kernels.h.
#include <simd/constraints/contact/contact_passes.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void solve_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  solve_blocks<kPoints, kRich, kStatic, true>(args, chunk);
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void relax_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  relax_blocks<kPoints, kRich, kStatic, true, true>(args, chunk);
}

void solve_together(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(solve_chunk, args, chunk)
}
void relax_together(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(relax_chunk, args, chunk)
}

}  // namespace

void add_contact_together_kernels(ContactKernels& kernels);

void add_contact_together_kernels(ContactKernels& kernels) {
  kernels.solve_together = solve_together;
  kernels.relax_together = relax_together;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
