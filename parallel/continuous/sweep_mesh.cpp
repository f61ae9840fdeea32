// Sweeps of balls against meshes; see sweep_mesh.h. Works in the mesh's frame and in double precision: a mesh
// may reach far, and have large triangles.
#include <core/world/edit.h>
#include <parallel/continuous/sweep_mesh.h>
#include <parallel/queries/query_math.h>

#include <algorithm>
#include <cmath>

namespace scree::sweeps {

namespace {

using queries::Axes;
using queries::Vector;

// A triangle relative to where a ball's way begins.
struct TriangleObstacle {
  std::int32_t shape;
  Vector corner[3];

  Vector normal() const {  // to the front, of any length
    return cross(corner[1] - corner[0], corner[2] - corner[0]);
  }
  Vector nearest_to(Vector point) const;

  // `path` is relative to the same place.
  Distance distance_at(const Path& path, float t) const {
    const Vector point = queries::to_vector(path.start) + double{t} * queries::to_vector(path.motion);
    const Vector way = point - nearest_to(point);
    const double far = queries::length(way);
    if (!(far > 0.0)) return {0.0f, 0.0f, {}};
    const Vector away = (1.0 / far) * way;
    return {static_cast<float>(far), static_cast<float>(dot(away, queries::to_vector(path.motion))),
            queries::to_vec3(away)};
  }
};

Vector nearest_on_edge(Vector point, Vector from, Vector to) {
  const Vector edge = to - from;
  const double part = dot(point - from, edge) / dot(edge, edge);
  return from + std::clamp(part, 0.0, 1.0) * edge;
}

// Above the face where the point lies inward of all edges; else on one of the edges that it lies outward of.
Vector TriangleObstacle::nearest_to(Vector point) const {
  const Vector n = normal();
  double least = -1.0;
  Vector nearest;
  for (int i = 0; i < 3; ++i) {
    const Vector from = corner[i], to = corner[(i + 1) % 3];
    if (dot(cross(n, to - from), point - from) >= 0.0) continue;
    const Vector on_edge = nearest_on_edge(point, from, to);
    const double far = dot(point - on_edge, point - on_edge);
    if (least >= 0.0 && far >= least) continue;
    least = far;
    nearest = on_edge;
  }
  if (least >= 0.0) return nearest;
  return point - (dot(n, point - corner[0]) / dot(n, n)) * n;
}

// A sweep in the frame of a mesh.
struct LocalSweep {
  Vector origin, start, motion;
};

// The meeting with one triangle, its normal in the mesh's frame.
Meeting meeting_with_triangle(const MeshData& mesh, std::int32_t triangle, const Sweep& sweep,
                              const LocalSweep& local, std::int32_t shape) {
  TriangleObstacle obstacle{shape, {}};
  for (int i = 0; i < 3; ++i) {
    const float* vertex = mesh.vertex + std::ptrdiff_t{3} * mesh.corners[triangle].vertex[i];
    obstacle.corner[i] = Vector{vertex[0], vertex[1], vertex[2]} - local.start;
  }
  const Vector normal = obstacle.normal();
  if (!(dot(normal, obstacle.corner[0]) < 0.0 && dot(normal, local.motion) < 0.0)) return {};
  const Vector begin = local.origin - local.start;
  const double gap = queries::length(begin - obstacle.nearest_to(begin)) - double{sweep.radius};
  const bool touched = gap <= double{kLinearSlop};
  if (sweep.against != (touched ? Against::touched : Against::others) && sweep.against != Against::all)
    return {};
  const Path path{{}, queries::to_vec3(local.motion)};
  if (touched) return core_meeting(obstacle, path, sweep.radius, sweep.left);
  return {meeting(obstacle, path, sweep.radius), shape, {}};
}

// A box about the way of the ball's core, rounded outward.
simd::MeetTask task_of(const LocalSweep& local, float radius) {
  constexpr double kRounding = 1e-6;  // of coordinates: more than floats are off by
  simd::MeetTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    const double start = local.start[axis], end = start + local.motion[axis];
    const double room = double{kCoreShare * radius} + kRounding * (std::abs(start) + std::abs(end));
    task.lower[axis] = static_cast<float>(std::min(start, end) - room);
    task.upper[axis] = static_cast<float>(std::max(start, end) + room);
  }
  return task;
}

}  // namespace

Meeting meeting_with_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                          const Sweep& sweep, std::int32_t shape) {
  const Axes axes = queries::to_axes(to_quat(pose.rotation));
  const Vector position = queries::to_vector(pose.position);
  const auto place = [&](Vec3 point) { return turn_back(axes, queries::to_vector(point) - position); };
  LocalSweep local{place(sweep.origin), place(sweep.start), {}};
  local.motion = place(sweep.end) - local.start;
  struct First {
    const MeshData& mesh;
    const Sweep& sweep;
    const LocalSweep& local;
    std::int32_t shape;
    Meeting met{};
    std::int32_t given = -1;
  } first{mesh, sweep, local, shape};
  const simd::AskShape ask = [](void* context, std::int32_t triangle, float limit) -> float {
    First& f = *static_cast<First*>(context);
    const Meeting met = meeting_with_triangle(f.mesh, triangle, f.sweep, f.local, f.shape);
    const std::int32_t given = f.mesh.given[triangle];
    if (met.time < f.met.time || (met.time == f.met.time && met.time < kNever && given < f.given)) {
      f.met = met;
      f.given = given;
    }
    return limit;
  };
  kernels.meet_mesh(mesh, task_of(local, sweep.radius), 0.0f, ask, &first);
  first.met.normal = queries::to_vec3(axes * queries::to_vector(first.met.normal));
  return first.met;
}

bool is_near_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose, Vec3 start,
                  Vec3 end, float radius) {
  constexpr double kRounding = 4e-6;  // of coordinates: more than places of balls in floats are off by
  const Axes axes = queries::to_axes(to_quat(pose.rotation));
  const Vector position = queries::to_vector(pose.position);
  const Vector a = queries::to_vector(start), b = queries::to_vector(end);
  const Vector from = turn_back(axes, a - position), to = turn_back(axes, b - position);
  const double scale = queries::length(a) + queries::length(b) + queries::length(from) + queries::length(to);
  const double room = double{radius} + kRounding * (scale + double{radius});
  simd::MeetTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    task.lower[axis] = static_cast<float>(std::min(from[axis], to[axis]) - room);
    task.upper[axis] = static_cast<float>(std::max(from[axis], to[axis]) + room);
  }
  bool any = false;
  const simd::AskShape ask = [](void* context, std::int32_t, float) -> float {
    *static_cast<bool*>(context) = true;
    return -1.0f;  // one will do
  };
  kernels.meet_mesh(mesh, task, 0.0f, ask, &any);
  return any;
}

}  // namespace scree::sweeps
