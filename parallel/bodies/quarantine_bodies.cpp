// Quarantine: lists the bodies whose state became non-finite, which the kernels have put back at rest, and
// quarantines those at fault. Else they would become non-finite in every step, with all that they touch.
// Rare.
//
// A body is at fault if it became non-finite by its own motion, before any contact acted. Contacts and joints
// carry this to other bodies, which are not at fault. If no body of such a group became non-finite alone,
// these are at fault, the first kind that the group has:
//   1. bodies that contacts cannot handle: too light or too heavy for where the contact is; also those that
//      stayed finite and made only their neighbors non-finite,
//   2. bodies with joints: a joint may be asked to hold what cannot be held, a contact is not,
//   3. all bodies of the group.
#include <core/world/edit.h>
#include <parallel/constraints/constraints.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/stages.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace scree {

namespace {

constexpr std::int32_t kFinite = -1;

// Groups of suspects, the non-finite bodies and extreme ones at them, that contacts and joints connect. Every
// body has a parent of lower index in its group; a root is its own parent.
class Groups {
 public:
  Groups(std::size_t bodies, const std::vector<BodyId>& suspects) : parent_(bodies, kFinite) {
    for (const BodyId& body : suspects) parent_[body.index] = static_cast<std::int32_t>(body.index);
  }
  bool is_suspect(std::int32_t body) const { return parent_[static_cast<std::size_t>(body)] != kFinite; }
  std::int32_t root(std::int32_t body) {
    while (parent(body) != body) {
      parent(body) = parent(parent(body));
      body = parent(body);
    }
    return body;
  }
  void unite(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    parent(std::max(a, b)) = std::min(a, b);
  }

 private:
  std::int32_t& parent(std::int32_t body) { return parent_[static_cast<std::size_t>(body)]; }
  std::vector<std::int32_t> parent_;
};

// What ranks tell each other, if the world is divided: all decide alike then.
template <class Row, class IsSound>
std::vector<Row> of_all_ranks(const WorldData& data, std::vector<Row> rows, IsSound&& is_sound) {
  Border* const border = border_of(data);
  return border != nullptr ? gather_lists(border->transport, rows, is_sound) : rows;
}

std::vector<BodyId> of_all_ranks_once(const WorldData& data, std::vector<BodyId> bodies) {
  const Column<std::uint8_t>& flags = data.bodies.flags;
  bodies = of_all_ranks(data, std::move(bodies), [&](const BodyId& body) {
    return body.index < flags.size() && (flags[body.index] & kBodyAlive) != 0;
  });
  for (BodyId& body : bodies) body = body_handle(data, static_cast<std::int32_t>(body.index));
  keep_each_once(bodies);  // kinematic bodies stand behind the dynamic ones
  return bodies;
}

void list_restored(WorldData& data, const Constraints& constraints) {
  std::vector<BodyId> restored;
  for (std::size_t i = 0; i < constraints.non_finite.size(); ++i) {
    if (constraints.non_finite[i] == 0) continue;
    restored.push_back(body_handle(data, constraints.moving_bodies[i]));
  }
  for (const BodyId body : of_all_ranks_once(data, std::move(restored))) data.events.restored.push_back(body);
}

// How much a body is at fault, ascending.
enum class Fault : std::uint8_t { none, jointed, extreme, alone };

// Nothing but its own velocity moves a kinematic body.
bool became_non_finite_alone(const Bodies& bodies, std::size_t body) {
  return bodies.type[body] == BodyType::kinematic || (bodies.step_notes[body] & kNonFiniteAlone) != 0;
}

// A push of 1 N s changes the body's speed where it acts by its inverse mass at least, where it is directed
// at the center, and by `answer` at most, in m/s. Returns whether these leave the range in which the product
// of two such numbers is a float.
bool is_extreme(const InertiaRow& inverse, float distance) {
  constexpr float kLeast = 1e-18f, kMost = 1e18f;
  const float* i = inverse.inverse_inertia;
  const float answer = inverse.inverse_mass + distance * distance * (i[0] + i[3] + i[5]);
  return !(inverse.inverse_mass >= kLeast && answer <= kMost);
}

// The farthest point of a contact from a center of mass, or farther.
float reach_of(const Manifold& manifold, const float (&arm)[3]) {
  float farthest = 0.0f;
  const int points = static_cast<int>(manifold.info & kManifoldPointMask);
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    const float u = k < points ? std::abs(manifold.point_u[k]) : 0.0f;  // no cores
    farthest = std::max(farthest, u + std::abs(manifold.point_v[k]));
  }
  return length(to_vec3(arm)) + farthest;
}

bool is_extreme(const Bodies& bodies, std::int32_t body, const Manifold& manifold, const float (&arm)[3]) {
  return bodies.type[body] == BodyType::dynamic &&
         is_extreme(bodies.local_mass[body], reach_of(manifold, arm));
}

// The restored bodies, and the finite ones in contact with them that contacts cannot handle. Ascending.
std::vector<BodyId> list_suspects(const WorldData& data) {
  const Bodies& bodies = data.bodies;
  const Column<BodyId>& restored = data.events.restored;
  std::vector<BodyId> suspects(restored.begin(), restored.end());
  const auto is_restored = [&](std::int32_t body) {
    return std::binary_search(restored.begin(), restored.end(), body_handle(data, body));
  };
  for (const std::int32_t contact : data.contacts.active) {
    const Manifold& manifold = data.contacts.now.manifold[contact];
    const std::int32_t a = manifold.row_a, b = manifold.row_b;
    if (is_restored(a) == is_restored(b)) continue;
    const std::int32_t finite = is_restored(a) ? b : a;
    if (is_extreme(bodies, finite, manifold, finite == a ? manifold.arm_a : manifold.arm_b))
      suspects.push_back(body_handle(data, finite));
  }
  return of_all_ranks_once(data, std::move(suspects));
}

// What a contact or joint says of its bodies.
struct Finding {
  std::int32_t body;
  std::int32_t fault;  // of the body
  std::int32_t other;  // the suspect that it is connected with, or itself
};

// Finds the extreme and the jointed suspects, and which of them contacts and joints connect.
std::vector<Finding> judge_constraints(const WorldData& data, const Groups& groups) {
  const Bodies& bodies = data.bodies;
  std::vector<Finding> findings;
  const auto add = [&](std::int32_t body, Fault fault, std::int32_t other) {
    if (groups.is_suspect(body))
      findings.push_back({body, static_cast<std::int32_t>(fault), groups.is_suspect(other) ? other : body});
  };
  for (const std::int32_t contact : data.contacts.active) {
    const Manifold& manifold = data.contacts.now.manifold[contact];
    const std::int32_t a = manifold.row_a, b = manifold.row_b;
    const auto fault_of = [&](std::int32_t body, const float(&arm)[3]) {
      return groups.is_suspect(body) && is_extreme(bodies, body, manifold, arm) ? Fault::extreme
                                                                                : Fault::none;
    };
    add(a, fault_of(a, manifold.arm_a), b);
    add(b, fault_of(b, manifold.arm_b), a);
  }
  for (const std::int32_t joint : data.joints.active) {
    const JointBodies ends = data.joints.bodies[joint];
    add(ends.a, Fault::jointed, ends.b);
    add(ends.b, Fault::jointed, ends.a);
  }
  for (const BodyId& body : data.events.restored) {
    const auto row = static_cast<std::int32_t>(body.index);
    if (tells_of(border_of(data), row, row) && became_non_finite_alone(bodies, body.index))
      findings.push_back({row, static_cast<std::int32_t>(Fault::alone), row});
  }
  const auto rows = static_cast<std::int32_t>(bodies.pose.size());
  return of_all_ranks(data, std::move(findings), [&](const Finding& finding) {
    const auto is_suspect = [&](std::int32_t body) {
      return body >= 0 && body < rows && groups.is_suspect(body);
    };
    return is_suspect(finding.body) && is_suspect(finding.other) && finding.fault >= 0 &&
           finding.fault <= static_cast<std::int32_t>(Fault::alone);
  });
}

// A rank lists what happens to its own bodies.
void list_own(const WorldData& data, Column<BodyId>& bodies) {
  std::vector<BodyId> own;
  for (const BodyId body : bodies) {
    const auto row = static_cast<std::int32_t>(body.index);
    if (tells_of(border_of(data), row, row)) own.push_back(body);
  }
  bodies.clear();
  for (const BodyId body : own) bodies.push_back(body);
}

}  // namespace

void quarantine_bodies(WorldData& data) {
  list_restored(data, constraints_of(data));
  Column<BodyId>&restored = data.events.restored, &quarantined = data.events.quarantined;
  const std::vector<BodyId> suspects = list_suspects(data);
  const std::size_t rows = data.bodies.pose.size();
  Groups groups(rows, suspects);
  std::vector<Fault> faults(rows, Fault::none);
  for (const Finding& finding : judge_constraints(data, groups)) {
    Fault& fault = faults[static_cast<std::size_t>(finding.body)];
    fault = std::max(fault, static_cast<Fault>(finding.fault));
    groups.unite(finding.body, finding.other);
  }
  std::vector<Fault> worst(rows, Fault::none);  // of the group, by its root
  const auto worst_of_group = [&](const BodyId& body) -> Fault& {
    return worst[static_cast<std::size_t>(groups.root(static_cast<std::int32_t>(body.index)))];
  };
  for (const BodyId& body : suspects)
    worst_of_group(body) = std::max(worst_of_group(body), faults[body.index]);
  for (const BodyId& body : suspects) {
    if (faults[body.index] == worst_of_group(body)) quarantined.push_back(body);
  }
  const std::size_t were_non_finite = restored.size();
  for (const BodyId& body : quarantined) {
    quarantine(data, static_cast<std::int32_t>(body.index));
    const BodyId* const last = restored.begin() + were_non_finite;
    if (!std::binary_search(std::as_const(restored).begin(), last, body)) restored.push_back(body);
  }
  std::sort(restored.begin(), restored.end());
  if (data.border == nullptr) return;
  list_own(data, restored);
  list_own(data, quarantined);
}

}  // namespace scree
