// The built-in scenes, one function each; catalog.cpp lists them and checks their parameters.
#pragma once

#include <tools/scenes/random.h>
#include <tools/scenes/scene.h>

#include <cstdint>

namespace scree::scenes {

// Every builder may rely on complete parameters within the catalog's limits.
Scene large_pyramid(const Parameters& parameters);
Scene many_pyramids(const Parameters& parameters);
Scene pile(const Parameters& parameters);
Scene convex_pile(const Parameters& parameters);
Scene junkyard(const Parameters& parameters);
Scene hull_zoo(const Parameters& parameters);
Scene stack(const Parameters& parameters);
Scene wall(const Parameters& parameters);
Scene kapla(const Parameters& parameters);
Scene card_house(const Parameters& parameters);
Scene slope(const Parameters& parameters);
Scene spheres_in_box(const Parameters& parameters);
std::vector<Scene> many_worlds(const Parameters& parameters);
Scene joint_grid(const Parameters& parameters);
Scene chain(const Parameters& parameters);
Scene bridge(const Parameters& parameters);
Scene wrecking_ball(const Parameters& parameters);
Scene ragdolls(const Parameters& parameters);
Scene vehicles(const Parameters& parameters);
Scene motors(const Parameters& parameters);
Scene card_catapult(const Parameters& parameters);
Scene large_world(const Parameters& parameters);
Scene streaming(const Parameters& parameters);
Scene spawning(const Parameters& parameters);
Scene heavy_stack(const Parameters& parameters);
Scene arch(const Parameters& parameters);
Scene solver_sampler(const Parameters& parameters);
Scene wheel_pile(const Parameters& parameters);
Scene drum(const Parameters& parameters);
Scene terrain(const Parameters& parameters);
Scene ragdoll_rain(const Parameters& parameters);
Scene height_field(const Parameters& parameters);
Scene bullets(const Parameters& parameters);

// --- what they are made of ---

/// An empty scene under the 10 m/s^2 that published benchmarks use.
Scene start_scene(const char* name, int steps);
/// Adds a shape for bodies to share; returns its index.
std::uint32_t add_shape(Scene& scene, const Geometry& geometry, const Material& material = {},
                        const ShapeOptions& options = {});
/// Returns the body's index.
std::uint32_t add_body(Scene& scene, const BodyDef& def, std::uint32_t first_shape,
                       std::uint32_t shape_count = 1);
/// A fixed box whose top is the plane y = 0.
void add_ground(Scene& scene, float half_width, const Material& material = {});
/// Joins two bodies, or one with kWorldItself, at the frames of the definition.
void add_joint(Scene& scene, std::uint32_t body_a, std::uint32_t body_b, const Joint& joint,
               const JointDef& def);
/// Joins two bodies in their initial poses: both frames are at a pose in world coordinates.
void add_joint_at(Scene& scene, std::uint32_t body_a, std::uint32_t body_b, const Pose& place,
                  const Joint& joint, JointDef def = {});
/// A fixed floor at y = 0 with four walls around the square |x|, |z| < half_width, closed above if asked.
void add_pit(Scene& scene, float half_width, float height, bool lid = false);

/// Adds the hulls of mixed bodies; returns the first one's index.
std::uint32_t add_pile_hulls(Scene& scene);
/// Draws a box, sphere, capsule or one of those hulls, none of which reaches farther than 0.607 m from its
/// center. Returns the shape's index.
std::uint32_t add_mixed_shape(Scene& scene, std::uint32_t first_hull, Random& random);
/// Hills in a square |x|, |z| < half_width with a rim around it, of about so many triangles.
TriangleMesh hills(int triangles, float half_width);
/// A fixed body of them.
void add_hills(Scene& scene, int triangles, float half_width);

/// The parameter as a whole number.
int whole(const Parameters& parameters, const char* name);
float real(const Parameters& parameters, const char* name);

}  // namespace scree::scenes
