// Mass properties of bodies from their shapes. Computed by calls in double precision, stored as float rows.
#pragma once

#include <core/check.h>
#include <core/world_data.h>
#include <scree/body.h>
#include <scree/shapes.h>

#include <cstdint>
#include <optional>

namespace scree {

// A symmetric matrix: xx xy xz yy yz zz, the order of InertiaRow.
struct Symmetric {
  double m[6]{};
};

Symmetric rotated(Quat rotation, const Symmetric& matrix);          // R M R^T
void rotate(Quat rotation, const double vector[3], double out[3]);  // R v
bool is_positive_definite(const Symmetric& matrix);
Symmetric inverse(const Symmetric& matrix);  // of a positive definite one

// Mass, center and inertia about the center of a growing set of parts. Parts are merged one by one about
// their common center, so that nothing cancels for shapes far from the body's origin.
struct MassSum {
  double mass = 0.0;   // kg
  double center[3]{};  // m, in the body's frame
  Symmetric inertia;   // kg m^2, about the center in the body's axes

  void add(double part_mass, const double part_center[3], const Symmetric& part_inertia);
  void add(const Geometry& geometry, double density, const Pose& local_pose);
};

// What the rows of one body hold about its mass.
struct BodyMass {
  float mass = 0.0f;
  Vec3 center{};
  LocalInertiaRow inertia{};
  InertiaRow inverse{};  // zero where the body is not dynamic
  bool gyroscopic = false;
};

// A body's shapes as they will be after the call: one shape added (index -1), replaced or, without a new
// form, removed.
struct ShapeForm {
  Geometry geometry;
  float density;
  Pose local_pose;
};
struct ShapeChange {
  std::int32_t index = -1;
  const ShapeForm* form = nullptr;
};

Geometry geometry_of(const WorldData& data, std::int32_t shape);
MassSum sum_shapes(const WorldData& data, std::int32_t body, const ShapeChange& change);

// Of a dynamic body whose shapes weigh `sum`; `given_mass` scales. Throws where float rows can not hold it.
BodyMass dynamic_mass(Call call, const MassSum& sum, std::optional<float> given_mass);
// Of a body with properties from the caller; throws unless they are those of some solid.
BodyMass given_mass_rows(Call call, const MassProperties& properties, BodyType type);

// The row form of the body's mass once its type is `type`, its flags are `flags` and its shapes are changed.
BodyMass mass_after(Call call, const WorldData& data, std::int32_t body, BodyType type, std::uint8_t flags,
                    const ShapeChange& change = {});

MassProperties properties_of(const MassSum& sum, std::optional<float> given_mass);
MassProperties properties_of(const Bodies& bodies, std::int32_t body);

}  // namespace scree
