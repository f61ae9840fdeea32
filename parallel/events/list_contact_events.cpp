// Lists the events of contacts: merges the pairs that touch now with those that touched after the last step
// into begins, persists and ends, and picks those that hit.
//
// Both lists are sorted, so a chunk of pairs finds its part of the old list by bisection; counts then place
// what the chunks have found in their order. Costs nothing while no events are asked for. A pair that rested
// and still rests has no events: whether it touches is kept beside its row. Only resting pairs that came to
// rest, wake or are asked for other events than before are read, together with the moving ones.
#include <core/world/edit.h>
#include <core/world/resting_pairs.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/broad_phase/merge_pairs.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/give_events.h>
#include <parallel/events/contact_questions.h>
#include <parallel/stages.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace scree {

namespace {

constexpr int kRowsPerChunk = 1024;

// Bits of Events::verdicts: kTouchEvents that a touching pair is asked about, none if it does not touch.
constexpr std::uint8_t kHits = 4;
constexpr std::uint8_t kResting = 8;  // both bodies rest: nothing was solved

TouchingPair names_of(const WorldData& data, const ShapePair& pair) {
  const auto shape = [&](std::int32_t index) {
    const auto row = static_cast<std::uint32_t>(index);
    return SlotName{row, data.shapes.generation[row]};
  };
  const auto body = [&](std::int32_t index) {
    const auto row = static_cast<std::uint32_t>(data.shapes.body[index]);
    return SlotName{row, data.bodies.generation[row]};
  };
  return {shape(pair.a), shape(pair.b), body(pair.a), body(pair.b)};
}

ContactEnd handles_of(const WorldData& data, const TouchingPair& pair) {
  return {handle_of<ShapeId>(data, pair.shape_a), handle_of<ShapeId>(data, pair.shape_b),
          handle_of<BodyId>(data, pair.body_a), handle_of<BodyId>(data, pair.body_b)};
}

bool is_on_awake_dynamic(const WorldData& data, std::int32_t shape) {
  return is_awake_dynamic(data.bodies, data.shapes.body[shape]);
}

// Contacts of one pair, taken together.
template <class Value>
float largest_of(const Contacts& contacts, std::int32_t first, Value&& value) {
  float largest = -std::numeric_limits<float>::max();
  for_each_contact(contacts, first,
                   [&](std::int32_t contact) { largest = std::max(largest, value(contact)); });
  return largest;
}
float nearest_of(const Contacts& contacts, std::int32_t first) {
  return -largest_of(contacts, first,
                     [&](std::int32_t contact) { return -nearest_of(contacts.now.manifold[contact]); });
}
float impulse_of(const WorldData& data, std::int32_t first) {
  float sum = 0.0f;
  for_each_contact(data.contacts, first, [&](std::int32_t contact) { sum += data.events.impulse[contact]; });
  return sum;
}
// Of the contacts that were pressed, if there are any: what slides on a mesh toward a wall of it does not hit
// before it gets there.
float approach_of(const WorldData& data, std::int32_t first, bool pressed) {
  const Events& events = data.events;
  return largest_of(data.contacts, first, [&](std::int32_t contact) {
    return !pressed || events.impulse[contact] > 0.0f ? events.approach[contact] : 0.0f;
  });
}
// The contact with the nearest point.
std::int32_t nearest_contact(const Contacts& contacts, std::int32_t first) {
  std::int32_t nearest = first;
  for_each_contact(contacts, first, [&](std::int32_t contact) {
    if (nearest_of(contacts.now.manifold[contact]) < nearest_of(contacts.now.manifold[nearest]))
      nearest = contact;
  });
  return nearest;
}

bool was_pressed(const Manifold& manifold) {
  for (unsigned k = 0; k < (manifold.info & kManifoldPointMask); ++k) {
    if (manifold.normal_impulse[k] > 0.0f) return true;
  }
  return false;
}
bool was_pressed(const Contacts& contacts, std::int32_t first) {
  bool pressed = false;
  for_each_contact(contacts, first, [&](std::int32_t contact) {
    pressed = pressed || was_pressed(contacts.now.manifold[contact]);
  });
  return pressed;
}

// The pairs that may have events, and their contacts, -1 if they have none. `resting_row` is empty if all of
// the pairs move; else it is -1 for those that do.
struct PairList {
  const Column<ShapePair>& pair;
  const Column<std::int32_t>& contact;
  const Column<std::int32_t>& resting_row;
  bool rests(std::int32_t row) const { return !resting_row.empty() && resting_row[row] >= 0; }
};

// Lists the resting pairs with contacts that may have events: those that came to rest in this step, take part
// again, or are asked for other events than before. The others had none and have none.
void list_judged(WorldData& data, Crew& crew) {
  Contacts& contacts = data.contacts;
  Events& events = data.events;
  Column<std::int32_t>& judged = events.judged;
  const auto touches = [&](auto row) { return contacts.resting.contact[row] >= 0; };
  judged.clear();
  const std::size_t rows = contacts.resting.pair.size();
  if (events.asked_of_all) {
    contacts.resting_looks += static_cast<std::int64_t>(rows);
    list_where(crew, rows, events.contacts, judged, touches);
  } else {
    for (std::size_t row = contacts.resting_kept; row < rows; ++row) {
      if (touches(row)) judged.push_back(static_cast<std::int32_t>(row));
    }
    judged.append(std::as_const(contacts.roused).span());
    for (const std::int32_t shape : events.asked_of) {
      for_each_resting(data, shape, [&](std::int32_t row, std::int32_t) {
        if (touches(row)) judged.push_back(row);
      });
    }
  }
  events.asked_of.clear();
  events.asked_of_all = false;
  sort_by_pair(broad_phase_of(data), contacts.resting.pair, judged, crew);
  judged.resize(std::unique(judged.begin(), judged.end()) - judged.begin());
}

PairList list_pairs(WorldData& data, Crew& crew) {
  const PairRows &moving = data.contacts.pairs, &resting = data.contacts.resting;
  Events& events = data.events;
  events.rows.clear();
  if (events.judged.empty()) return {moving.pair, moving.contact, events.rows};
  const std::size_t judged = events.judged.size();
  events.judged_pairs.resize_discarding(judged);
  std::transform(events.judged.begin(), events.judged.end(), events.judged_pairs.begin(),
                 [&](std::int32_t row) { return resting.pair[row]; });
  events.pairs.resize_discarding(moving.pair.size() + judged);
  events.contacts.resize_discarding(events.pairs.size());
  events.rows.resize_discarding(events.pairs.size());
  merge_pairs(moving.pair, events.judged_pairs, crew, [&](std::size_t place, bool rests, std::size_t i) {
    const std::size_t row = rests ? static_cast<std::size_t>(events.judged[i]) : i;
    events.pairs[place] = (rests ? resting : moving).pair[row];
    events.contacts[place] = (rests ? resting : moving).contact[row];
    events.rows[place] = rests ? events.judged[i] : -1;
  });
  return {events.pairs, events.contacts, events.rows};
}

// Of a contact that was solved. An impulse that is not finite tells nothing: its bodies are about to be
// restored.
bool hits(const WorldData& data, std::int32_t contact, float impulse) {
  return impulse > 0.0f && std::isfinite(impulse) &&
         approach_of(data, contact, true) >= data.settings.hit_event_speed;
}

// `known`: the pair touched after the last step.
std::uint8_t judge(const WorldData& data, const PairList& list, std::int32_t row, bool known, bool solved) {
  if (list.contact[row] < 0) return 0;
  const std::int32_t contact = list.contact[row];
  const ShapePair pair = list.pair[row];
  if (!tells_of(border_of(data), data.shapes.body[pair.a], data.shapes.body[pair.b])) return 0;
  const ContactEvents asked = asked_about(data, pair);
  if (asked == ContactEvents::none) return 0;
  const auto verdict = static_cast<std::uint8_t>(static_cast<std::uint8_t>(asked) & kTouchEvents);
  const bool rests = !is_on_awake_dynamic(data, pair.a) && !is_on_awake_dynamic(data, pair.b);
  const bool asked_for_hit = contains(asked, ContactEvents::hit) && !rests && solved;
  const float impulse = solved ? impulse_of(data, contact) : 0.0f;
  const std::uint8_t hit = asked_for_hit && hits(data, contact, impulse) ? kHits : std::uint8_t{0};
  if (verdict == 0) return hit;
  const float nearest = nearest_of(data.contacts, contact);
  if (rests) {
    const bool touches = known || nearest <= 0.0f;
    return touches ? static_cast<std::uint8_t>(verdict | kResting) : std::uint8_t{0};
  }
  const bool pressed = solved ? impulse > 0.0f : was_pressed(data.contacts, contact);
  const bool touches = pressed || nearest <= (known ? kLinearSlop : 0.0f);
  return static_cast<std::uint8_t>((touches ? verdict : 0) | hit);
}

const TouchRow* first_at(const Column<TouchRow>& rows, std::uint64_t key) {
  return std::lower_bound(rows.begin(), rows.end(), key,
                          [](const TouchRow& row, std::uint64_t value) { return key_of(row) < value; });
}

// Goes over the pairs [begin, end) and the part of the old list between them and the next chunk's.
// Calls visit(row, known, verdict) for the pairs that touch, hit or touched: `row` is the pair's or -1,
// `known` points into the old list or is null. `verdict_of(row, known)` says what holds now.
template <class Verdict, class Visit>
void walk(const WorldData& data, const Column<ShapePair>& pairs, int begin, int end, Verdict&& verdict_of,
          Visit&& visit) {
  const Column<TouchRow>& before = data.events.before;
  const TouchRow* old = begin == 0 ? before.begin() : first_at(before, key_of(pairs[begin]));
  const TouchRow* const last =
      std::cmp_equal(end, pairs.size()) ? before.end() : first_at(before, key_of(pairs[end]));
  for (int row = begin; row < end; ++row) {
    const ShapePair pair = pairs[row];
    const std::uint64_t key = key_of(pair);
    for (; old != last && key_of(*old) < key; ++old) visit(-1, old, std::uint8_t{0});
    const TouchRow* known = nullptr;
    if (old != last && key_of(*old) == key) {
      // The slot may have been reused since.
      if (old->pair == names_of(data, pair)) {
        known = old;
      } else {
        visit(-1, old, std::uint8_t{0});
      }
      ++old;
    }
    const std::uint8_t verdict = verdict_of(row, known != nullptr);
    if (known != nullptr || verdict != 0) visit(row, known, verdict);
  }
  for (; old != last; ++old) visit(-1, old, std::uint8_t{0});
}

struct Outcome {
  bool touches, begins, persists, ends, hits;
};

// Whether the touch row of the pair is kept beside its resting row.
bool is_kept_at_rest(const PairList& list, std::int32_t row, std::uint8_t verdict) {
  return (verdict & kResting) != 0 && list.rests(row);
}

Outcome outcome_of(const TouchRow* known, std::uint8_t verdict) {
  constexpr auto kBeginEnd = static_cast<std::uint8_t>(ContactEvents::begin_end);
  constexpr auto kPersist = static_cast<std::uint8_t>(ContactEvents::persist);
  const bool had_begun = known != nullptr && (known->events & kBeginEnd) != 0;
  const bool touches = (verdict & kBeginEnd) != 0;
  const bool persists = known != nullptr && (verdict & kPersist) != 0 && (verdict & kResting) == 0;
  return {(verdict & kTouchEvents) != 0, touches && !had_begun, persists, had_begun && !touches,
          (verdict & kHits) != 0};
}

// Counts become places; the lists get their sizes.
void place_events(Events& events) {
  EventCounts place{};
  const auto take = [](std::int32_t& count, std::int32_t& next) {
    const std::int32_t first = next;
    next += count;
    count = first;
  };
  for (EventCounts& counts : events.counts) {
    take(counts.touching, place.touching);
    take(counts.resting, place.resting);
    take(counts.begins, place.begins);
    take(counts.persists, place.persists);
    take(counts.ends, place.ends);
    take(counts.hits, place.hits);
  }
  events.touching.resize_discarding(place.touching);
  events.resting_touches += place.resting;
  events.begins.resize_discarding(place.begins);
  events.persists.resize_discarding(place.persists);
  events.ends.resize_discarding(place.ends);
  events.hits.resize_discarding(place.hits);
}

ContactEvent make_event(const WorldData& data, const PairList& list, std::int32_t row, bool solved) {
  const std::int32_t first = list.contact[row];
  const ShapePair pair = list.pair[row];
  const Manifold& manifold = data.contacts.now.manifold[nearest_contact(data.contacts, first)];
  const ContactEnd handles = handles_of(data, names_of(data, pair));
  ContactEvent event{handles.shape_a, handles.shape_b, handles.body_a, handles.body_b, {}, 0.0f, 0.0f, 0, {}};
  const Vec3 normal = to_vec3(manifold.normal);
  const Vec3 tangent_1 = tangent_of(normal), tangent_2 = cross(normal, tangent_1);
  // If only one body is dynamic it is the manifold's B; the event's B is the body of the shape of higher
  // index.
  const bool flipped = static_cast<std::uint32_t>(manifold.row_b) == handles.body_a.index;
  event.normal = flipped ? -normal : normal;
  const Vec3 center = to_vec3(data.bodies.pose[manifold.row_b].position) + to_vec3(manifold.arm_b);
  const float near = near_of(manifold);
  for (unsigned k = 0; k < (manifold.info & kManifoldPointMask); ++k) {
    if (!(manifold.separation[k] <= near || manifold.normal_impulse[k] > 0.0f)) continue;
    event.points[event.point_count++] = {
        center + manifold.point_u[k] * tangent_1 + manifold.point_v[k] * tangent_2, manifold.separation[k]};
  }
  if (!is_on_awake_dynamic(data, pair.a) && !is_on_awake_dynamic(data, pair.b)) return event;
  const float impulse = solved ? impulse_of(data, first) : 0.0f;
  event.approach_speed = approach_of(data, first, impulse > 0.0f);
  if (std::isfinite(impulse)) event.normal_impulse = impulse;
  return event;
}

}  // namespace

void move_touching(WorldData& data, const Column<std::int32_t>& rows) {
  Events& events = data.events;
  if (events.resting_touches == 0) return;
  Column<TouchRow>&moved = events.moved, &all = events.before;
  moved.clear();
  for (const std::int32_t row : rows) {
    TouchRow& rests = events.resting[row];
    if (rests.events == 0) continue;
    moved.push_back(std::exchange(rests, TouchRow{}));
  }
  if (moved.empty()) return;
  events.resting_touches -= static_cast<std::int64_t>(moved.size());
  all.resize_discarding(events.touching.size() + moved.size());
  std::merge(events.touching.begin(), events.touching.end(), moved.begin(), moved.end(), all.begin(),
             [](const TouchRow& x, const TouchRow& y) { return key_of(x) < key_of(y); });
  all.swap(events.touching);
}

void list_contact_events(WorldData& data, float dt, Crew& crew) {
  Events& events = data.events;
  if (!asks_for_events(data)) {
    if (!events.resting.empty()) data.contacts.resting_marks.clear();  // as if never saved
    events.resting.clear();
    events.asked_of.clear();
    events.asked_of_all = false;  // so no events of resting pairs are asked for
    return;
  }
  events.resting.resize(data.contacts.resting.pair.size());
  list_judged(data, crew);
  for (const std::int32_t row : events.judged) data.contacts.resting_marks.mark(row);
  move_touching(data, events.judged);
  events.touching.swap(events.before);
  const Border* const border = border_of(data);
  if (border != nullptr && border->events_stale) forget_untold(data, *border, events.before);
  const bool solved = dt > 0.0f;
  const PairList all = list_pairs(data, crew);
  const int rows = static_cast<int>(all.pair.size());
  const int chunks = rows == 0 ? 1 : (rows + kRowsPerChunk - 1) / kRowsPerChunk;  // ends need no rows
  events.verdicts.resize_discarding(rows);
  events.counts.resize_discarding(chunks);
  crew.run(chunks, [&](int chunk, int) {
    EventCounts counts{};
    walk(
        data, all.pair, chunk * kRowsPerChunk, std::min((chunk + 1) * kRowsPerChunk, rows),
        [&](int row, bool known) { return events.verdicts[row] = judge(data, all, row, known, solved); },
        [&](int row, const TouchRow* known, std::uint8_t verdict) {
          const Outcome outcome = outcome_of(known, verdict);
          const bool rests = outcome.touches && is_kept_at_rest(all, row, verdict);
          counts.resting += rests ? 1 : 0;
          counts.touching += outcome.touches && !rests ? 1 : 0;
          counts.begins += outcome.begins ? 1 : 0;
          counts.persists += outcome.persists ? 1 : 0;
          counts.ends += outcome.ends ? 1 : 0;
          counts.hits += outcome.hits ? 1 : 0;
        });
    events.counts[chunk] = counts;
  });
  place_events(events);
  crew.run(chunks, [&](int chunk, int) {
    EventCounts place = events.counts[chunk];
    const auto next = [](auto& list, std::int32_t& to) -> auto& { return list[to++]; };
    walk(
        data, all.pair, chunk * kRowsPerChunk, std::min((chunk + 1) * kRowsPerChunk, rows),
        [&](int row, bool) { return events.verdicts[row]; },
        [&](int row, const TouchRow* known, std::uint8_t verdict) {
          const Outcome outcome = outcome_of(known, verdict);
          if (outcome.touches) {
            const bool rests = is_kept_at_rest(all, row, verdict);
            TouchRow& to =
                rests ? events.resting[all.resting_row[row]] : next(events.touching, place.touching);
            to = {names_of(data, all.pair[row]), std::uint32_t{verdict} & kTouchEvents};
          }
          if (outcome.begins) next(events.begins, place.begins) = make_event(data, all, row, solved);
          if (outcome.persists) next(events.persists, place.persists) = make_event(data, all, row, solved);
          if (outcome.ends) next(events.ends, place.ends) = handles_of(data, known->pair);
          if (outcome.hits) next(events.hits, place.hits) = make_event(data, all, row, solved);
        });
  });
}

}  // namespace scree
