// The nearest displacement that planes allow; see planes.h.
#include <parallel/mover/mover_limits.h>
#include <parallel/mover/planes.h>

#include <algorithm>
#include <array>

namespace scree::mover {

namespace {

constexpr double kParallel = 1e-9;  // of Gram determinants: planes that meet at less than 3e-5 rad

bool allows(std::span<const Plane> planes, Vector x, double tolerance) {
  return std::all_of(planes.begin(), planes.end(),
                     [&](const Plane& plane) { return dot(plane.normal, x) >= plane.least - tolerance; });
}

// Tries x = wanted + sum of factors times normals, with x on all of up to three planes. The nearest allowed
// point is the one that is allowed and has no factor below zero: the problem is convex.
bool holds_at(std::span<const Plane> planes, Vector wanted, double tolerance,
              std::span<const Plane* const> held, Vector& x) {
  const auto miss = [&](std::size_t i) { return held[i]->least - dot(held[i]->normal, wanted); };
  const auto normal = [&](std::size_t i) { return held[i]->normal; };
  double factor[3] = {0.0, 0.0, 0.0};
  if (held.size() == 1) {
    factor[0] = miss(0);
  } else if (held.size() == 2) {
    const double along = dot(normal(0), normal(1)), determinant = 1.0 - along * along;
    if (!(determinant > kParallel)) return false;
    factor[0] = (miss(0) - along * miss(1)) / determinant;
    factor[1] = (miss(1) - along * miss(0)) / determinant;
  } else {
    // The point that three planes share, and the factors that lead there.
    const Vector across[3] = {cross(normal(1), normal(2)), cross(normal(2), normal(0)),
                              cross(normal(0), normal(1))};
    const double volume = dot(normal(0), across[0]);
    if (!(volume * volume > kParallel)) return false;
    const Vector way = (1.0 / volume) * (miss(0) * across[0] + miss(1) * across[1] + miss(2) * across[2]);
    for (int i = 0; i < 3; ++i) factor[i] = dot(across[i], way) / volume;
  }
  x = wanted;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (factor[i] < 0.0) return false;
    x = x + factor[i] * normal(i);
  }
  return allows(planes, x, tolerance);
}

}  // namespace

bool nearest_allowed(std::span<const Plane> planes, Vector wanted, double tolerance, Vector& nearest) {
  nearest = wanted;
  if (allows(planes, wanted, tolerance)) return true;
  const std::size_t count = planes.size();
  std::array<const Plane*, 3> held{};
  for (std::size_t i = 0; i < count; ++i) {
    held[0] = &planes[i];
    if (holds_at(planes, wanted, tolerance, std::span(held).first(1), nearest)) return true;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      held = {&planes[i], &planes[j], nullptr};
      if (holds_at(planes, wanted, tolerance, std::span(held).first(2), nearest)) return true;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      for (std::size_t k = j + 1; k < count; ++k) {
        held = {&planes[i], &planes[j], &planes[k]};
        if (holds_at(planes, wanted, tolerance, held, nearest)) return true;
      }
    }
  }
  return false;
}

namespace {

// Planes that are nearly opposite have room only far away, where they are not what they are here: that is no
// way out. What planes push by, a way out may be some times as long.
bool is_near(std::span<const Plane> planes, Vector wanted, Vector found) {
  constexpr double kLongest = 2.0;  // a corner of three walls takes 1.7
  double push = 0.0;
  for (const Plane& plane : planes) push = std::max(push, plane.least);
  return length(found) <= 2.0 * length(wanted) + kLongest * push;
}

// With every plane let go by `give`.
bool nearest_with(std::span<const Plane> planes, Vector wanted, double tolerance, double give,
                  Vector& nearest) {
  std::array<Plane, kMostPlanes> looser{};
  std::copy(planes.begin(), planes.end(), looser.begin());
  for (Plane& plane : looser) plane.least -= give;
  return nearest_allowed(std::span(looser).first(planes.size()), wanted, tolerance, nearest) &&
         is_near(planes, wanted, nearest);
}

// Lets all planes give way by as little as leaves room, if that is no more than `most`.
bool give_way(std::span<const Plane> planes, Vector wanted, double tolerance, double most, Vector& nearest) {
  constexpr int kHalvings = 12;  // of `most`: finer than what the queries tell
  if (!nearest_with(planes, wanted, tolerance, most, nearest)) return false;
  double low = 0.0, high = most;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    Vector found;
    if (nearest_with(planes, wanted, tolerance, middle, found)) {
      high = middle;
      nearest = found;
    } else {
      low = middle;
    }
  }
  return true;
}

}  // namespace

Vector nearest_possible(std::span<const Plane> planes, Vector wanted, double tolerance, double give) {
  Vector nearest;
  if (nearest_with(planes, wanted, tolerance, 0.0, nearest)) return nearest;
  if (give_way(planes, wanted, tolerance, give, nearest)) return nearest;
  std::array<Plane, kMostPlanes> firm{};
  std::size_t count = 0;
  for (const Plane& plane : planes) {
    if (!plane.yields) firm[count++] = plane;
  }
  const std::span<const Plane> rest = std::span(firm).first(count);
  if (nearest_with(rest, wanted, tolerance, 0.0, nearest)) return nearest;
  // Far enough for the wanted displacement itself, so that something is found.
  double most = give;
  for (const Plane& plane : rest) most = std::max(most, plane.least - dot(plane.normal, wanted));
  if (give_way(rest, wanted, tolerance, most, nearest)) return nearest;
  return {};
}

}  // namespace scree::mover
