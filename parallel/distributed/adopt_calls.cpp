// What calls have done since the last step, which all ranks have made alike: bodies that come get owners,
// those that go leave the lists, and those that change their type become everybody's or one rank's. See
// border.h.
#include <parallel/distributed/body_motion.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <scree/error.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

// What calls ask of the lists.
struct Changes {
  std::vector<std::int32_t> gone;                        // from all lists of ghosts
  std::vector<std::int32_t> ghosts;                      // new bodies of others, which are here
  std::vector<std::vector<std::int32_t>> became_common;  // by rank: its bodies that all ranks move now
};

bool is_dynamic(const Bodies& bodies, std::int32_t body) {
  return (bodies.flags[body] & kBodyAlive) != 0 && bodies.type[body] == BodyType::dynamic;
}

void adopt(WorldData& data, Border& border, std::int32_t body, Changes& changes) {
  const auto place = static_cast<std::size_t>(body);
  std::int32_t& owner = border.owner[place];
  const bool is_another =
      std::exchange(border.generation[place], data.bodies.generation[body]) != data.bodies.generation[body];
  const bool dynamic = is_dynamic(data.bodies, body), was_owned = owner != kEveryRank;
  if (dynamic && was_owned && !is_another) return;
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
  const std::int32_t here = border.transport.rank(), ranks = border.transport.ranks();
  const std::vector<std::int32_t>& own = changes.became_common[static_cast<std::size_t>(here)];
  for (std::int32_t to = 0; to < ranks && !own.empty(); ++to) {
    if (to != here) send_bodies(border, to, data, own);
  }
  for (std::int32_t from = 0; from < ranks; ++from) {
    const std::vector<std::int32_t>& bodies = changes.became_common[static_cast<std::size_t>(from)];
    if (from != here && !bodies.empty()) receive_bodies(border, from, data, bodies);
  }
}

}  // namespace

void adopt_calls(WorldData& data, Border& border) {
  Bodies& bodies = data.bodies;
  border.owner.resize(bodies.flags.size(), kEveryRank);
  border.generation.resize(bodies.flags.size(), 0);
  if (!bodies.lists_dirty && data.shapes.dirty.empty()) return;
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
  hide_shapes(data);
}

}  // namespace scree
