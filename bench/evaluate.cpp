// The evaluator: a grid finds pairs, geometry.h measures them, sums give the figures.
#include "bench/evaluate.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

namespace scree::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using scenes::Scene;
using scenes::SceneBody;
using scenes::SceneShape;

constexpr double kBin = 1e-6;                 // m
constexpr std::size_t kBins = 1'000'001;      // up to 1 m, and the rest
constexpr double kLeftMargin = 1.0;           // m beyond the start bounds: a body may roll along the rim
constexpr double kSquare = 1.0 - 1e-12;       // cosine of a plane's normal and the axis that it is along
constexpr double kTopTolerance = 1e-3;        // m, bodies this close to the highest one are on top too
constexpr double kLargeShape = 4.0;           // times the median size: larger shapes are tested against all
constexpr std::int64_t kCellLimit = 1 << 20;  // cells per axis and side that fit the packed key

struct Solid {
  double volume;
  Vector3d centroid;  // in the shape's frame
  Matrix3d inertia;   // about the centroid for unit density, the shape's axes
};

Solid solid(const Geometry& geometry, const Polytope* polytope) {
  constexpr double kPi = std::numbers::pi;
  const auto central = [](double volume, const Vector3d& inertia) -> Solid {
    return {volume, Vector3d::Zero(), inertia.asDiagonal()};
  };
  if (polytope != nullptr) return {polytope->volume, polytope->centroid, polytope->inertia};
  if (const auto* box = std::get_if<Box>(&geometry)) {
    const Vector3d h = to_double(box->half_extents);
    const double volume = 8.0 * h.prod();
    const Vector3d squares = h.cwiseProduct(h);
    return central(volume, volume / 3.0 * (Vector3d::Constant(squares.sum()) - squares));
  }
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
    const double r = double{sphere->radius};
    const double volume = 4.0 / 3.0 * kPi * r * r * r;
    return central(volume, Vector3d::Constant(0.4 * volume * r * r));
  }
  const auto& capsule = std::get<Capsule>(geometry);
  const double r = double{capsule.radius};
  const double h = double{capsule.half_height};
  const double cylinder = 2.0 * kPi * r * r * h;
  const double ball = 4.0 / 3.0 * kPi * r * r * r;
  // Each half ball has its centroid 3r/8 beyond the end of the cylinder and 83/320 m r^2 about it.
  const double half_ball_offset = h + 0.375 * r;
  const double across = cylinder * (r * r / 4.0 + h * h / 3.0) +
                        ball * (83.0 / 320.0 * r * r + half_ball_offset * half_ball_offset);
  const double along = cylinder * r * r / 2.0 + ball * 0.4 * r * r;
  return central(cylinder + ball, {across, along, across});
}

bool is_finite(const BodyState& state) {
  if (!state.exists) return false;
  const auto finite = [](Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
  const Quat& q = state.pose.rotation;
  const bool rotation = std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z) && std::isfinite(q.w);
  return rotation && finite(state.pose.position) && finite(state.linear_velocity) &&
         finite(state.angular_velocity);
}

bool filters_accept(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

bool holds_anchors(const scenes::SceneJoint& joint) {
  const bool holds =
      std::holds_alternative<BallJoint>(joint.joint) || std::holds_alternative<HingeJoint>(joint.joint) ||
      std::holds_alternative<WeldJoint>(joint.joint) || std::holds_alternative<UniversalJoint>(joint.joint);
  return holds && joint.def.enabled && joint.def.hertz == 0.0f;
}

// The lower number first.
std::pair<std::uint32_t, std::uint32_t> body_pair(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

struct WorldShape {
  PlacedShape placed;
  std::uint32_t body = 0;
  std::uint32_t shape = 0;
};

// All pairs whose bounds are closer than the touch gap: a uniform grid for shapes of common size, and a full
// search for the few large ones (grounds, walls).
template <class Visit>
void for_each_close_pair(const std::vector<WorldShape>& shapes, const Visit& visit) {
  const auto size_of = [&](std::size_t i) {
    return (shapes[i].placed.upper - shapes[i].placed.lower).maxCoeff() + kTouchGap;
  };
  const auto visit_if_close = [&](std::size_t i, std::size_t j) {
    const PlacedShape& a = shapes[i].placed;
    const PlacedShape& b = shapes[j].placed;
    const bool close = ((a.lower.array() - kTouchGap) <= b.upper.array()).all() &&
                       (b.lower.array() <= (a.upper.array() + kTouchGap)).all();
    if (close) visit(shapes[i], shapes[j]);
  };
  if (shapes.empty()) return;
  std::vector<double> sizes(shapes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) sizes[i] = size_of(i);
  std::vector<double> sorted = sizes;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double largest_small = kLargeShape * sorted[sorted.size() / 2];
  double cell = 0.0;
  for (const double size : sizes) {
    if (size <= largest_small) cell = std::max(cell, size);
  }

  const auto pack = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return ((x + kCellLimit) << 42) | ((y + kCellLimit) << 21) | (z + kCellLimit);
  };
  const auto coordinate = [&](double value) {
    const double limit = static_cast<double>(kCellLimit - 2);
    return static_cast<std::int64_t>(std::clamp(std::floor(value / cell), -limit, limit));
  };
  std::vector<std::pair<std::int64_t, std::size_t>> cells;
  std::vector<std::size_t> large;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Vector3d& c = shapes[i].placed.center;
    if (sizes[i] > largest_small) {
      large.push_back(i);
    } else {
      cells.emplace_back(pack(coordinate(c.x()), coordinate(c.y()), coordinate(c.z())), i);
    }
  }
  std::sort(cells.begin(), cells.end());

  for (const auto& [own_key, i] : cells) {
    const Vector3d& c = shapes[i].placed.center;
    const std::int64_t z = coordinate(c.z());
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const std::int64_t x = coordinate(c.x()) + dx;
        const std::int64_t y = coordinate(c.y()) + dy;
        auto entry =
            std::lower_bound(cells.begin(), cells.end(), std::pair{pack(x, y, z - 1), std::size_t{0}});
        for (; entry != cells.end() && entry->first <= pack(x, y, z + 1); ++entry) {
          if (i < entry->second) visit_if_close(i, entry->second);
        }
      }
    }
  }
  for (std::size_t k = 0; k < large.size(); ++k) {
    for (const auto& [key, i] : cells) visit_if_close(large[k], i);
    for (std::size_t l = k + 1; l < large.size(); ++l) visit_if_close(large[k], large[l]);
  }
}

}  // namespace

std::vector<std::shared_ptr<const Polytope>> make_polytopes(const Scene& scene) {
  std::vector<std::shared_ptr<const Polytope>> polytopes(scene.shapes.size());
  std::map<std::tuple<const Vec3*, float, float, float>, std::shared_ptr<const Polytope>> known;
  for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
    const auto* hull = std::get_if<ConvexHull>(&scene.shapes[i].geometry);
    if (hull == nullptr) continue;
    auto& polytope = known[{hull->hull.vertices().data(), hull->scale.x, hull->scale.y, hull->scale.z}];
    if (!polytope) polytope = make_polytope(*hull);
    polytopes[i] = polytope;
  }
  return polytopes;
}

std::vector<std::shared_ptr<const Surface>> make_surfaces(const Scene& scene) {
  std::vector<std::shared_ptr<const Surface>> surfaces(scene.shapes.size());
  std::map<const Vec3*, std::shared_ptr<const Surface>> known;
  for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
    const auto* mesh = std::get_if<TriangleMesh>(&scene.shapes[i].geometry);
    if (mesh == nullptr) continue;
    auto& surface = known[mesh->vertices().data()];
    if (!surface) surface = make_surface(*mesh);
    surfaces[i] = surface;
  }
  return surfaces;
}

BodyMass body_mass(const Scene& scene, const SceneBody& body,
                   std::span<const std::shared_ptr<const Polytope>> polytopes) {
  BodyMass result;
  if (body.shape_count == 0) {
    result.mass = body.def.mass ? double{*body.def.mass} : 1.0;
    result.inertia = Matrix3d::Identity() * result.mass;
    return result;
  }
  struct Part {
    Solid solid;
    Vector3d centroid;  // in the body's frame
    Matrix3d rotation;
    double density;
  };
  std::vector<Part> parts;
  for (std::uint32_t s = body.first_shape; s < body.first_shape + body.shape_count; ++s) {
    const SceneShape& shape = scene.shapes[s];
    const Matrix3d rotation = to_double(shape.options.local_pose.rotation).toRotationMatrix();
    const Solid unit = solid(shape.geometry, polytopes[s].get());
    const Vector3d centroid = to_double(shape.options.local_pose.position) + rotation * unit.centroid;
    const double mass = unit.volume * double{shape.material.density};
    result.mass += mass;
    result.center += mass * centroid;
    parts.push_back({unit, centroid, rotation, double{shape.material.density}});
  }
  result.center /= result.mass;
  for (const Part& part : parts) {
    const Vector3d offset = part.centroid - result.center;
    result.inertia += part.density * (part.rotation * part.solid.inertia * part.rotation.transpose());
    result.inertia += part.density * part.solid.volume *
                      (offset.squaredNorm() * Matrix3d::Identity() - offset * offset.transpose());
  }
  if (body.def.mass) {
    result.inertia *= double{*body.def.mass} / result.mass;
    result.mass = double{*body.def.mass};
  }
  return result;
}

BodyMass body_mass(const Scene& scene, const SceneBody& body) {
  return body_mass(scene, body, make_polytopes(scene));
}

PrincipalFrame principal_frame(const BodyMass& mass) {
  constexpr double kNegligible = 1e-6;
  PrincipalFrame frame;
  frame.center = mass.center;
  frame.inertia = mass.inertia.diagonal();
  if (mass.mass > 0.0 && mass.center.norm() < kNegligible * std::sqrt(mass.inertia.trace() / mass.mass)) {
    frame.center.setZero();
  }
  const Matrix3d rest = mass.inertia - Matrix3d(frame.inertia.asDiagonal());
  if (rest.norm() < kNegligible * mass.inertia.norm()) return frame;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(mass.inertia);
  Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  frame.rotation = Eigen::Quaterniond(axes).normalized();
  frame.inertia = solver.eigenvalues();
  return frame;
}

double inner_radius(const Geometry& geometry, const Polytope* polytope) {
  if (polytope != nullptr) return polytope->inner_radius;
  if (const auto* box = std::get_if<Box>(&geometry)) return to_double(box->half_extents).minCoeff();
  if (const auto* capsule = std::get_if<Capsule>(&geometry)) return double{capsule->radius};
  return double{std::get<Sphere>(geometry).radius};
}

void PenetrationStatistics::add(double penetration) {
  if (bins_.empty()) bins_.resize(kBins);
  const double bin = std::ceil(penetration / kBin);
  ++bins_[static_cast<std::size_t>(std::min(bin, static_cast<double>(kBins - 1)))];
  ++pairs_;
  sum_ += penetration;
  max_ = std::max(max_, penetration);
}

double PenetrationStatistics::mean() const { return pairs_ > 0 ? sum_ / static_cast<double>(pairs_) : 0.0; }

double PenetrationStatistics::quantile(double quantile) const {
  if (pairs_ == 0) return 0.0;
  const auto wanted = static_cast<std::int64_t>(std::ceil(quantile * static_cast<double>(pairs_)));
  std::int64_t seen = 0;
  for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= wanted) return std::min(static_cast<double>(bin) * kBin, max_);
  }
  return max_;
}

void DriftStatistics::add(double distance) {
  ++joints_;
  sum_ += distance;
  max_ = std::max(max_, distance);
}

Evaluator::Evaluator(const Scene& scene)
    : scene_(scene), polytopes_(make_polytopes(scene)), surfaces_(make_surfaces(scene)) {
  double top = -std::numeric_limits<double>::infinity();
  lower_ = Vector3d::Constant(std::numeric_limits<double>::infinity());
  upper_ = -lower_;
  for (const SceneBody& body : scene.bodies) {
    const bool is_dynamic = body.def.type == BodyType::dynamic;
    masses_.push_back(is_dynamic ? body_mass(scene, body, polytopes_) : BodyMass{});
    if (is_dynamic && !body.comes_later) top = std::max(top, double{body.def.position.y});
    const Pose pose{body.def.position, body.def.rotation};
    for (std::uint32_t s = body.first_shape; s < body.first_shape + body.shape_count; ++s) {
      const PlacedShape shape = placed(s, pose);
      bound(shape);
      if (shape.is_half_space && body.def.type == BodyType::fixed) walls_.push_back(shape);
    }
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyDef& def = scene.bodies[i].def;
    if (def.type == BodyType::dynamic && !scene.bodies[i].comes_later &&
        double{def.position.y} >= top - kTopTolerance) {
      top_bodies_.push_back(static_cast<std::uint32_t>(i));
    }
  }
  for (const scenes::SceneJoint& joint : scene.joints) {
    if (!joint.def.collide_connected) apart_.push_back(body_pair(joint.body_a, joint.body_b));
  }
  std::sort(apart_.begin(), apart_.end());
}

PlacedShape Evaluator::placed(std::uint32_t shape, const Pose& body_pose) const {
  const SceneShape& own = scene_.shapes[shape];
  return place(own.geometry, own.options.local_pose, body_pose, polytopes_[shape], surfaces_[shape]);
}

// Bodies may be anywhere on a half-space: only across its plane, where that is square to an axis, it bounds
// the scene.
void Evaluator::bound(const PlacedShape& shape) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool bounds = shape.is_half_space && std::abs(shape.axes(axis, 1)) > kSquare;
    lower_[axis] = std::min(lower_[axis], bounds ? shape.center[axis] : shape.lower[axis]);
    upper_[axis] = std::max(upper_[axis], bounds ? shape.center[axis] : shape.upper[axis]);
  }
}

bool Evaluator::has_left(const BodyState& state) const {
  const Vector3d position = to_double(state.pose.position);
  if (!is_finite(state) || position.x() < lower_.x() - kLeftMargin ||
      position.x() > upper_.x() + kLeftMargin || position.z() < lower_.z() - kLeftMargin ||
      position.z() > upper_.z() + kLeftMargin || position.y() < lower_.y() - kLeftMargin) {
    return true;
  }
  return std::any_of(walls_.begin(), walls_.end(), [&](const PlacedShape& wall) {
    return wall.axes.col(1).dot(position - wall.center) < -kLeftMargin;
  });
}

BodyFigures Evaluator::body_figures(std::span<const BodyState> states) const {
  BodyFigures result;
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    if (scene_.bodies[i].def.type != BodyType::dynamic || !states[i].exists) continue;
    const BodyState& state = states[i];
    if (has_left(state)) ++result.bodies_left;
    if (!is_finite(state)) continue;
    const Vector3d spin = to_double(state.pose.rotation).conjugate() * to_double(state.angular_velocity);
    result.kinetic_energy += 0.5 * masses_[i].mass * to_double(state.linear_velocity).squaredNorm() +
                             0.5 * spin.dot(masses_[i].inertia * spin);
  }
  for (const std::uint32_t i : top_bodies_) {
    if (!states[i].exists) continue;
    const double start = double{scene_.bodies[i].def.position.y};
    const double now = is_finite(states[i]) ? double{states[i].pose.position.y} : 0.0;
    result.top_drop = std::max(result.top_drop, start - now);
    if (start > 0.0) result.top_height = std::min(result.top_height, now / start);
  }
  return result;
}

void Evaluator::add_touching_pairs(std::span<const BodyState> states,
                                   PenetrationStatistics& statistics) const {
  std::vector<WorldShape> shapes;
  shapes.reserve(scene_.shapes.size());
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    if (!is_finite(states[i])) continue;
    const SceneBody& body = scene_.bodies[i];
    for (std::uint32_t s = body.first_shape; s < body.first_shape + body.shape_count; ++s) {
      shapes.push_back({placed(s, states[i].pose), static_cast<std::uint32_t>(i), s});
    }
  }
  for_each_close_pair(shapes, [&](const WorldShape& a, const WorldShape& b) {
    const bool any_dynamic = scene_.bodies[a.body].def.type == BodyType::dynamic ||
                             scene_.bodies[b.body].def.type == BodyType::dynamic;
    if (a.body == b.body || !any_dynamic) return;
    const Filter& filter_a = scene_.shapes[a.shape].options.filter;
    const Filter& filter_b = scene_.shapes[b.shape].options.filter;
    if (!filters_accept(filter_a, filter_b)) return;
    if (std::binary_search(apart_.begin(), apart_.end(), body_pair(a.body, b.body))) return;
    const double gap = signed_gap(a.placed, b.placed, kTouchGap);
    if (gap < kTouchGap) statistics.add(std::max(-gap, 0.0));
  });
}

void Evaluator::add_joint_drift(std::span<const BodyState> states, DriftStatistics& statistics) const {
  const auto is_dynamic = [&](std::uint32_t body) {
    return body != scenes::kWorldItself && scene_.bodies[body].def.type == BodyType::dynamic;
  };
  const auto known = [&](std::uint32_t body) {
    return body == scenes::kWorldItself || is_finite(states[body]);
  };
  const auto anchor = [&](std::uint32_t body, const Pose& frame) -> Vector3d {
    const Vector3d local = to_double(frame.position);
    if (body == scenes::kWorldItself) return local;
    const Pose& pose = states[body].pose;
    return to_double(pose.position) + to_double(pose.rotation) * local;
  };
  for (const scenes::SceneJoint& joint : scene_.joints) {
    if (!holds_anchors(joint) || !(is_dynamic(joint.body_a) || is_dynamic(joint.body_b))) continue;
    if (!known(joint.body_a) || !known(joint.body_b)) continue;
    statistics.add(
        (anchor(joint.body_a, joint.def.frame_a) - anchor(joint.body_b, joint.def.frame_b)).norm());
  }
}

}  // namespace scree::bench
