// Asks the hooks of contacts, see scree/contact_hooks.h: the filter before pairs are collided, the rule
// before contacts are listed. Writes the kinds of pairs, the manifolds and surfaces of contacts, and the
// pairs that the sweep of fast bodies leaves alone.
//
// A hook answers a copy. Nothing of the contacts changes before all of its batches have returned, so one that
// throws leaves no trace. Where no shape asks, or nobody answers, nothing is listed and nothing paid.
//
// A contact that acts by other rules than its materials' is not recycled, so that the next step mixes these
// anew.
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/contact_hooks.h>
#include <core/world/edit.h>
#include <core/world/math.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/narrow_phase/narrow_phase.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace scree {

namespace {

bool asks(const WorldData& data, const ShapePair& pair, ContactHooks kind) {
  return contains(data.shapes.hooks[pair.a] | data.shapes.hooks[pair.b], kind);
}

// Whether somebody answers. Answers that were given stand for both hooks.
bool is_answered(const WorldData& data, bool has_hook) {
  if (data.shapes.hooked == 0) return false;
  return !data.hooks.answers.empty() || (has_hook && data.hooks.world != nullptr);
}

HookedPair handles_of(const WorldData& data, const ShapePair& pair) {
  return {shape_handle(data, pair.a), shape_handle(data, pair.b), body_handle(data, data.shapes.body[pair.a]),
          body_handle(data, data.shapes.body[pair.b])};
}

template <class Row>
std::span<const Row> part_of(const Column<Row>& column, int begin, int end) {
  return column.span().subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin));
}
template <class Row>
std::span<Row> part_of(Column<Row>& column, int begin, int end) {
  return {column.data() + begin, static_cast<std::size_t>(end - begin)};
}

// Pairs or contacts that a hook gets: enough to be worth the call, and several batches for 1,000.
constexpr int kHookBatch = 64;

// Runs the batches of a hook; whether none of them threw, on any rank: else the two ranks of a pair across a
// border would go by different answers.
template <class Ask>
bool run_hook(WorldData& data, std::size_t count, Crew& crew, Ask&& ask) {
  bool holds = true;
  try {
    crew.run_ranges(static_cast<int>(count), kHookBatch, [&](int begin, int end, int) { ask(begin, end); });
  } catch (...) {
    if (data.hooks.thrown == nullptr) data.hooks.thrown = std::current_exception();
    holds = false;
  }
  if (Border* const border = border_of(data)) holds = border->transport.holds_everywhere(holds);
  return holds;
}

// The answer about one contact of a pair, -1 the pair itself; null: none was given.
const HookAnswer* answer_for(const WorldData& data, const ShapePair& pair, std::int32_t contact) {
  const Hooks& hooks = data.hooks;
  for (const HookAnswer* answer = first_answer(hooks, pair);
       answer != hooks.answers.end() && key_of(*answer) == key_of(pair); ++answer) {
    if (answer->contact != contact) continue;
    const bool is_same = answer->shape_a.generation == data.shapes.generation[pair.a] &&
                         answer->shape_b.generation == data.shapes.generation[pair.b];
    return is_same ? answer : nullptr;
  }
  return nullptr;
}

// --- rules of contacts ---

// Whether the manifold's body A is that of the pair's second shape; see Manifold.
bool is_flipped(const WorldData& data, std::int32_t contact) {
  const Contacts& contacts = data.contacts;
  return contacts.now.manifold[contact].row_b == data.shapes.body[contacts.now.pair[contact].a];
}

HookedContact shown(const WorldData& data, std::int32_t contact) {
  const Manifold& manifold = data.contacts.now.manifold[contact];
  const Vec3 normal = to_vec3(manifold.normal);
  const Vec3 tangent_1 = tangent_of(normal), tangent_2 = cross(normal, tangent_1);
  const Vec3 center = to_vec3(data.bodies.pose[manifold.row_b].position) + to_vec3(manifold.arm_b);
  HookedContact to;
  to.normal = is_flipped(data, contact) ? -normal : normal;
  to.point_count = static_cast<std::int32_t>(manifold.info & kManifoldPointMask);
  for (std::int32_t k = 0; k < to.point_count; ++k) {
    to.points[k] = {center + manifold.point_u[k] * tangent_1 + manifold.point_v[k] * tangent_2,
                    manifold.separation[k]};
  }
  return to;
}

// As the materials have made them.
ContactRules rules_of(const WorldData& data, std::int32_t contact) {
  const Manifold& manifold = data.contacts.now.manifold[contact];
  ContactRules rules{.friction = manifold.friction};
  if ((manifold.info & kManifoldRich) == 0) return rules;
  const ContactSurface& surface = data.contacts.now.surface[contact];
  rules.restitution = surface.restitution;
  rules.rolling_resistance = surface.rolling_resistance;
  const Vec3 velocity = to_vec3(surface.surface_velocity);
  rules.surface_velocity = is_flipped(data, contact) ? -velocity : velocity;
  return rules;
}

void take_rules(WorldData& data, std::int32_t contact, const ContactRules& rules) {
  ContactRows& rows = data.contacts.now;
  if (!rules.acts) {
    rows.points[contact] = 0;
    return;
  }
  Manifold& manifold = rows.manifold[contact];
  ContactSurface& surface = rows.surface[contact];
  const Vec3 normal = to_vec3(manifold.normal);
  const Vec3 velocity = is_flipped(data, contact) ? -rules.surface_velocity : rules.surface_velocity;
  const bool was_rich = (manifold.info & kManifoldRich) != 0;
  const bool is_rich =
      rules.restitution > 0.0f || rules.rolling_resistance > 0.0f || rules.surface_velocity != Vec3{};
  manifold.friction = rules.friction;
  if (!was_rich) surface = {};  // what an earlier step left there
  surface.restitution = rules.restitution;
  surface.rolling_resistance = rules.rolling_resistance;
  store(surface.surface_velocity, velocity - dot(velocity, normal) * normal);
  if (is_rich) {
    manifold.info |= std::uint32_t{kManifoldRich};
  } else {
    manifold.info &= ~std::uint32_t{kManifoldRich};
    surface = {};
  }
  rows.anchor[contact].is_set = 0.0f;
}

// The contacts of asked pairs that touch.
void list_asked_contacts(WorldData& data, NarrowPhase& phase, Crew& crew) {
  const Contacts& contacts = data.contacts;
  list_where(crew, contacts.pairs.pair.size(), phase.places, phase.asked, [&](std::int32_t i) {
    return phase.kind[i] <= kMeshPair && contacts.pairs.contact[i] >= 0 &&
           asks(data, contacts.pairs.pair[i], ContactHooks::rule);
  });
  phase.asked_contacts.clear();
  phase.asked_number.clear();
  for (const std::int32_t pair : phase.asked) {
    std::int32_t number = 0;
    for_each_contact(contacts, contacts.pairs.contact[pair], [&](std::int32_t contact) {
      if (contacts.now.points[contact] == 0) return;
      phase.asked_contacts.push_back(contact);
      phase.asked_number.push_back(number++);
    });
  }
  const std::size_t count = phase.asked_contacts.size();
  phase.asked_pairs.resize_discarding(count);
  phase.asked_shown.resize_discarding(count);
  phase.rules.resize_discarding(count);
  phase.verdicts.resize_discarding(count);
}

// Asks about the contacts [begin, end) of the list. `answered`: by the answers that were given.
void ask_rule(const WorldData& data, NarrowPhase& phase, bool answered, int begin, int end) {
  for (int i = begin; i < end; ++i) {
    const std::int32_t contact = phase.asked_contacts[i];
    phase.rules[i] = rules_of(data, contact);
    if (answered) {
      const HookAnswer* answer = answer_for(data, data.contacts.now.pair[contact], phase.asked_number[i]);
      if (answer != nullptr) phase.rules[i] = rules_of(*answer);
    } else {
      phase.asked_pairs[i] = handles_of(data, data.contacts.now.pair[contact]);
      phase.asked_shown[i] = shown(data, contact);
    }
  }
  if (!answered) {
    data.hooks.rule({*data.hooks.world, data.hooks.dt, part_of(std::as_const(phase.asked_pairs), begin, end),
                     part_of(std::as_const(phase.asked_shown), begin, end),
                     part_of(phase.rules, begin, end)});
  }
  for (int i = begin; i < end; ++i) {
    const ContactRules& rules = phase.rules[i];
    phase.verdicts[i] = !is_sound(rules)                                   ? kUnsoundRules
                        : rules == rules_of(data, phase.asked_contacts[i]) ? kSameRules
                                                                           : kOtherRules;
  }
}

// The answer about one of the asked contacts, as it is recorded.
ContactAnswer answer_of(const WorldData& data, const NarrowPhase& phase, std::size_t i) {
  const HookedPair pair = handles_of(data, data.contacts.now.pair[phase.asked_contacts[i]]);
  return {pair.shape_a, pair.shape_b, phase.asked_number[i], phase.rules[i]};
}

// Brings all ranks' answers to rank 0, which records them. Of a pair across a border, two ranks have asked.
void gather_answers(Border& border, Column<ContactAnswer>& answers) {
  if (border.here != 0) return send_list<ContactAnswer>(border.transport, 0, answers.span());
  for (std::int32_t from = 1; from < border.transport.ranks(); ++from) {
    for (const ContactAnswer& answer : receive_list<ContactAnswer>(border.transport, from))
      answers.push_back(answer);
  }
}

// What both hooks have changed, as the call that does the same.
void record_answers(WorldData& data, NarrowPhase& phase) {
  Column<ContactAnswer>& answers = phase.recorded;
  answers.clear();
  for (const ShapePair& pair : data.hooks.refused) {
    answers.push_back({shape_handle(data, pair.a), shape_handle(data, pair.b), -1, {}});
  }
  for (std::size_t i = 0; i < phase.asked_contacts.size(); ++i) {
    if (phase.verdicts[i] == kOtherRules) answers.push_back(answer_of(data, phase, i));
  }
  Border* const border = border_of(data);
  if (border != nullptr) gather_answers(*border, answers);
  if (answers.empty() || data.recording.sink == nullptr) return;
  const auto place = [](const ContactAnswer& answer) {
    return std::tuple(answer.shape_a.index, answer.shape_b.index, answer.contact);
  };
  std::sort(answers.begin(), answers.end(),
            [&](const ContactAnswer& x, const ContactAnswer& y) { return place(x) < place(y); });
  const auto end =
      std::unique(answers.begin(), answers.end(),
                  [&](const ContactAnswer& x, const ContactAnswer& y) { return place(x) == place(y); });
  answers.resize(end - answers.begin());
  const std::span<const ContactAnswer> all = std::as_const(answers).span();
  const CallRecord<RecordedCall::answer_contact_hooks> call_record(data, all);
}

// Pairs of which the rule has taken out all contacts count as refused, beside those that the filter refused.
// Where it has taken out some, the next step must find these again: it recycles all contacts of a pair or
// none. Nothing else may depend on who was asked: steps that are played ask nobody.
void note_taken_out(WorldData& data, const NarrowPhase& phase) {
  Contacts& contacts = data.contacts;
  Column<ShapePair>& refused = data.hooks.refused;
  for (std::size_t begin = 0, end = 0; begin < phase.asked_contacts.size(); begin = end) {
    bool acts = false, misses = false;
    do {
      (contacts.now.points[phase.asked_contacts[end]] != 0 ? acts : misses) = true;
      ++end;
    } while (end < phase.asked_contacts.size() && phase.asked_number[end] != 0);
    if (!misses) continue;
    if (!acts) refused.push_back(contacts.now.pair[phase.asked_contacts[begin]]);
    for (std::size_t i = begin; i < end; ++i) contacts.now.anchor[phase.asked_contacts[i]].is_set = 0.0f;
  }
  std::sort(refused.begin(), refused.end(), comes_before);  // two ascending lists; merging them takes memory
}

}  // namespace

bool has_filter(const WorldData& data) { return is_answered(data, data.hooks.filter != nullptr); }

void filter_pairs(WorldData& data, NarrowPhase& phase, Crew& crew) {
  const Column<ShapePair>& pairs = data.contacts.pairs.pair;
  list_where(crew, pairs.size(), phase.places, phase.asked, [&](std::int32_t i) {
    return phase.kind[i] <= kMeshPair && asks(data, pairs[i], ContactHooks::filter);
  });
  const std::size_t count = phase.asked.size();
  const bool answered = !data.hooks.answers.empty();
  phase.may_collide.resize_discarding(count);
  phase.asked_pairs.resize_discarding(count);
  const bool holds = run_hook(data, count, crew, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ShapePair& pair = pairs[phase.asked[i]];
      phase.may_collide[i] = answered && answer_for(data, pair, -1) != nullptr ? 0 : 1;
      if (!answered) phase.asked_pairs[i] = handles_of(data, pair);
    }
    if (answered) return;
    data.hooks.filter({*data.hooks.world, data.hooks.dt,
                       part_of(std::as_const(phase.asked_pairs), begin, end),
                       part_of(phase.may_collide, begin, end)});
  });
  if (!holds) return;
  for (std::size_t i = 0; i < count; ++i) {
    if (phase.may_collide[i] != 0) continue;
    phase.kind[phase.asked[i]] = kNever;
    data.hooks.refused.push_back(pairs[phase.asked[i]]);
  }
}

void rule_contacts(WorldData& data, NarrowPhase& phase, Crew& crew) {
  const bool answered = !data.hooks.answers.empty();
  phase.asked.clear();
  phase.asked_contacts.clear();
  if (is_answered(data, data.hooks.rule != nullptr)) {
    list_asked_contacts(data, phase, crew);
    const bool holds = run_hook(data, phase.asked_contacts.size(), crew,
                                [&](int begin, int end) { ask_rule(data, phase, answered, begin, end); });
    if (!holds) phase.asked_contacts.clear();
  }
  const Border* const border = border_of(data);
  const bool is_recorded = border != nullptr ? border->is_recorded : data.recording.sink != nullptr;
  if (is_recorded && !answered) record_answers(data, phase);
  for (std::size_t i = 0; i < phase.asked_contacts.size(); ++i) {
    data.stats.unsound_rules += phase.verdicts[i] == kUnsoundRules ? 1 : 0;
    if (phase.verdicts[i] == kOtherRules) take_rules(data, phase.asked_contacts[i], phase.rules[i]);
  }
  if (!phase.asked_contacts.empty()) note_taken_out(data, phase);
  data.hooks.answers.clear();
}

}  // namespace scree
