// Sliders: hold the rotations together and anchor b on the x axis of frame a, and leave its offset along x,
// which is axis 0 of the parameters. Kernels: simd/constraints/joints/joint_slider.cpp.
#include <core/constraints/joints/joint_field_checks.h>
#include <core/constraints/joints/joint_fields.h>
#include <core/constraints/joints/joint_kinds.h>

namespace scree::joint_kinds {

void write(const SliderJoint& slider, JointParameters& to) { to.slider.offset = row_of(slider.offset); }

void read(const JointParameters& from, SliderJoint& slider) { slider.offset = axis_of(from.slider.offset); }

bool is_rich(const SliderJoint& slider) { return is_rich_axis(slider.offset); }

void renormalize(SliderJoint&) {}

void check(Call call, const SliderJoint& slider) { check_offset({call, "slider offset."}, slider.offset); }

void check_ends(Call, const SliderJoint&, JointBodies) {}

}  // namespace scree::joint_kinds
