// Random sequences: drawing, comparing and shrinking them. See random_calls.h.
#include <tests/determinism/player.h>
#include <tests/determinism/random_calls.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <sstream>

namespace scree::determinism {
namespace {

constexpr std::chrono::minutes kMostShrinking{
    1};  // each try plays the whole sequence, slowly under sanitizers

struct KindRule {
  const char* name;
  int weight;  // relative frequency, of the sum of all weights
};

constexpr KindRule kRules[kCallKindCount] = {
    {"step", 40},
    {"step_worlds", 4},
    {"create_body", 20},
    {"create_empty_bodies", 1},
    {"create_bodies", 3},
    {"destroy_body", 6},
    {"destroy_bodies", 2},
    {"add_shape", 6},
    {"destroy_shape", 4},
    {"set_pose", 6},
    {"set_linear_velocity", 4},
    {"set_angular_velocity", 4},
    {"shoot", 4},
    {"set_kinematic_target", 4},
    {"add_load", 6},
    {"add_impulse", 6},
    {"set_body_type", 5},
    {"set_filter", 4},
    {"set_material", 4},
    {"set_geometry", 4},
    {"set_local_pose", 3},
    {"set_contact_events", 3},
    {"set_mass_properties", 3},
    {"reset_mass", 2},
    {"set_damping", 3},
    {"set_gravity_factor", 2},
    {"set_locks", 3},
    {"set_can_sleep", 2},
    {"set_full_sweep", 2},
    {"wake", 2},
    {"set_user_data", 2},
    {"set_settings", 3},
    {"create_joint", 9},
    {"create_joints", 1},
    {"destroy_joint", 3},
    {"set_joint", 4},
    {"change_joint", 6},
    {"save", 4},
    {"restore", 3},
    {"go_round", 3},
    {"branch", 2},
    {"move_world", 1},
    {"wrong_call", 4},
    {"add_mesh", 0},
};

CallKind random_kind(scenes::Random& random) {
  std::uint32_t sum = 0;
  for (const KindRule& rule : kRules) sum += static_cast<std::uint32_t>(rule.weight);
  std::uint32_t left = random.below(sum);
  int kind = 0;
  while (left >= static_cast<std::uint32_t>(kRules[kind].weight)) {
    left -= static_cast<std::uint32_t>(kRules[kind].weight);
    ++kind;
  }
  return static_cast<CallKind>(kind);
}

// The first step in which two runs differ; -1 if there is none.
std::ptrdiff_t first_different_step(const Played& expected, const Played& actual) {
  const auto [left, right] = std::mismatch(expected.hashes.begin(), expected.hashes.end(),
                                           actual.hashes.begin(), actual.hashes.end());
  if (left == expected.hashes.end() && right == actual.hashes.end()) return -1;
  return left - expected.hashes.begin();
}

}  // namespace

const char* name_of(CallKind kind) { return kRules[static_cast<int>(kind)].name; }

bool wants_all_sequences() {
#ifdef __SANITIZE_THREAD__
  return true;
#else
  return wants_full_matrix();
#endif
}

std::uint64_t wish(const char* variable, std::uint64_t otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

Sequence random_sequence(std::uint64_t seed, int calls, int bodies) {
  scenes::Random random(seed);
  // Bulk calls use the slots from kBulkSlots on, half of the bodies at a time.
  const auto half = static_cast<std::uint32_t>(std::max(bodies / 2, 1));
  Sequence sequence;
  for (int i = 0; i < calls; ++i) {
    Call call;
    // A sequence without bodies would test little: it starts with some, and ends with steps.
    call.kind = i < 2 ? CallKind::create_bodies : i + 4 >= calls ? CallKind::step : random_kind(random);
    const bool bulk = call.kind == CallKind::create_bodies || call.kind == CallKind::destroy_bodies;
    if (bulk) {
      call.slot = kBulkSlots + half * (i == 0 ? 0 : i == 1 ? 1 : random.below(2));
    } else {
      call.slot = random.below(random.below(4) == 0 ? kBulkSlots + 2 * half : kBulkSlots);
    }
    call.seed = random.next() << 16 | half;  // bulk calls read their size from the lower bits
    sequence.push_back(call);
  }
  return sequence;
}

Sequence with_meshes(const Sequence& sequence) {
  constexpr std::size_t kSpacing = 7;
  Sequence result;
  for (const Call& call : sequence) {
    result.push_back(call);
    if (result.size() % kSpacing == 0)
      result.push_back({CallKind::add_mesh, call.slot % kBulkSlots, ~call.seed});
  }
  return result;
}

Played play(const Sequence& sequence, const Schedule& schedule, bool checks, std::ostream* log) {
  Shift shift(schedule);
  Player player(shift, checks, log);
  Played played;
  try {
    for (const Call& call : sequence) player.make(call);
  } catch (const BrokenPromise& broken) {
    played.broken_promise = broken.what();
  } catch (const Error& error) {
    played.broken_promise = "a legal call threw: " + std::string(error.what());
  }
  played.hashes = player.hashes();
  played.most_contacts = player.most_contacts();
  played.somebody_slept = player.somebody_slept();
  played.events = player.events();
  played.hits = player.hits();
  played.joint_events = player.joint_events();
  played.sweep_hits = player.sweep_hits();
  return played;
}

std::optional<Failure> find_failure(const Sequence& sequence, const std::vector<Schedule>& schedules) {
  const Played expected = play(sequence, {kReference}, true);
  if (!expected.broken_promise.empty()) return Failure{expected.broken_promise, {kReference}};
  for (const Schedule& schedule : schedules) {
    const Played actual = play(sequence, schedule, false);
    const std::string where = "on " + name_of(schedule) + ": ";
    if (!actual.broken_promise.empty()) return Failure{where + actual.broken_promise, schedule};
    const std::ptrdiff_t step = first_different_step(expected, actual);
    if (step < 0) continue;
    return Failure{where + "the hash differs from that on " + name_of({kReference}) + " in step " +
                       std::to_string(step + 1) + " of " + std::to_string(expected.hashes.size()),
                   schedule};
  }
  return {};
}

Sequence shrunk(Sequence sequence, const std::function<bool(const Sequence&)>& fails) {
  const auto start = std::chrono::steady_clock::now();
  const auto may_go_on = [&] { return std::chrono::steady_clock::now() - start < kMostShrinking; };
  for (std::size_t drop = sequence.size() / 2; drop > 0 && may_go_on();) {
    bool dropped = false;
    for (std::size_t at = 0; at < sequence.size() && may_go_on();) {
      Sequence shorter = sequence;
      const auto first = shorter.begin() + static_cast<std::ptrdiff_t>(at);
      shorter.erase(first, first + static_cast<std::ptrdiff_t>(std::min(drop, shorter.size() - at)));
      if (fails(shorter)) {
        sequence = std::move(shorter);
        dropped = true;
      } else {
        at += drop;
      }
    }
    if (!dropped || drop > sequence.size()) drop /= 2;
  }
  return sequence;
}

std::string describe(const Sequence& sequence, const Failure& failure) {
  std::ostringstream text;
  text << failure.what << "\n" << sequence.size() << " calls suffice:\n";
  play(sequence, failure.schedule, true, &text);
  return text.str();
}

}  // namespace scree::determinism
