// The border of a rank: what its step shares with the steps of other ranks, so that all of them together
// compute what a single process does, bit for bit.
//
// Dynamic bodies belong to one rank each, the others to all. A rank collides and solves the pairs and joints
// in which one of its bodies takes part. So those across a border are computed on both sides, from the same
// numbers, and no impulse travels but those of hubs. What must agree is exchanged: bodies that come near,
// colors while they are chosen, velocities before each color that needs one, motion at the end of a step.
//
// Of the bodies of others a rank has those that its own ones may touch or are jointed to: ghosts. All further
// ones are absent. Yet each rank has rows for all bodies, with the columns that are kOnAllRanks, and rows
// have the same numbers on all ranks, so all orders by row are the same. What else is in the row of an absent
// body says nothing, and its memory may be given up. Ghosts sleep and wake as their owners say.
#pragma once

#include <core/world/world_data.h>
#include <parallel/constraints/sort_constraints.h>
#include <parallel/crew/crew.h>
#include <parallel/distributed/counted_transport.h>

#include <algorithm>
#include <concepts>
#include <functional>
#include <iterator>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace scree {

inline constexpr std::int32_t kEveryRank = -1;  // owns what no constraint pushes

// Bodies whose rows go one way, turn by turn; the last turn is the end of a pass.
struct BodiesByTurn {
  std::vector<std::int32_t> bodies = {};
  std::vector<std::int32_t> ends = {};  // by turn

  std::span<const std::int32_t> at(std::int32_t turn) const {
    const auto place = static_cast<std::size_t>(turn);
    const auto begin = static_cast<std::size_t>(turn == 0 ? 0 : ends[place - 1]);
    return std::span(bodies).subspan(begin, static_cast<std::size_t>(ends[place]) - begin);
  }
};

// A rank with which this one has constraints in common, in this step.
struct Neighbor {
  std::int32_t rank;
  // Both sides list these in the same order.
  std::vector<std::int32_t> edges = {};      // places of the constraints
  std::vector<std::int32_t> uncolored = {};  // of these, those that need a color still
  std::vector<std::int32_t> own = {};        // bodies of this rank in them, ascending
  std::vector<std::int32_t> other = {};      // bodies of that rank
  // What constraints have changed since, before those of a turn: own bodies, bodies of that rank.
  BodiesByTurn sent = {}, received = {};
  // What the constraints of a turn with hubs have changed: bodies of that rank, own bodies.
  BodiesByTurn returned = {}, taken = {};
  std::vector<std::int32_t> returned_once = {}, taken_once = {};  // the same bodies, each once, ascending
};

// Own shapes of bodies that sleep. Bodies that fall asleep are appended, and those that wake, go or have
// changed stay until the list is made anew: who reads it asks rests_here(). So a step costs by what has
// changed, not by what sleeps.
struct RestingShapes {
  Column<std::int32_t> shapes;
  BoundsRow box = {};       // around all of them, in whose padding there is nothing
  std::size_t added = 0;    // since the list was made anew
  bool is_stale = false;    // most of what was asked for has gone
  std::uint64_t lists = 0;  // made so far
};

// Which bodies are where, of this rank and another one. Both sides have the same lists, which ascend.
struct Halo {
  std::vector<std::int32_t> lent = {};      // own bodies that are ghosts there
  std::vector<std::int32_t> borrowed = {};  // its bodies that are ghosts here
  std::vector<std::int32_t> near = {};      // own shapes in the box around its shapes
  // Of resting ones, those that were near, how many of the list were looked at, which list, and which box.
  std::vector<std::int32_t> near_resting = {};
  std::size_t resting_seen = 0;
  std::uint64_t resting_list = 0;
  BoundsRow resting_box = {};
  std::vector<std::int32_t> tied = {};  // own bodies with joints to bodies there; may repeat
};

// Written by divide_world and the functions below.
struct Border final : Part {
  Border(Transport& messages, std::vector<std::int32_t> owners)
      : transport(messages), owner(std::move(owners)), halos(static_cast<std::size_t>(messages.ranks())) {}
  void report(const char* store, const Visit& visit) const override;

  bool owns(std::int32_t body) const { return owner_of(body) == here; }
  std::int32_t owner_of(std::int32_t body) const { return owner[static_cast<std::size_t>(body)]; }

  CountedTransport transport;
  const std::int32_t here = transport.rank();
  std::vector<std::int32_t> owner;        // by body: rank, or kEveryRank
  std::vector<std::uint32_t> generation;  // by row: of the body whose owner that is
  // Of bodies that calls have created fixed: in `generation` they come when they are another type.
  std::unordered_map<std::int32_t, std::uint32_t> fixed_later;
  std::function<std::int32_t(std::int32_t body)> owner_of_new;  // of bodies that calls create
  std::vector<Halo> halos;                                      // by rank
  bool halos_stale = true;             // the world was just shared out: nobody knows what is lent
  bool ties_stale = true;              // owners or joints have changed
  bool events_stale = true;            // owners have changed: others may tell of what touched here
  std::vector<std::int32_t> ghosts;    // all bodies of others that are here, ascending
  bool is_giving = false;              // one rank makes calls for all, and the others wait for these
  std::size_t dirty_before = 0;        // how many of Shapes::dirty let_go_of_given() has looked at
  std::size_t gone = 0;                // bodies that have become absent since give_up_rows()
  Column<std::int32_t> own_shapes;     // that are there, of dynamic bodies that are awake
  RestingShapes resting;               // of those that sleep
  std::vector<BoundsRow> around;       // of this step, by rank: all its shapes
  Column<std::int32_t> places, found;  // of list_where
  std::vector<Neighbor> neighbors;     // of this step, ascending
  std::vector<std::uint8_t> waits;     // by body, while colors are chosen: an earlier constraint has none yet
  bool has_ended = false;              // the step, and all that is left is what a hook has thrown
  bool is_recorded = false;            // rank 0 records all ranks' world
  std::vector<std::pair<std::int32_t, std::int32_t>>
      levels;                                 // of this step: edges without a color, and theirs
  std::int32_t begin_hubs = 0, end_hubs = 0;  // turns of this step, of contacts in groups
  std::int32_t turns = 0;  // of this step: colors in use, in the order in which they are solved
};

// Whether a body belongs to one rank; the others are everybody's, or dead.
inline bool is_shared_out(const Bodies& bodies, std::integral auto body) {
  return (bodies.flags[body] & kBodyAlive) != 0 && bodies.type[body] == BodyType::dynamic;
}

// Whether an own shape of RestingShapes is what it was.
inline bool rests_here(const WorldData& data, const Border& border, std::int32_t shape) {
  const std::int32_t body = data.shapes.body[shape];
  return (data.shapes.flags[shape] & kShapeAlive) != 0 && data.shapes.tree[shape] != TreeKind::none &&
         border.owns(body) && (data.bodies.flags[body] & kBodyAsleep) != 0;
}

// Of the body in a row. A body that comes into the row of a dead one has the generation that is there: then
// it is another number.
inline std::uint32_t known_generation(const Bodies& bodies, std::size_t row) {
  return bodies.generation[row] - ((bodies.flags[row] & kBodyAlive) != 0 ? 0u : 1u);
}

inline Border* border_of(const WorldData& data) { return static_cast<Border*>(data.border.get()); }

// Makes a world the part of a rank: it solves what one of its bodies takes part in. `owner`: the rank of each
// row of bodies that is a dynamic body. All ranks give worlds of the same state, and call step together.
// Throws Error for a world that a Recorder records, and for owners that are no ranks.
void divide_world(WorldData& data, Transport& transport, std::vector<std::int32_t> owner);

// Gives bodies of this rank to others, with all that is known of their pairs and joints. All ranks call it
// together, between two steps, each for its own bodies. Throws Error for what is not this rank's to give,
// which leaves the other ranks waiting.
struct GivenBody {
  std::int32_t body, to;
};
void give_bodies(WorldData& data, std::span<const GivenBody> given, Crew& crew);

// Files hold what is sent: rises where that changes in a way that sizes of columns do not show.
inline constexpr std::uint64_t kMessageLayout = 4;
// Sends all bodies of this rank, which stays what it is, to who has none of them. `transport` goes to nobody
// else, and need not have such a rank.
void send_all_bodies(WorldData& data, Transport& transport, Crew& crew);
// Takes bodies that have been sent so, by some ranks of another transport. All of them must be this rank's
// already, and none of them here; those that are this rank's must all be among them.
void receive_all_bodies(WorldData& data, Transport& transport, std::span<const std::int32_t> senders,
                        Crew& crew);

// The world has been shared out: what is here of others stays until its owner does not lend it in the next
// step.
void forget_halos(WorldData& data, Border& border);

// The part of World::hash that is this rank's to add: the parts of all ranks sum up to it.
std::uint64_t hash_of_part(const WorldData& data, const Border& border);
// That sum. All ranks call it together.
std::uint64_t hash_of_all(const WorldData& data, Border& border);

// At the beginning of a step: throws Error within a rank's calls of give(), and on all ranks for new bodies
// that check_position() refuses.
void check_border(const WorldData& data);
// What all ranks do together must not be done in a rank's calls of give(): throws Error there.
void check_not_giving(const Border& border);
// Throws Error for a body whose position floats cannot hold well enough; of those that calls have created
// since the last step, all ranks find the same, and nothing has been changed then. Fixed bodies are in no
// list of changes: they are looked at when they become dynamic.
void check_position(const Bodies& bodies, std::int32_t body);
void check_positions(const WorldData& data);  // of all dynamic bodies that are here
void check_new_bodies(const WorldData& data, const Border& border);
// Takes up what calls have done to bodies since the last step. May be called before that, too.
void adopt_calls(WorldData& data, Border& border);

// Before pairs are found: brings the ghosts that own bodies may meet in this step, and sends others away. The
// lists of what moves are stale then.
void share_ghosts(WorldData& data, Crew& crew);
// Bodies of others have come within a step: puts them into lists and trees. What else has changed in this
// step must not enter its tree before the next pairs are found: in one process it does not, either.
void enter_ghosts(WorldData& data, std::span<const std::int32_t> come, Crew& crew);
// When all is where it is at the end of the step: brings bodies whose shapes sensors see unforeseen. No calls
// and no changes of bodies' types may wait to be taken up. See bring_sights.cpp.
void bring_sights(WorldData& data, Crew& crew);

// Where many bodies have become absent: gives up the memory of their rows.
void give_up_rows(WorldData& data, Border& border);
// Gives up those of absent bodies from the first to the last of these bodies, and of these shapes.
void give_up_rows_among(WorldData& data, const std::vector<std::int32_t>& bodies,
                        const std::vector<std::int32_t>& shapes);

// Whether a rank knows what these bodies share. True without a border.
inline bool knows(const Border* border, std::int32_t body_a, std::int32_t body_b) {
  return border == nullptr || border->owns(body_a) || border->owns(body_b);
}

// Whether a rank tells of what happens between two bodies: it moves one of them, or both are everybody's.
inline bool tells_of(const Border* border, std::int32_t body_a, std::int32_t body_b) {
  return knows(border, body_a, body_b) ||
         (border->owner_of(body_a) == kEveryRank && border->owner_of(body_b) == kEveryRank);
}

// Whether a rank says for all what a body is: its own ones, and rank 0 those that are everybody's.
inline bool speaks_for(const Border& border, std::int32_t body) {
  const std::int32_t owner = border.owner_of(body);
  return owner == border.here || (owner == kEveryRank && border.here == 0);
}

// Whether a rank computes a constraint that it knows. Those of a hub are solved together, so the hub's owner
// computes them alone, and returns what they do to the other bodies.
inline bool computes(const Border& border, const Edge& edge) {
  return !is_grouped(edge) || border.owns(edge.kind == EdgeKind::hub_a ? edge.body_a : edge.body_b);
}

// Lists the neighbors and the constraints across their borders; gives bodies of others the numbers of
// constraints that they have.
void meet_neighbors(Constraints& constraints, Border& border);
// Tells which kept colors of bodies at the border clash.
void share_clashes(Constraints& constraints, Border& border);
// Colors Constraints::uncolored in their order (coloring.h), together with the neighbors.
void color_across(Constraints& constraints, Border& border);
// Numbers of constraints by place -> those of the whole world.
void count_everywhere(const Constraints& constraints, Border& border, std::span<std::int64_t> in_place);
// When the constraints of a place are solved.
inline constexpr std::int32_t kNoTurn = -1;
struct Turns {
  Turns() {
    std::fill(std::begin(of_joints), std::end(of_joints), kNoTurn);
    std::fill(std::begin(of_contacts), std::end(of_contacts), kNoTurn);
  }
  std::int32_t count = 0;
  std::int32_t of_joints[kColorPlaces];
  std::int32_t of_contacts[kColorPlaces];
  std::vector<std::int32_t> of_joint_levels = {}, of_contact_levels = {};  // of place 0
};

// The levels of Constraints::overflow_edges among those of all ranks -> overflow_levels and Border::levels.
// `sizes`: how many constraints each level has in the whole world. All ranks call it together.
void level_across(const WorldData& data, Constraints& constraints, Border& border,
                  Column<std::int32_t>& sizes);

// Decides which velocities are sent when. `first_joint`: of the edges.
void plan_refreshes(const Constraints& constraints, Border& border, std::int32_t first_joint,
                    const Turns& turns);
// Tells what the step has noted of bodies at the border: a body flies free only if no rank knows a contact.
// `contacts`: how many of the edges are contacts.
void share_notes(const Constraints& constraints, Border& border, std::int32_t contacts, Bodies& bodies);
// Tells the times of impacts of bodies at the border, which contacts that both ranks of a border compute find
// on both sides, but those in groups at the hub's owner alone. So that one keeps them apart: the times at
// bodies of others are those in groups while these are looked at.
class SharedImpactTimes {
 public:
  SharedImpactTimes(Constraints& constraints, Border* border) : constraints_(constraints), border_(border) {}
  // Before the contacts of this turn; turns ascend. Solvers that rebound keep the groups' turns together.
  void before(std::int32_t turn);
  // After all contacts. `found`: any rank has impacts.
  void finish(bool found);

 private:
  Constraints& constraints_;
  Border* border_;
  bool has_begun_ = false, has_ended_ = false;  // the turns of groups
  std::vector<simd::ImpactTimes> of_groups_;
};

// What constraints change of bodies: velocities, and in impacts where the body is.
enum class Refreshed : std::uint8_t { velocity, delta };

// A pass over the colors, before each of which ranks exchange what constraints of other ranks have changed.
// Does nothing in a world that is not divided.
class RefreshedPass {
 public:
  RefreshedPass(Border* border, Bodies& bodies, Refreshed what)
      : border_(border), bodies_(bodies), what_(what) {}
  // Before the constraints of this turn; turns ascend.
  void before(std::int32_t turn) {
    while (border_ != nullptr && next_turn_ <= turn) refresh(next_turn_++);
  }
  // After all constraints.
  void finish() {
    if (border_ != nullptr) before(border_->turns);
  }

 private:
  void refresh(std::int32_t turn);
  template <class Row>
  void exchange(std::int32_t turn, Column<Row>& rows);
  Border* border_;
  Bodies& bodies_;
  Refreshed what_;
  std::int32_t next_turn_ = 0;
};

// Tells what hubs' constraints have borne: for the other rank's warm start once the hub is none any more, and
// for its events.
void share_impulses(const Constraints& constraints, Border& border, WorldData& data);
// Joints that have broken on any rank: all ranks disable them.
void share_broken(Border& border, const WorldData& data, Column<JointId>& broken);
// The end of the solver: ghosts move as their owners say.
void share_motion(Border& border, Bodies& bodies);

}  // namespace scree
