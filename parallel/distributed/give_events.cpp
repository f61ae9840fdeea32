// See give_events.h. What calls have destroyed stays where it is, and ends there.
#include <core/world/pair_key.h>
#include <core/world/resting_pairs.h>
#include <parallel/distributed/give_events.h>
#include <parallel/distributed/messages.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

namespace scree {

bool is_there(const WorldData& data, const TouchingPair& pair) {
  const auto lives = [](const auto& rows, SlotName name, std::uint8_t alive) {
    return name.index < rows.flags.size() && (rows.flags[name.index] & alive) != 0 &&
           rows.generation[name.index] == name.generation;
  };
  return lives(data.shapes, pair.shape_a, kShapeAlive) && lives(data.shapes, pair.shape_b, kShapeAlive) &&
         lives(data.bodies, pair.body_a, kBodyAlive) && lives(data.bodies, pair.body_b, kBodyAlive);
}

namespace {

const TouchingPair& pair_of(const TouchRow& row) { return row.pair; }
const TouchingPair& pair_of(const TouchingPair& row) { return row; }

std::int32_t body_a_of(const TouchingPair& pair) { return static_cast<std::int32_t>(pair.body_a.index); }
std::int32_t body_b_of(const TouchingPair& pair) { return static_cast<std::int32_t>(pair.body_b.index); }

// Whether this rank has the row of the pair beside its pair at rest.
bool rests_here(const WorldData& data, const TouchingPair& pair) {
  bool is_here = false;
  const Column<TouchRow>& resting = data.events.resting;
  for_each_resting(data, static_cast<std::int32_t>(pair.shape_a.index), [&](std::int32_t row, std::int32_t) {
    is_here = is_here || (std::cmp_less(row, resting.size()) && resting[row].pair == pair);
  });
  return is_here;
}

// Of a pair that is there.
bool is_of_everybody(const WorldData& data, const TouchingPair& pair) {
  return !is_shared_out(data.bodies, body_a_of(pair)) && !is_shared_out(data.bodies, body_b_of(pair));
}

std::pair<std::uint32_t, std::uint32_t> place_of(const TouchingPair& pair) {
  return {pair.shape_a.index, pair.shape_b.index};
}

// Calls send(rank, row) for the rows of a list that go to another rank.
template <class Row, class Send>
void for_each_sent(const WorldData& data, const Border& border, const std::vector<std::int32_t>& next_owner,
                   const Column<Row>& rows, Send&& send) {
  for (const Row& row : rows) {
    const TouchingPair& pair = pair_of(row);
    if (!is_there(data, pair)) continue;
    const Receivers to = receivers_of(border, next_owner, body_a_of(pair), body_b_of(pair));
    for (int i = 0; i < to.count; ++i) send(static_cast<std::size_t>(to.ranks[i]), row);
  }
}

// Two ranks may have sent the same row.
template <class Row>
void take_rows(const WorldData& data, const Border& border, std::vector<Row>& received, Column<Row>& rows) {
  std::vector<Row> all;
  for (const Row& row : rows) {
    const TouchingPair& pair = pair_of(row);
    if (!is_there(data, pair) || tells_of(&border, body_a_of(pair), body_b_of(pair))) all.push_back(row);
  }
  if (received.empty() && all.size() == rows.size()) return;
  for (const Row& row : received) {
    const TouchingPair& pair = pair_of(row);
    if (!is_there(data, pair) || tells_of(&border, body_a_of(pair), body_b_of(pair))) all.push_back(row);
  }
  const auto place = [](const Row& row) { return place_of(pair_of(row)); };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Row& one, const Row& other) { return place(one) < place(other); });
  all.erase(std::unique(all.begin(), all.end(),
                        [&](const Row& one, const Row& other) { return place(one) == place(other); }),
            all.end());
  rows.resize_discarding(all.size());
  std::copy(all.begin(), all.end(), rows.begin());
}

}  // namespace

std::vector<SentEvents> pack_events(const WorldData& data, const Border& border,
                                    const std::vector<std::int32_t>& next_owner, std::size_t receivers) {
  std::vector<SentEvents> sent(receivers);
  const Events& events = data.events;
  for_each_sent(data, border, next_owner, events.touching,
                [&](std::size_t rank, const TouchRow& row) { sent[rank].touching.push_back(row); });
  for_each_sent(data, border, next_owner, events.sensed,
                [&](std::size_t rank, const TouchingPair& row) { sent[rank].sensed.push_back(row); });
  for (const SlotName& body : events.woken) {
    const auto row = static_cast<std::int32_t>(body.index);
    if (border.owns(row)) sent[static_cast<std::size_t>(next_owner[body.index])].woken.push_back(body);
  }
  return sent;
}

void append_left_events(const WorldData& data, SentEvents& sent) {
  const auto is_left = [&](const TouchingPair& pair) {
    return !is_there(data, pair) || is_of_everybody(data, pair);
  };
  for (const TouchRow& row : data.events.touching) {
    if (is_left(row.pair)) sent.touching.push_back(row);
  }
  for (const TouchingPair& row : data.events.sensed) {
    if (is_left(row)) sent.sensed.push_back(row);
  }
}

namespace {

// All ranks learn of the rows that is_asked_for(pair) holds for what they tell of.
template <class IsAskedFor>
void share_rows_of(WorldData& data, Border& border, IsAskedFor&& is_asked_for) {
  const auto gather = [&](auto own) {
    std::erase_if(
        own, [&](const auto& row) { return !is_there(data, pair_of(row)) || !is_asked_for(pair_of(row)); });
    return gather_lists(border.transport, own, [](const auto&) { return true; });
  };
  const Events& events = data.events;
  std::vector<TouchRow> touching(events.touching.begin(), events.touching.end());
  std::copy_if(events.resting.begin(), events.resting.end(), std::back_inserter(touching),
               [](const TouchRow& row) { return row.events != 0; });
  SentEvents all;
  all.touching = gather(std::move(touching));
  all.sensed = gather(std::vector<TouchingPair>(events.sensed.begin(), events.sensed.end()));
  std::erase_if(all.touching, [&](const TouchRow& row) { return rests_here(data, row.pair); });
  take_events(data, border, all);
}

}  // namespace

void share_events_of(WorldData& data, Border& border, std::span<const std::int32_t> bodies) {
  std::vector<bool> is_listed(data.bodies.flags.size());
  for (const std::int32_t body : bodies) is_listed[static_cast<std::size_t>(body)] = true;
  share_rows_of(data, border, [&](const TouchingPair& pair) {
    return is_listed[pair.body_a.index] || is_listed[pair.body_b.index];
  });
}

void share_common_events(WorldData& data, Border& border) {
  share_rows_of(data, border, [&](const TouchingPair& pair) { return is_of_everybody(data, pair); });
}

namespace {

template <class Row>
void forget_untold_rows(const WorldData& data, const Border& border, Column<Row>& rows) {
  const auto is_untold = [&](const Row& row) {
    const TouchingPair& pair = pair_of(row);
    return is_there(data, pair) && !tells_of(&border, body_a_of(pair), body_b_of(pair));
  };
  const Row* const end = std::remove_if(rows.begin(), rows.end(), is_untold);
  rows.drop_back(rows.end() - end);
}

}  // namespace

void forget_untold(const WorldData& data, const Border& border, Column<TouchRow>& rows) {
  forget_untold_rows(data, border, rows);
}
void forget_untold(const WorldData& data, const Border& border, Column<TouchingPair>& rows) {
  forget_untold_rows(data, border, rows);
}

void send_events(Transport& transport, std::int32_t to, const SentEvents& sent) {
  send_list<TouchRow>(transport, to, sent.touching);
  send_list<TouchingPair>(transport, to, sent.sensed);
  send_list<SlotName>(transport, to, sent.woken);
}

void receive_events(Transport& transport, std::int32_t from, SentEvents& received) {
  const auto append = [](auto& list, const auto& more) { list.insert(list.end(), more.begin(), more.end()); };
  append(received.touching, receive_list<TouchRow>(transport, from));
  append(received.sensed, receive_list<TouchingPair>(transport, from));
  append(received.woken, receive_list<SlotName>(transport, from));
}

void take_events(WorldData& data, const Border& border, SentEvents& received) {
  take_rows(data, border, received.touching, data.events.touching);
  take_rows(data, border, received.sensed, data.events.sensed);
  // A body may have woken here, too, as a ghost.
  if (received.woken.empty()) return;
  Column<SlotName>& woken = data.events.woken;
  std::vector<std::uint8_t> is_listed(data.bodies.flags.size(), 0);
  for (const SlotName& body : woken) is_listed[body.index] = 1;
  for (const SlotName& body : received.woken) {
    if (body.index < is_listed.size() && is_listed[body.index]++ == 0) woken.push_back(body);
  }
}

}  // namespace scree
