// Sweeps of balls against meshes; see sweep_mesh.h. Works in the mesh's frame and in double precision: a mesh
// may reach far, and have large triangles.
#include <core/world/edit.h>
#include <parallel/continuous/sweep_mesh.h>
#include <parallel/queries/query_math.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

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

// Of a ball's radius: more than its core's, with the tolerance of core_of().
constexpr double kClearShare = double{kCoreShare} + 0.03;

// Whether the core of a ball that comes down ends its way clear of the triangle's plane, so that it meets no
// triangle in it. Most balls of bodies that roll or tumble over a mesh do.
bool ends_above(const TriangleObstacle& obstacle, Vector normal, const Sweep& sweep,
                const LocalSweep& local) {
  constexpr double kRounding = 4e-6;  // of the way, which first_within() has in floats
  const double most = kClearShare * double{sweep.radius} + kRounding * queries::length(local.motion);
  const double height = dot(normal, local.motion - obstacle.corner[0]);  // times the normal's length
  return height > 0.0 && height * height > most * most * dot(normal, normal);
}

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
  if (ends_above(obstacle, normal, sweep, local)) return {};
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

// A box about a way of a ball, with room for what places of balls in floats are off by.
simd::MeetTask task_of(const PoseRow& pose, const MeshReach& reach) {
  constexpr double kRounding = 4e-6;  // of coordinates: more than that
  const Axes axes = queries::to_axes(to_quat(pose.rotation));
  const Vector position = queries::to_vector(pose.position);
  const Vector a = queries::to_vector(reach.start), b = queries::to_vector(reach.end);
  const Vector from = turn_back(axes, a - position), to = turn_back(axes, b - position);
  const double scale = queries::length(a) + queries::length(b) + queries::length(from) + queries::length(to);
  const double room = double{reach.radius} + kRounding * (scale + double{reach.radius});
  simd::MeetTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    task.lower[axis] = static_cast<float>(std::min(from[axis], to[axis]) - room);
    task.upper[axis] = static_cast<float>(std::max(from[axis], to[axis]) + room);
  }
  return task;
}

// A box about those of all ways within a box.
simd::MeetTask task_of(const PoseRow& pose, const Swept& box) {
  constexpr double kRounding = 5e-6;  // of coordinates: more than of each way, and than boxes in floats lose
  const Axes axes = queries::to_axes(to_quat(pose.rotation));
  const Vector lower{box.lower[0], box.lower[1], box.lower[2]},
      upper{box.upper[0], box.upper[1], box.upper[2]};
  const Vector middle = 0.5 * (lower + upper), half = 0.5 * (upper - lower);
  const Vector center = turn_back(axes, middle - queries::to_vector(pose.position));
  const double far = queries::length(middle) + queries::length(center);
  const double rounding = kRounding * (2.0 * far + 5.0 * queries::length(half));
  simd::MeetTask task{};
  int axis = 0;
  for (const Vector& along : {axes.x, axes.y, axes.z}) {
    const double room =
        std::abs(along.x) * half.x + std::abs(along.y) * half.y + std::abs(along.z) * half.z + rounding;
    task.lower[axis] = static_cast<float>(center[axis] - room);
    task.upper[axis] = static_cast<float>(center[axis] + room);
    ++axis;
  }
  return task;
}

bool meets(const MeshData& mesh, std::int32_t triangle, const simd::MeetTask& task) {
  const float* corner[3];
  for (int i = 0; i < 3; ++i) corner[i] = mesh.vertex + std::ptrdiff_t{3} * mesh.corners[triangle].vertex[i];
  for (int axis = 0; axis < 3; ++axis) {
    const auto [lower, upper] = std::minmax({corner[0][axis], corner[1][axis], corner[2][axis]});
    if (!(lower <= task.upper[axis] && task.lower[axis] <= upper)) return false;
  }
  return true;
}

// Calls call(triangle) for those whose boxes meet the task's, until it returns false.
template <class Call>
void for_each_near(const simd::QueryKernels& kernels, const MeshData& mesh, const simd::MeetTask& task,
                   const NearTriangles* near, Call&& call) {
  if (near != nullptr && !near->too_many) {
    for (int i = 0; i < near->count; ++i) {
      if (meets(mesh, near->row[i], task) && !call(near->row[i])) return;
    }
    return;
  }
  const simd::AskShape ask = [](void* context, std::int32_t triangle, float limit) -> float {
    constexpr float kEnd = -1.0f;
    return (*static_cast<std::remove_reference_t<Call>*>(context))(triangle) ? limit : kEnd;
  };
  kernels.meet_mesh(mesh, task, 0.0f, ask, &call);
}

}  // namespace

Meeting meeting_with_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                          const Sweep& sweep, std::int32_t shape, const NearTriangles* near) {
  const Axes axes = queries::to_axes(to_quat(pose.rotation));
  const Vector position = queries::to_vector(pose.position);
  const auto place = [&](Vec3 point) { return turn_back(axes, queries::to_vector(point) - position); };
  LocalSweep local{place(sweep.origin), place(sweep.start), {}};
  local.motion = place(sweep.end) - local.start;
  Meeting first;
  std::int32_t first_given = -1;
  for_each_near(kernels, mesh, task_of(local, sweep.radius), near, [&](std::int32_t triangle) {
    const Meeting met = meeting_with_triangle(mesh, triangle, sweep, local, shape);
    const std::int32_t given = mesh.given[triangle];
    if (met.time < first.time || (met.time == first.time && met.time < kNever && given < first_given)) {
      first = met;
      first_given = given;
    }
    return true;
  });
  first.normal = queries::to_vec3(axes * queries::to_vector(first.normal));
  return first;
}

void list_near_triangles(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                         const MeshReach& reach, NearTriangles& near) {
  near.count = 0;
  near.too_many = false;
  for_each_near(kernels, mesh, task_of(pose, reach), nullptr, [&](std::int32_t triangle) {
    near.too_many = near.count == NearTriangles::kMost;
    if (!near.too_many) near.row[near.count++] = triangle;
    return !near.too_many;
  });
}

void drop_triangles_below(const MeshData& mesh, const PoseRow& pose, std::span<const Ball> ends, float room,
                          NearTriangles& near) {
  const Axes axes = queries::to_axes(to_quat(pose.rotation));
  const Vector position = queries::to_vector(pose.position);
  Vector place[kMostEnds];
  double most[kMostEnds];
  for (std::size_t i = 0; i < ends.size(); ++i) {
    place[i] = turn_back(axes, queries::to_vector(ends[i].center) - position);
    most[i] = kClearShare * double{ends[i].radius} + double{room};
  }
  int left = 0;
  for (int k = 0; k < near.count; ++k) {
    Vector corner[3];
    for (int i = 0; i < 3; ++i) {
      const float* vertex = mesh.vertex + std::ptrdiff_t{3} * mesh.corners[near.row[k]].vertex[i];
      corner[i] = {vertex[0], vertex[1], vertex[2]};
    }
    const Vector normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double size = dot(normal, normal), start = dot(normal, corner[0]);
    bool are_above = true;
    for (std::size_t i = 0; i < ends.size() && are_above; ++i) {
      const double height = dot(normal, place[i]) - start;
      are_above = height > 0.0 && height * height > most[i] * most[i] * size;
    }
    if (!are_above) near.row[left++] = near.row[k];
  }
  near.count = left;
}

bool is_near_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                  const MeshReach& reach, const NearTriangles* near) {
  bool any = false;
  for_each_near(kernels, mesh, task_of(pose, reach), near, [&](std::int32_t) {
    any = true;
    return false;
  });
  return any;
}

bool is_near_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                  const Swept& box) {
  bool any = false;
  for_each_near(kernels, mesh, task_of(pose, box), nullptr, [&](std::int32_t) {
    any = true;
    return false;
  });
  return any;
}

}  // namespace scree::sweeps
