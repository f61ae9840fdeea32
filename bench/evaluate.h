// The evaluator: quality figures of a simulated scene, from its final poses and velocities alone.
//
// One evaluator serves all engines, so that no engine evaluates itself. It knows the scene's shapes and the
// body states that an engine reports, but none of the engine's contacts. Written for exactness, not for
// speed.
#pragma once

#include "bench/geometry.h"
#include "tools/scenes/scene.h"

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace scree::bench {

/// State of a body as an engine reports it.
struct BodyState {
  Pose pose;              ///< of the body's origin
  Vec3 linear_velocity;   ///< of the center of mass, m/s
  Vec3 angular_velocity;  ///< rad/s, world axes
  bool exists =
      true;  ///< false before it is created and after it is destroyed: then the members above do not count
};

/// The polytopes of a scene's hulls, one where shapes share a hull and its scale; an entry per shape, empty
/// for other shapes.
std::vector<std::shared_ptr<const Polytope>> make_polytopes(const scenes::Scene& scene);
/// The surfaces of a scene's meshes, one where shapes share a mesh; an entry per shape, empty for other
/// shapes.
std::vector<std::shared_ptr<const Surface>> make_surfaces(const scenes::Scene& scene);

/// Mass, center of mass and inertia about it (body axes) as the scene's shapes and definitions give them.
struct BodyMass {
  double mass = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};
BodyMass body_mass(const scenes::Scene& scene, const scenes::SceneBody& body,
                   std::span<const std::shared_ptr<const Polytope>> polytopes);
BodyMass body_mass(const scenes::Scene& scene, const scenes::SceneBody& body);

/// A frame in the body's own: at the center of mass, along axes about which the inertia is diagonal.
struct PrincipalFrame {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();
};
/// The body's own frame if it is principal already, within a millionth.
PrincipalFrame principal_frame(const BodyMass& mass);

/// The radius of the largest ball about its center that lies within a convex shape.
double inner_radius(const Geometry& geometry, const Polytope* polytope);

/// A pair of shapes touches when its gap is below this, in meters: resting contacts of a soft solver
/// oscillate by some micrometers around zero and must not leave and enter the mean. A gap counts as
/// penetration 0.
inline constexpr double kTouchGap = 1e-3;

/// Penetrations of touching pairs, gathered over any number of evaluations.
class PenetrationStatistics {
 public:
  void add(double penetration);
  std::int64_t pairs() const { return pairs_; }
  double mean() const;  ///< m
  double max() const { return max_; }
  /// The smallest value that at least the share `quantile` of the pairs does not exceed, rounded up to whole
  /// micrometers below 1 m.
  double quantile(double quantile) const;

 private:
  std::vector<std::int64_t> bins_;  // one per micrometer, and one for all deeper penetrations
  std::int64_t pairs_ = 0;
  double sum_ = 0.0;
  double max_ = 0.0;
};

/// Distances of the anchors that joints hold together, gathered over any number of evaluations.
class DriftStatistics {
 public:
  void add(double distance);
  std::int64_t joints() const { return joints_; }
  double mean() const { return joints_ > 0 ? sum_ / static_cast<double>(joints_) : 0.0; }  ///< m
  double max() const { return max_; }

 private:
  std::int64_t joints_ = 0;
  double sum_ = 0.0;
  double max_ = 0.0;
};

/// Figures of the bodies at one moment, independent of contacts.
struct BodyFigures {
  double kinetic_energy = 0.0;   ///< J
  double top_drop = 0.0;         ///< m, largest drop of the bodies that were on top at the start
  double top_height = 1.0;       ///< lowest height of those bodies over their height at the start
  std::int64_t bodies_left = 0;  ///< dynamic bodies outside the scene's start bounds, behind a
                                 ///< half-space that stands still, or not finite
};

/// Evaluates one scene repeatedly. `states` always holds the scene's bodies in the scene's order. Bodies that
/// do not exist are ignored. Bodies with a non-finite state count as left and are ignored elsewhere.
class Evaluator {
 public:
  /// Keeps a reference to the scene.
  explicit Evaluator(const scenes::Scene& scene);
  BodyFigures body_figures(std::span<const BodyState> states) const;
  /// Adds the penetrations of all touching pairs of shapes of which one belongs to a dynamic body, except for
  /// pairs that a joint keeps from colliding.
  void add_touching_pairs(std::span<const BodyState> states, PenetrationStatistics& statistics) const;
  /// Adds the distance of the anchors of every joint that holds them rigidly by its definition (balls,
  /// hinges, welds and universal joints) and has a dynamic body.
  void add_joint_drift(std::span<const BodyState> states, DriftStatistics& statistics) const;

 private:
  PlacedShape placed(std::uint32_t shape, const Pose& body_pose) const;
  bool has_left(const BodyState& state) const;
  void bound(const PlacedShape& shape);

  const scenes::Scene& scene_;
  std::vector<std::shared_ptr<const Polytope>> polytopes_;  // by shape of the scene; null unless it is a hull
  std::vector<std::shared_ptr<const Surface>> surfaces_;    // the same of meshes
  std::vector<PlacedShape> walls_;                          // half-spaces of fixed bodies
  std::vector<BodyMass> masses_;
  std::vector<std::uint32_t> top_bodies_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> apart_;  // bodies that joints keep from colliding
  Eigen::Vector3d lower_, upper_;                               // bounds of the scene at its start
};

}  // namespace scree::bench
