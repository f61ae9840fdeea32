// Soft constraints: the one place that makes their constants.
//
// A spring and a damper on a row of effective mass m, with stiffness k = m omega^2 and damping c = 2 m zeta
// omega, integrated implicitly over a substep h, change the row's impulse by
//
//   -(mass_scale m (speed + bias_rate error) + impulse_scale impulse)
//
// (Catto, "Soft Constraints", GDC 2011; as in Box2D 3 and in Jolt's SpringPart.) The mass cancels: hertz and
// damping ratio mean the same whatever hangs on the row.
#pragma once

namespace scree::simd {

// A number is a float, or a wide one of the kernels.
template <class Number>
struct BasicSoftness {
  Number bias_rate;  // 1/s
  Number mass_scale;
  Number impulse_scale;
};
using SoftConstants = BasicSoftness<float>;

// `hertz`: Hz, above 0. `damping_ratio`: 1 is critical. `substep`: s.
template <class Number>
inline BasicSoftness<Number> soften(Number hertz, Number damping_ratio, Number substep) {
  const Number one(1.0f), two(2.0f), whole_turn(6.28318531f);
  const Number omega = whole_turn * hertz;
  const Number a1 = two * damping_ratio + substep * omega;
  const Number a2 = substep * omega * a1;
  const Number a3 = one / (one + a2);
  return {omega / a1, a2 * a3, a3};
}

}  // namespace scree::simd
