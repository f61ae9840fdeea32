// Truth: the formulas that the accuracy suite holds an engine to, in double precision.
//
// Each function names its source. tests/tools/accuracy_truth_test.cpp holds them to known values, to one
// another and to equations of motion that are integrated in small steps.
#pragma once

#include <vector>

namespace scree::accuracy {

inline constexpr double kPi = 3.14159265358979323846;

/// The complete elliptic integral of the first kind, of the parameter m = k^2 in [0, 1): pi / (2 AGM(1,
/// sqrt(1 - m))). Abramowitz and Stegun, Handbook of Mathematical Functions, 17.6.3.
double elliptic_k(double m);

/// s, the period of a pendulum that swings to `amplitude` (rad, below pi): 4 / omega K(sin^2(amplitude / 2)),
/// with omega (rad/s) the frequency of small swings. Landau and Lifshitz, Mechanics, section 11, problem 1.
double pendulum_period(double omega, double amplitude);

/// A heavy symmetric top on a fixed tip.
struct Top {
  double inertia_tip = 0.0;   ///< kg m^2, across the axis, about the tip
  double inertia_axis = 0.0;  ///< kg m^2, about the axis
  double torque = 0.0;        ///< N m, m g l
  double spin = 0.0;          ///< rad/s, of the angular velocity along the axis (constant)
};

/// rad/s, the slow steady precession at the inclination whose cosine is given: the smaller root of
/// I1 cos p^2 - I3 spin p + m g l = 0. Goldstein, Classical Mechanics, section 5.7.
double steady_precession(const Top& top, double cosine);

/// Nutation of a top whose axis is released at rest: between the start's inclination and a lower one, on
/// cusps.
struct Nutation {
  double lowest_cosine = 0.0;  ///< of the largest inclination
  double period = 0.0;         ///< s, from cusp to cusp
};
/// The roots of Goldstein's cubic f(u) (section 5.7; Klein and Sommerfeld, Theory of the Top, chapter IV):
/// one is the start, the others are those of b u^2 - a^2 u + a^2 u0 - b, with a = I3 spin / I1 and b = 2 m g
/// l / I1; the period is 4 K(m) / sqrt(b (u3 - u1)), m = (u0 - u1) / (u3 - u1).
Nutation nutation_from_rest(const Top& top, double start_cosine);

/// s, how long a free body turns about its middle axis before that component of its angular velocity changes
/// its sign: half the period of the elliptic functions. The inertia (kg m^2) is about the axes of the angular
/// velocity (rad/s), with middle between the other two. Landau and Lifshitz, Mechanics, section 37; Ashbaugh,
/// Chicone and Cushman, The twisting tennis racket, J. Dyn. Diff. Eq. 3 (1991) 67.
struct FreeBody {
  double inertia[3] = {1.0, 2.0, 3.0};  ///< ascending
  double velocity[3] = {0.0, 1.0, 0.0};
};
double flip_time(const FreeBody& body);

/// m/s^2, of the plate and of a ball on it (SimBenchmark, `rolling`): the plate slides on the ground under a
/// force, `balls` balls roll on it. A ball gets 2/7 of the plate's acceleration.
struct Rolling {
  double plate = 0.0;
  double ball = 0.0;
};
Rolling rolling_accelerations(double force, double plate_mass, double ball_mass, int balls,
                              double ground_friction, double gravity);

/// Falling dominoes, hinged at their front edges, without friction between them and without rebound: all that
/// have been hit lean on the next one. After van Leeuwen, The domino effect, Am. J. Phys. 78 (2010) 721,
/// without friction: energy is kept between the hits; in a hit the train shares its momentum with the next
/// one.
struct Dominoes {
  double height = 0.48;
  double thickness = 0.075;
  double spacing = 0.2;      ///< m, between faces
  double gravity = 9.81;     ///< m/s^2
  double first_speed = 1.0;  ///< rad/s, of the first one at its start
};
/// s, when each of `count` dominoes passes the inclination `angle` (rad, at most that at which it hits the
/// next one).
std::vector<double> domino_times(const Dominoes& dominoes, int count, double angle);
/// rad, at which a domino hits the next one.
double domino_hit_angle(const Dominoes& dominoes);

/// The semicircular arch of rigid voussoirs with radial joints that do not slip or crush: the thrusts with
/// which a line of thrust fits into the joints. Heyman, The Masonry Arch (1982); for very many voussoirs the
/// thinnest arch has thickness / radius 0.1075 (Milankovitch 1907; Makris and Alexakis, Arch. Appl. Mech.
/// 83 (2013) 1511).
struct ThrustRange {
  bool stands = false;
  double least = 0.0;  ///< horizontal thrust over the weight of the half arch
  double most = 0.0;
};
/// Of `voussoirs` (odd) equal blocks, with `thickness` over the mean radius.
ThrustRange arch_thrust(int voussoirs, double thickness);
/// The smallest thickness over the mean radius that stands.
double least_arch_thickness(int voussoirs);

}  // namespace scree::accuracy
