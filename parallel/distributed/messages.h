// Messages of a row for each of some bodies. Both sides know which, in the same order, so that rows are all
// there is to send.
#pragma once

#include <parallel/distributed/border.h>
#include <scree/error.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace scree {

[[noreturn]] inline void refuse_world_of(std::int32_t rank) {
  throw Error("rank " + std::to_string(rank) + " has sent what does not fit: its world is another one");
}

// Sorts rows of bodies or joints, and drops those that come again.
template <class Row>
void keep_each_once(std::vector<Row>& rows) {
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
}

// A rank tells of bodies of its own alone.
inline void check_owner(const Border& border, std::int32_t rank, std::int32_t body) {
  if (body < 0 || std::cmp_greater_equal(body, border.owner.size()) || border.owner_of(body) != rank)
    refuse_world_of(rank);
}

// Sends a list of rows, even an empty one.
template <class Row>
void send_list(Transport& transport, std::int32_t to, std::span<const Row> rows) {
  static_assert(std::is_trivially_copyable_v<Row>);
  transport.send(to, std::as_bytes(rows));
}

template <class Row>
std::vector<Row> receive_list(Transport& transport, std::int32_t from) {
  const std::span<const std::byte> message = transport.receive(from);
  if (message.size() % sizeof(Row) != 0) refuse_world_of(from);
  std::vector<Row> rows(message.size() / sizeof(Row));
  if (!rows.empty()) std::memcpy(rows.data(), message.data(), rows.size() * sizeof(Row));
  return rows;
}

// row_of(item) for each.
template <class Row, class RowOf>
void send_rows(Transport& transport, std::int32_t to, std::span<const std::int32_t> items, RowOf&& row_of) {
  std::vector<Row> rows;
  rows.reserve(items.size());
  for (const std::int32_t item : items) rows.push_back(row_of(item));
  send_list<Row>(transport, to, rows);
}

// take(item, row) for each.
template <class Row, class Take>
void receive_rows(Transport& transport, std::int32_t from, std::span<const std::int32_t> items, Take&& take) {
  const std::vector<Row> rows = receive_list<Row>(transport, from);
  if (rows.size() != items.size()) {
    throw Error("rank " + std::to_string(from) + " has sent " + std::to_string(rows.size()) +
                " rows instead of " + std::to_string(items.size()) + ": its world is another one");
  }
  for (std::size_t i = 0; i < items.size(); ++i) take(items[i], rows[i]);
}

// The owners' rows of all bodies at the border -> both sides.
template <class Row>
void share_rows(Border& border, Column<Row>& rows) {
  for (const Neighbor& with : border.neighbors) {
    send_rows<Row>(border.transport, with.rank, with.own, [&](std::int32_t body) { return rows[body]; });
  }
  for (const Neighbor& with : border.neighbors) {
    receive_rows<Row>(border.transport, with.rank, with.other,
                      [&](std::int32_t body, const Row& row) { rows[body] = row; });
  }
}

// row_of(body) of the own bodies that are lent -> take(body, row) for ghosts: of those that is_listed(body)
// holds for, which owners and holders must agree on.
template <class Row, class IsListed, class RowOf, class Take>
void share_halos(Border& border, IsListed&& is_listed, RowOf&& row_of, Take&& take) {
  const auto listed = [&](const std::vector<std::int32_t>& bodies) {
    std::vector<std::int32_t> some;
    std::copy_if(bodies.begin(), bodies.end(), std::back_inserter(some), is_listed);
    return some;
  };
  const auto ranks = static_cast<std::int32_t>(border.halos.size());
  for (std::int32_t to = 0; to < ranks; ++to) {
    const std::vector<std::int32_t> lent = listed(border.halos[static_cast<std::size_t>(to)].lent);
    if (!lent.empty()) send_rows<Row>(border.transport, to, lent, row_of);
  }
  for (std::int32_t from = 0; from < ranks; ++from) {
    const std::vector<std::int32_t> ghosts = listed(border.halos[static_cast<std::size_t>(from)].borrowed);
    if (!ghosts.empty()) receive_rows<Row>(border.transport, from, ghosts, take);
  }
}

// Each rank tells the others a row of its own. By rank; all ranks call it.
template <class Row>
std::vector<Row> gather_rows(Transport& transport, const Row& own) {
  const int here = transport.rank(), ranks = transport.ranks();
  std::vector<Row> rows(static_cast<std::size_t>(ranks), own);
  for (int to = 0; to < ranks; ++to) {
    if (to != here) send_list<Row>(transport, to, std::span(&own, 1));
  }
  for (int from = 0; from < ranks; ++from) {
    if (from == here) continue;
    const std::vector<Row> one = receive_list<Row>(transport, from);
    if (one.size() != 1) refuse_world_of(from);
    rows[static_cast<std::size_t>(from)] = one[0];
  }
  return rows;
}

// Each rank tells the others a list of its own. Those of all ranks, one behind the other; all ranks call it.
// Of other ranks' rows, is_sound(row) must hold.
template <class Row, class IsSound>
std::vector<Row> gather_lists(Transport& transport, const std::vector<Row>& own, IsSound&& is_sound) {
  const int here = transport.rank(), ranks = transport.ranks();
  for (int to = 0; to < ranks; ++to) {
    if (to != here) send_list<Row>(transport, to, own);
  }
  std::vector<Row> all;
  for (int from = 0; from < ranks; ++from) {
    const std::vector<Row> one = from == here ? own : receive_list<Row>(transport, from);
    if (from != here && !std::all_of(one.begin(), one.end(), is_sound)) refuse_world_of(from);
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

}  // namespace scree
