// Truth: closed formulas first, then the two that need a search.
#include <tools/accuracy/truth.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace scree::accuracy {

double elliptic_k(double m) {
  double a = 1.0;
  double b = std::sqrt(1.0 - m);
  for (int i = 0; i < 40 && std::abs(a - b) > 1e-16 * a; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 0.5 * kPi / a;
}

double pendulum_period(double omega, double amplitude) {
  const double modulus = std::sin(0.5 * amplitude);
  return 4.0 / omega * elliptic_k(modulus * modulus);
}

double steady_precession(const Top& top, double cosine) {
  const double momentum = top.inertia_axis * top.spin;
  const double root = std::sqrt(momentum * momentum - 4.0 * top.inertia_tip * top.torque * cosine);
  return 2.0 * top.torque / (momentum + root);  // the smaller root, without cancellation
}

Nutation nutation_from_rest(const Top& top, double start_cosine) {
  const double a = top.inertia_axis * top.spin / top.inertia_tip;
  const double b = 2.0 * top.torque / top.inertia_tip;
  const double root = std::sqrt(a * a * a * a - 4.0 * b * (a * a * start_cosine - b));
  const double outer = (a * a + root) / (2.0 * b);
  // The product of the roots is (a^2 u0 - b) / b, their sum a^2 / b.
  const double lowest = (a * a * start_cosine - b) / (b * outer);
  const double m = (start_cosine - lowest) / (outer - lowest);
  return {lowest, 4.0 * elliptic_k(m) / std::sqrt(b * (outer - lowest))};
}

double flip_time(const FreeBody& body) {
  double energy = 0.0;    // twice the kinetic energy
  double momentum = 0.0;  // its square
  for (int axis = 0; axis < 3; ++axis) {
    const double l = body.inertia[axis] * body.velocity[axis];
    energy += l * body.velocity[axis];
    momentum += l * l;
  }
  double small = body.inertia[0];
  double large = body.inertia[2];
  const double middle = body.inertia[1];
  // The formulas hold for a path about the axis of the largest inertia; the other case is their mirror image.
  if (momentum < energy * middle) std::swap(small, large);
  const double rate = (large - middle) * (momentum - energy * small) / (small * middle * large);
  const double m =
      (middle - small) * (energy * large - momentum) / ((large - middle) * (momentum - energy * small));
  return 2.0 * elliptic_k(m) / std::sqrt(rate);
}

Rolling rolling_accelerations(double force, double plate_mass, double ball_mass, int balls,
                              double ground_friction, double gravity) {
  const double ground = ground_friction * (plate_mass + balls * ball_mass) * gravity;
  // A ball: m a = f and 0.4 m r^2 w' = f r, so that the plate's acceleration is a + w' r = 3.5 f / m.
  const double on_ball = (force - ground) / (3.5 * plate_mass / ball_mass + balls);
  return {(force - ground - balls * on_ball) / plate_mass, on_ball / ball_mass};
}

// --- dominoes ---

namespace {

// The inclination of every domino of the train behind a head at `head` rad, the head last, and how fast each
// turns over how fast the head turns.
struct Train {
  std::vector<double> angles;
  std::vector<double> rates;
};

Train lean(const Dominoes& d, int count, double head) {
  const auto size = static_cast<std::size_t>(count);
  Train train{std::vector<double>(size, head), std::vector<double>(size, 1.0)};
  const double pitch = d.spacing + d.thickness;
  for (std::size_t j = size - 1; j-- > 0;) {
    const double next = train.angles[j + 1];
    const double difference = std::asin((pitch * std::cos(next) - d.thickness) / d.height);
    train.angles[j] = next + difference;
    train.rates[j] = train.rates[j + 1] * (1.0 - pitch * std::sin(next) / (d.height * std::cos(difference)));
  }
  return train;
}

// Of one domino, over its mass: the energy of its height, and the moment of inertia about its front edge.
double height_energy(const Dominoes& d, double angle) {
  return 0.5 * d.gravity * (d.height * std::cos(angle) + d.thickness * std::sin(angle));
}
double edge_inertia(const Dominoes& d) { return (d.height * d.height + d.thickness * d.thickness) / 3.0; }

struct TrainEnergy {
  double inertia = 0.0;  // as the head feels it
  double height = 0.0;
};

TrainEnergy energy_of(const Dominoes& d, int count, double head) {
  const Train train = lean(d, count, head);
  TrainEnergy energy;
  for (std::size_t j = 0; j < train.angles.size(); ++j) {
    energy.inertia += edge_inertia(d) * train.rates[j] * train.rates[j];
    energy.height += height_energy(d, train.angles[j]);
  }
  return energy;
}

}  // namespace

double domino_hit_angle(const Dominoes& dominoes) { return std::asin(dominoes.spacing / dominoes.height); }

std::vector<double> domino_times(const Dominoes& dominoes, int count, double angle) {
  constexpr int kSteps = 400;  // of Simpson's rule from one hit to the next, even
  const double hit = domino_hit_angle(dominoes);
  std::vector<double> times;
  double speed = dominoes.first_speed;
  double now = 0.0;
  for (int head = 0; head < count; ++head) {
    const TrainEnergy start = energy_of(dominoes, head + 1, 0.0);
    const double energy = 0.5 * start.inertia * speed * speed + start.height;
    const auto speed_at = [&](double turned) {
      const TrainEnergy here = energy_of(dominoes, head + 1, turned);
      return std::sqrt(2.0 * (energy - here.height) / here.inertia);
    };
    const auto time_to = [&](double turned) {
      const double step = turned / kSteps;
      double sum = 1.0 / speed_at(0.0) + 1.0 / speed_at(turned);
      for (int i = 1; i < kSteps; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) / speed_at(step * i);
      return sum * step / 3.0;
    };
    times.push_back(now + time_to(angle));
    now += time_to(hit);
    // At rest and upright the next one turns as fast as the one that leans on it.
    const double inertia = energy_of(dominoes, head + 1, hit).inertia;
    speed = speed_at(hit) * inertia / (inertia + edge_inertia(dominoes));
  }
  return times;
}

// --- the arch ---

namespace {

// The thrust H acts at the crown at the height y, both unknown; over weight and radius of the half arch, p =
// H and q = H y are the coordinates of a convex polygon, cut by two lines at each joint.
struct Point {
  double p = 0.0;
  double q = 0.0;
};

// What of the polygon has a p + b q >= c.
std::vector<Point> cut(const std::vector<Point>& polygon, double a, double b, double c) {
  std::vector<Point> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& here = polygon[i];
    const Point& next = polygon[(i + 1) % polygon.size()];
    const double inside = a * here.p + b * here.q - c;
    const double inside_next = a * next.p + b * next.q - c;
    if (inside >= 0.0) kept.push_back(here);
    if ((inside > 0.0 && inside_next < 0.0) || (inside < 0.0 && inside_next > 0.0)) {
      const double share = inside / (inside - inside_next);
      kept.push_back({here.p + share * (next.p - here.p), here.q + share * (next.q - here.q)});
    }
  }
  return kept;
}

}  // namespace

ThrustRange arch_thrust(int voussoirs, double thickness) {
  const double inner = 1.0 - 0.5 * thickness;
  const double outer = 1.0 + 0.5 * thickness;
  const double block = kPi / voussoirs;
  // A block is a straight-sided wedge with its corners on the two circles: the triangle to the outer corners
  // less that to the inner ones.
  const double centroid = 2.0 / 3.0 * std::cos(0.5 * block) *
                          (outer * outer * outer - inner * inner * inner) / (outer * outer - inner * inner);
  std::vector<Point> polygon{{0.0, 0.0}, {10.0, 0.0}, {10.0, 20.0}, {0.0, 20.0}};
  const double half_weight = 0.5 * voussoirs;  // in blocks
  // The crown block is cut by the symmetry plane: half of it, then whole ones.
  double weight = 0.0;
  double moment = 0.0;  // of the weights about the plane of symmetry
  for (int joint = 0; 2 * joint < voussoirs; ++joint) {
    if (joint == 0) {
      // The centroid of half the crown block is that of the half wedge, split at its middle.
      const double s = std::sin(0.5 * block);
      const double c = std::cos(0.5 * block);
      const double area = 0.5 * s * c * (outer * outer - inner * inner);
      const double first = (s * s * c) * (outer * outer * outer - inner * inner * inner) / 6.0;
      weight += 0.5 / half_weight;
      moment += 0.5 / half_weight * first / area;
    } else {
      weight += 1.0 / half_weight;
      moment += centroid * std::sin(joint * block) / half_weight;
    }
    const double angle = (joint + 0.5) * block;
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    // The moment of thrust and weights about the joint's point (r s, r c) is r (p c + W s) - q - M: the line
    // of thrust meets the joint where it is 0, and it grows with r.
    polygon = cut(polygon, outer * c, -1.0, moment - weight * outer * s);
    polygon = cut(polygon, -inner * c, 1.0, weight * inner * s - moment);
  }
  // At the crown the thrust lies within the block.
  polygon = cut(polygon, -inner, 1.0, 0.0);
  polygon = cut(polygon, outer, -1.0, 0.0);
  ThrustRange range;
  if (polygon.size() < 3) return range;
  const auto [least, most] = std::minmax_element(polygon.begin(), polygon.end(),
                                                 [](const Point& a, const Point& b) { return a.p < b.p; });
  return {true, least->p, most->p};
}

double least_arch_thickness(int voussoirs) {
  double low = 0.01;
  double high = 0.5;
  while (high - low > 1e-7) {
    const double middle = 0.5 * (low + high);
    (arch_thrust(voussoirs, middle).stands ? high : low) = middle;
  }
  return high;
}

}  // namespace scree::accuracy
