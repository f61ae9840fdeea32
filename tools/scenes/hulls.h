// Points whose hulls scenes are made of; the same bits on every machine.
#pragma once

#include <scree/hull.h>

#include <cstdint>
#include <vector>

namespace scree::scenes {

/// Points on a sphere along a spiral, evenly spread: z = 1 - (2i + 1)/count, turned by the golden ratio from
/// one to the next.
std::vector<Vec3> fibonacci_points(int count, float radius);

/// Points in random directions, drawn with the 32-bit generator s = s * 2147001325 + 715136305: x, y and z
/// from its lower 16 bits, in a cube, until they lie in the ball that the cube holds.
std::vector<Vec3> random_sphere_points(int count, float radius, std::uint32_t seed);

/// Corners of a prism that stands on y = 0; the first lies in the direction of x.
std::vector<Vec3> prism_points(int sides, float radius, float height);

std::vector<Vec3> tetrahedron_points(float radius);
std::vector<Vec3> octahedron_points(Vec3 half_extents);
std::vector<Vec3> box_points(Vec3 half_extents);

std::vector<Vec3> scaled(std::vector<Vec3> points, Vec3 scale);
std::vector<Vec3> moved(std::vector<Vec3> points, Vec3 offset);

}  // namespace scree::scenes
