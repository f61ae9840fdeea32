// Mass properties of bodies from their shapes. Computed by calls in double precision, stored as float rows.
#pragma once

#include <core/world/check.h>
#include <core/world/mass_moments.h>
#include <core/world/world_data.h>
#include <scree/body.h>
#include <scree/shapes.h>

#include <cstdint>
#include <optional>
#include <span>

namespace scree {

Symmetric rotated(Quat rotation, const Symmetric& matrix);          // R M R^T
void rotate(Quat rotation, const double vector[3], double out[3]);  // R v
bool is_positive_definite(const Symmetric& matrix);
Symmetric inverse(const Symmetric& matrix);  // of a positive definite one

// Of a solid in its body.
MassSum part_of(const Geometry& geometry, double density, const Pose& local_pose);

// What the rows of one body hold about its mass.
struct BodyMass {
  float mass = 0.0f;
  Vec3 center{};
  LocalInertiaRow inertia{};
  InertiaRow inverse{};  // zero where the body is not dynamic
  bool gyroscopic = false;
};

// A body's shapes as they will be after the call: some added (index -1), or one replaced or, without a new
// form, removed.
struct ShapeForm {
  Geometry geometry;
  float density;
  Pose local_pose;
};
struct ShapeChange {
  std::int32_t index = -1;
  std::span<const ShapeForm> forms{};
};

Geometry geometry_of(const WorldData& data, std::int32_t shape);
// Exact sums of a body of more shapes than this are kept (Bodies::moments), so that the next change need not
// look at all of them. A few are summed faster than they are found.
inline constexpr std::int64_t kFewShapes = 8;
// Of the body after the change; begins to keep the sums of many shapes.
MassSum sum_shapes(WorldData& data, std::int32_t body, const ShapeChange& change = {});
// Updates the kept sums of the body. Cannot fail; the columns are as before the change.
void follow_change(WorldData& data, std::int32_t body, const ShapeChange& change);

// Of a dynamic body whose shapes weigh `sum`; `given_mass` scales. Throws where float rows cannot hold it.
BodyMass dynamic_mass(Call call, const MassSum& sum, std::optional<float> given_mass);
// Of a body with properties from the caller; throws unless they are those of some solid.
BodyMass given_mass_rows(Call call, const MassProperties& properties, BodyType type);

// The row form of the body's mass once its type is `type`, its flags are `flags` and its shapes are changed.
BodyMass mass_after(Call call, WorldData& data, std::int32_t body, BodyType type, std::uint8_t flags,
                    const ShapeChange& change = {});

MassProperties properties_of(const MassSum& sum, std::optional<float> given_mass);
MassProperties properties_of(const Bodies& bodies, std::int32_t body);

}  // namespace scree
