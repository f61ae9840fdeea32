// Player: makes the calls of a random sequence in one world and checks what every world promises.
#pragma once

#include <tests/determinism/player_values.h>
#include <tests/determinism/random_calls.h>

#include <array>
#include <functional>
#include <map>
#include <ostream>
#include <set>
#include <stdexcept>
#include <utility>

namespace scree::determinism {

// A world broke a promise.
class BrokenPromise : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Slots of bodies that are created one by one; the slots of bulk calls follow.
inline constexpr std::uint32_t kBulkSlots = 48;

// A player's record of its world: its objects, and the events that the world has reported.
struct Model {
  struct Slot {
    BodyId body;  // no body: the slot is empty
    std::vector<ShapeId> shapes;
    Pose last_pose;  // before the step that runs
    bool last_awake = false;
  };

  std::vector<Slot> slots;
  struct Joined {
    BodyId a, b;
    bool enabled;
  };

  std::map<JointId, Joined> joints;
  std::set<JointId> lost;  // destroyed with their bodies since the last step
  std::size_t bodies = 0;
  std::size_t shapes = 0;
  std::set<std::pair<ShapeId, ShapeId>> begun;
  std::set<BodyId> asleep;  // according to the events
};

// A snapshot that a player has taken: whole, or as changes from the first.
struct Saved {
  bool full = false;
  bool in_changes = false;
  Snapshot snapshot;
  SnapshotChanges changes;
  Model model;
};

std::vector<std::byte> bytes_of(const World& world);  // of a snapshot

// Acts as a program that looks ahead: creates and destroys bodies, changes settings, steps.
void lead_astray(World& world, Workers& workers);

class Player {
 public:
  // With `checks` the player reads all bodies around every step to test the promises. Reading must not change
  // results either, so one run of a comparison reads and the others do not.
  Player(Shift& shift, bool checks, std::ostream* log);

  // Called on the world before each of its steps.
  void before_steps(std::function<void(World&)> work) { before_step_ = std::move(work); }

  // Recorded worlds are never moved or assigned to.
  void stay_in_one_world() { one_world_ = true; }
  World& world() { return world_; }

  void make(const Call& call);
  const std::vector<std::uint64_t>& hashes() const { return hashes_; }
  std::int64_t most_contacts() const { return most_contacts_; }
  bool somebody_slept() const { return somebody_slept_; }
  std::size_t events() const { return events_; }
  std::size_t hits() const { return hits_; }
  std::size_t joint_events() const { return joint_events_; }
  std::int64_t sweep_hits() const { return sweep_hits_; }

 private:
  using Slot = Model::Slot;

  // The body of the call's slot or, if the slot is empty, of the next slot that is not; null if all are
  // empty.
  Slot* occupied(std::uint32_t slot);
  void empty_slot(Slot& slot);
  bool has_mesh(const Slot& slot) const;

  void create(const Call& call);
  void create_empty(const Call& call);
  void create_bulk(const Call& call);
  void destroy_bulk(const Call& call);
  void change_body(const Call& call, Slot& slot);
  void change_motion(const Call& call, Slot& slot);
  void change_shape(const Call& call, Slot& slot);
  void add_mesh(const Call& call, Slot& slot);
  void change_settings(const Call& call);
  void spare_slow_solvers();
  std::pair<JointDef, Joint> random_joining(Random& random, const Call& call);
  void keep_joint(JointId joint, const JointDef& def);
  void create_joint(const Call& call);
  void create_joints(const Call& call);
  void destroy_joint(const Call& call);
  void set_joint(const Call& call);
  void change_joint(const Call& call);
  void change_user_rows(JointId joint, Random& random);
  void make_wrong_call_of_joints(std::uint32_t which, BodyId body);
  JointId some_joint(std::uint32_t which) const;  // no joint if there is none
  void lose_joints(BodyId body);
  void check_lost_joints();
  void check_joint_events();
  void check_joints();
  void make_wrong_call(const Call& call);
  void save_somewhere(const Call& call);
  void restore_saved(const Call& call);
  void go_round(const Call& call);
  void branch_off(const Call& call);
  void make_wrong_call_of_snapshots(std::uint32_t which);
  const Snapshot& whole(const Saved& saved);
  void forget_changes();
  void check_handles(const Model& before);
  void run_steps(const Call& call);
  void check_before_step();
  void check_after_step();
  void check_events();
  void check_sleep();
  void check_body(Slot& slot);
  [[noreturn]] void fail(const std::string& promise) const;

  // One line of the log: the call and its arguments.
  template <class... Values>
  void tell(const char* call, const Values&... values);

  World world_;
  Shift& shift_;
  bool checks_;
  std::ostream* log_;
  bool one_world_ = false;
  std::function<void(World&)> before_step_;
  Model model_;
  std::array<Saved, 4> saved_;
  World used_;         // steps along in a list of worlds, and is a target of restores
  Snapshot scratch_;   // of the present
  Snapshot restored_;  // from changes
  std::vector<std::uint64_t> hashes_;
  std::int64_t most_contacts_ = 0;
  bool somebody_slept_ = false;
  std::size_t events_ = 0, hits_ = 0, joint_events_ = 0;
  std::int64_t sweep_hits_ = 0;
  std::int64_t most_manifolds_ = 1;  // of a pair: a mesh may have one a triangle
};

template <class... Values>
void Player::tell(const char* call, const Values&... values) {
  if (log_ == nullptr) return;
  *log_ << "  " << call << "(";
  const char* separator = "";
  [[maybe_unused]] const auto one = [&](const auto& value) {
    *log_ << separator;
    print(*log_, value);
    separator = ", ";
  };
  (one(values), ...);
  *log_ << ")\n";
}

}  // namespace scree::determinism
