// A ray against a cylinder, a cone or a rounded box; parts of query_ray.cpp. In the solid's frame.
#pragma once

#include <parallel/queries/query_ray.h>

#include <limits>

namespace scree::queries {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

// The fraction at which a ray that begins outside enters a ball about the origin; kNever if it does not.
double enter_ball(Vector origin, Vector way, double radius);
bool meet_capsule(double half, double radius, const Line& line, Entry& entry);
bool meet_box(Vector half, const Line& line, Entry& entry);

bool meet_cylinder(double half, double radius, const Line& line, Entry& entry);
bool meet_cone(double half, double radius, const Line& line, Entry& entry);
bool meet_rounded_box(Vector half, double rounding, const Line& line, Entry& entry);

}  // namespace scree::queries
