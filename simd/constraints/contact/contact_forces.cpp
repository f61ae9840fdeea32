// Impulses of a whole step, from lanes to contact rows; see simd/constraints/contact/contact_forces.h.
#include <simd/constraints/contact/contact_forces.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void store_forces_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  constexpr int kStride = sizeof(ContactForceRow) / sizeof(float);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    const float* const lanes = force_lanes(args, first_lane);
    F impulse[kForceFields];
    F differences(0.0f);  // the sum of x - x, as in is_finite
    for (int field = 0; field < kForceFields; ++field) {
      const bool acts = field < kPoints || (field >= kFrictionField && (kRich || field < kRollingField));
      impulse[field] = acts ? load_unaligned(lanes + field * kLanes) : F(0.0f);
      differences += impulse[field] - impulse[field];
    }
    // Impulses that made bodies non-finite are not reported.
    const M finite = differences == F(0.0f);
    for (F& value : impulse) value = select(finite, value, F(0.0f));
    const std::int32_t* contact = args.rows + first_lane;
    V3 position;
    F pad;
    load_rows(args.pose->position, sizeof(PoseRow) / sizeof(float), block.row_b, position.x, position.y,
              position.z, pad);
    const V3 center = position + load3(block.arm_b);
    float* const base = args.forces->normal_impulse;
    store_rows(base, kStride, contact, count, impulse[0], impulse[1], impulse[2], impulse[3]);
    store_rows(base + 4, kStride, contact, count, impulse[kFrictionField], impulse[kFrictionField + 1],
               impulse[kTwistField], F(1.0f));
    store_rows(base + 8, kStride, contact, count, impulse[kRollingField], impulse[kRollingField + 1],
               impulse[kRollingField + 2], F(0.0f));
    store_rows(base + 12, kStride, contact, count, center.x, center.y, center.z, F(0.0f));
  });
}

void store_forces(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(store_forces_chunk, args, chunk)
}

}  // namespace

void add_contact_force_kernels(ContactKernels& kernels);

void add_contact_force_kernels(ContactKernels& kernels) { kernels.store_forces = store_forces; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
