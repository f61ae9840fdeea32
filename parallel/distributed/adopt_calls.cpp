// What calls have done since the last step, which all ranks have made alike: bodies that come get owners,
// those that go leave the lists, and those that change their type become everybody's or one rank's. See
// border.h.
#include <core/constraints/joint_parameters.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/give_events.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/send_bodies.h>
#include <scree/error.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

// What calls ask of the lists.
struct Changes {
  std::vector<std::pair<std::int32_t, std::int32_t>>
      owners;                                            // bodies with others than before, and that owner
  std::vector<std::int32_t> gone;                        // from all lists of ghosts
  std::vector<std::int32_t> ghosts;                      // new bodies of others, which are here
  std::vector<std::vector<std::int32_t>> became_common;  // by rank: its bodies that all ranks move now
  std::vector<std::int32_t> retyped;                     // these, and bodies that were everybody's
};

// Fixed bodies that calls create are in no list of what has changed, but their shapes are.
void note_fixed(const WorldData& data, Border& border) {
  for (const std::int32_t shape : data.shapes.dirty) {
    const std::int32_t body = data.shapes.body[shape];
    const auto row = static_cast<std::size_t>(body);
    if ((data.shapes.flags[shape] & kShapeAlive) != 0 && data.bodies.type[body] == BodyType::fixed &&
        border.generation[row] != known_generation(data.bodies, row))
      border.fixed_later[body] = data.bodies.generation[body];
  }
}

// Whether the body was a fixed one that note_fixed() has seen.
bool was_fixed(const WorldData& data, Border& border, std::int32_t body) {
  const auto found = border.fixed_later.find(body);
  if (found == border.fixed_later.end()) return false;
  const std::uint32_t generation = found->second;
  border.fixed_later.erase(found);
  return generation == data.bodies.generation[body];
}

void adopt(WorldData& data, Border& border, std::int32_t body, Changes& changes) {
  const auto place = static_cast<std::size_t>(body);
  std::int32_t& owner = border.owner[place];
  const bool is_another = std::exchange(border.generation[place], known_generation(data.bodies, place)) !=
                          data.bodies.generation[body];
  const bool dynamic = is_shared_out(data.bodies, body), was_owned = owner != kEveryRank;
  if (dynamic == was_owned && !(dynamic && is_another)) return;
  if ((data.bodies.flags[body] & kBodyAlive) != 0 && (!is_another || was_fixed(data, border, body)))
    changes.retyped.push_back(body);
  if (was_owned) {
    changes.gone.push_back(body);
    if (!is_another && (data.bodies.flags[body] & kBodyAlive) != 0) {
      changes.became_common[static_cast<std::size_t>(owner)].push_back(body);
    } else {
      data.bodies.is_absent[body] = 0;  // the row is that of another body, or of none
    }
  }
  if (dynamic && !border.owner_of_new)
    throw Error("step: body " + std::to_string(body) + " was created since divide_world");
  changes.owners.push_back({body, is_another ? kEveryRank : owner});
  owner = dynamic ? border.owner_of_new(body) : kEveryRank;
  if (dynamic && !border.owns(body)) changes.ghosts.push_back(body);
}

void drop(const std::vector<std::int32_t>& gone, std::vector<std::int32_t>& list) {
  std::erase_if(list, [&](std::int32_t body) { return std::binary_search(gone.begin(), gone.end(), body); });
}

// Shapes that calls have added to bodies that are not here.
void hide_shapes(WorldData& data) {
  Shapes& shapes = data.shapes;
  for (const std::int32_t shape : shapes.dirty) {
    if ((shapes.flags[shape] & kShapeAlive) == 0 || data.bodies.is_absent[shapes.body[shape]] == 0) continue;
    if (shapes.tree[shape] == TreeKind::none) continue;
    shapes.tree[shape] = TreeKind::none;
    note_change(shapes, shape);
  }
}

void share_common(WorldData& data, Border& border, const Changes& changes) {
  place_matter(data);
  const std::int32_t here = border.transport.rank(), ranks = border.transport.ranks();
  const std::vector<std::int32_t>& own = changes.became_common[static_cast<std::size_t>(here)];
  for (std::int32_t to = 0; to < ranks && !own.empty(); ++to) {
    if (to != here) send_bodies(border.transport, to, data, own);
  }
  for (std::int32_t from = 0; from < ranks; ++from) {
    const std::vector<std::int32_t>& bodies = changes.became_common[static_cast<std::size_t>(from)];
    if (from != here && !bodies.empty()) receive_bodies(border.transport, from, data, bodies);
  }
}

// Joints of bodies whose owner has changed, each once.
std::vector<std::int32_t> joints_of(const WorldData& data, const Changes& changes) {
  std::vector<std::int32_t> joints;
  for (const auto& [body, before] : changes.owners) {
    for (std::int32_t joint = data.bodies.first_joint[body]; joint >= 0;
         joint = next_joint(data.joints, joint, body))
      joints.push_back(joint);
  }
  keep_each_once(joints);
  return joints;
}

// By rank.
using JointLists = std::vector<std::vector<std::int32_t>>;

// Who has solved a joint tells who will, or all ranks where nobody does for now. All ranks know who that is.
void list_joints(const WorldData& data, const Border& border, const Changes& changes, JointLists& sent,
                 JointLists& received) {
  const auto owner_before = [&](std::int32_t body) {
    const auto found =
        std::lower_bound(changes.owners.begin(), changes.owners.end(), std::pair(body, kEveryRank));
    return found != changes.owners.end() && found->first == body ? found->second : border.owner_of(body);
  };
  for (const std::int32_t joint : joints_of(data, changes)) {
    const JointBodies ends = data.joints.bodies[joint];
    const std::int32_t before[2] = {owner_before(ends.a), owner_before(ends.b)};
    const std::int32_t after[2] = {border.owner_of(ends.a), border.owner_of(ends.b)};
    const std::int32_t sender = before[0] != kEveryRank ? before[0] : before[1];
    if (sender == kEveryRank) continue;  // all ranks know it
    const bool rests = after[0] == kEveryRank && after[1] == kEveryRank;
    for (std::int32_t to = 0; std::cmp_less(to, sent.size()); ++to) {
      if (to == before[0] || to == before[1] || !(rests || to == after[0] || to == after[1])) continue;
      if (sender == border.here) sent[static_cast<std::size_t>(to)].push_back(joint);
      if (to == border.here) received[static_cast<std::size_t>(sender)].push_back(joint);
    }
  }
}

void share_joints(WorldData& data, Border& border, Changes& changes) {
  std::sort(changes.owners.begin(), changes.owners.end());
  JointLists sent(border.halos.size()), received(border.halos.size());
  list_joints(data, border, changes, sent, received);
  for (std::int32_t to = 0; std::cmp_less(to, sent.size()); ++to) {
    const std::vector<std::int32_t>& joints = sent[static_cast<std::size_t>(to)];
    if (joints.empty()) continue;
    send_rows<SentJoint>(border.transport, to, joints,
                         [&](std::int32_t joint) { return sent_joint(data.joints, joint); });
  }
  for (std::int32_t from = 0; std::cmp_less(from, received.size()); ++from) {
    const std::vector<std::int32_t>& joints = received[static_cast<std::size_t>(from)];
    if (joints.empty()) continue;
    receive_rows<SentJoint>(border.transport, from, joints, [&](std::int32_t joint, const SentJoint& row) {
      if (row.joint != joint) refuse_world_of(from);
      take_joint(data.joints, row);
    });
  }
}

}  // namespace

void adopt_calls(WorldData& data, Border& border) {
  Bodies& bodies = data.bodies;
  border.owner.resize(bodies.flags.size(), kEveryRank);
  border.generation.resize(bodies.flags.size(), 0);
  if (!bodies.lists_dirty && data.shapes.dirty.empty()) return;
  check_new_bodies(data, border);
  note_fixed(data, border);
  Changes changes;
  changes.became_common.resize(border.halos.size());
  if (bodies.all_changed) {
    for (std::size_t body = 0; body < border.owner.size(); ++body)
      adopt(data, border, static_cast<std::int32_t>(body), changes);
  } else {
    for (const std::int32_t body : bodies.changed) adopt(data, border, body, changes);
  }
  std::sort(changes.gone.begin(), changes.gone.end());
  for (std::vector<std::int32_t>& list : changes.became_common) std::sort(list.begin(), list.end());
  if (!changes.gone.empty()) {
    for (Halo& halo : border.halos) {
      drop(changes.gone, halo.lent);
      drop(changes.gone, halo.borrowed);
    }
    drop(changes.gone, border.ghosts);
    border.ties_stale = true;
  }
  border.ghosts.insert(border.ghosts.end(), changes.ghosts.begin(), changes.ghosts.end());
  std::sort(border.ghosts.begin(), border.ghosts.end());
  share_common(data, border, changes);
  share_joints(data, border, changes);
  if (!changes.retyped.empty()) {
    border.events_stale = true;
    share_events_of(data, border, changes.retyped);
  }
  hide_shapes(data);
}

}  // namespace scree
