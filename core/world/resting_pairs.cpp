// Pairs at rest; see resting_pairs.h.
#include <core/world/resting_pairs.h>

#include <algorithm>
#include <functional>
#include <utility>

namespace scree {

namespace {

std::uint32_t end_of(std::size_t row, std::size_t side) {
  return static_cast<std::uint32_t>(2 * row + side + 1);  // rows are numbered with 31 bits
}

std::int32_t shape_of(const ShapePair& pair, std::size_t side) { return side == 0 ? pair.a : pair.b; }

// The link that leads to what comes behind `previous` in the shape's list.
std::uint32_t& link_behind(WorldData& data, std::int32_t shape, std::uint32_t previous) {
  if (previous == 0) return data.shapes.first_resting[shape];
  return data.contacts.resting_links[(previous - 1) / 2].next[(previous - 1) % 2];
}

void set_previous(Contacts& contacts, std::uint32_t end, std::uint32_t previous) {
  if (end != 0) contacts.resting_links[(end - 1) / 2].previous[(end - 1) % 2] = previous;
}

void link_row(WorldData& data, std::size_t row) {
  const ShapePair pair = data.contacts.resting.pair[row];
  RestingLinks& links = data.contacts.resting_links[row];
  for (const std::size_t side : {0u, 1u}) {
    std::uint32_t& first = data.shapes.first_resting[shape_of(pair, side)];
    const std::uint32_t end = end_of(row, side);
    links.previous[side] = 0;
    links.next[side] = first;
    set_previous(data.contacts, first, end);
    first = end;
  }
}

// The rows from `first` on. The last one first, so that lists run as rows do.
void link_rows(WorldData& data, std::size_t first) {
  for (std::size_t row = data.contacts.resting.pair.size(); row-- > first;) link_row(data, row);
}

void unlink_row(WorldData& data, std::size_t row) {
  const ShapePair pair = data.contacts.resting.pair[row];
  const RestingLinks links = data.contacts.resting_links[row];
  for (const std::size_t side : {0u, 1u}) {
    SCREE_ASSERT(link_behind(data, shape_of(pair, side), links.previous[side]) == end_of(row, side));
    link_behind(data, shape_of(pair, side), links.previous[side]) = links.next[side];
    set_previous(data.contacts, links.next[side], links.previous[side]);
  }
}

// Calls visit(column) for the columns with a row for each pair, of which some may have none; without links.
template <class Visit>
void for_each_present_column(WorldData& data, Visit&& visit) {
  visit(data.contacts.resting.pair);
  visit(data.contacts.resting.contact);
  if (!data.contacts.resting.axis.empty()) visit(data.contacts.resting.axis);
  if (!data.events.resting.empty()) visit(data.events.resting);
}

void mark_row(WorldData& data, std::size_t row) { data.contacts.resting_marks.mark(row); }

void copy_row(WorldData& data, std::size_t from, std::size_t to) {
  mark_row(data, to);
  for_each_present_column(data, [=](auto& column) { column[to] = column[from]; });
}

// To a row that no list has.
void move_row(WorldData& data, std::size_t from, std::size_t to) {
  Contacts& contacts = data.contacts;
  copy_row(data, from, to);
  const ShapePair pair = contacts.resting.pair[to];
  const RestingLinks links = contacts.resting_links[to] = contacts.resting_links[from];
  for (const std::size_t side : {0u, 1u}) {
    link_behind(data, shape_of(pair, side), links.previous[side]) = end_of(to, side);
    set_previous(contacts, links.next[side], end_of(to, side));
  }
}

void drop_rows(WorldData& data, std::size_t rows) {
  for_each_present_column(data, [=](auto& column) { column.drop_back(rows); });
  data.contacts.resting_links.drop_back(rows);
  if (!data.contacts.resting_links.empty()) mark_row(data, data.contacts.resting_links.size() - 1);
}

// Removes most rows: moves the others together and rebuilds all lists.
void remove_most(WorldData& data, const Column<std::int32_t>& rows) {
  const Column<ShapePair>& resting = data.contacts.resting.pair;
  for (const ShapePair& pair : resting) {
    data.shapes.first_resting[pair.a] = 0;
    data.shapes.first_resting[pair.b] = 0;
  }
  std::size_t to = 0, gone = 0;
  for (std::size_t row = 0; row < resting.size(); ++row) {
    if (gone < rows.size() && std::cmp_equal(rows[gone], row)) {
      ++gone;
    } else {
      copy_row(data, row, to++);
    }
  }
  drop_rows(data, gone);
  link_rows(data, 0);
}

}  // namespace

void add_resting(WorldData& data, const PairRows& more) {
  Contacts& contacts = data.contacts;
  PairRows& resting = contacts.resting;
  const std::size_t first = resting.pair.size();
  SCREE_ASSERT(more.contact.size() == more.pair.size());
  SCREE_ASSERT(more.axis.empty() || more.axis.size() == more.pair.size());
  if (!more.axis.empty()) resting.axis.resize(first);  // hulls may have come since
  const bool hulls = !resting.axis.empty() || !more.axis.empty();
  resting.pair.append(more.pair.span());
  resting.contact.append(more.contact.span());
  if (!more.axis.empty()) {
    resting.axis.append(more.axis.span());
  } else if (hulls) {
    resting.axis.resize(resting.pair.size());
  }
  if (!data.events.resting.empty()) data.events.resting.resize(resting.pair.size());
  contacts.resting_links.resize_for_overwrite(resting.pair.size());
  link_rows(data, first);
  for (std::size_t row = first; row < resting.pair.size(); ++row) mark_row(data, row);
  contacts.resting_order_made.forget();
}

void remove_resting(WorldData& data, const Column<std::int32_t>& rows) {
  Contacts& contacts = data.contacts;
  SCREE_ASSERT(std::adjacent_find(rows.begin(), rows.end(), std::greater_equal<>()) == rows.end());
  contacts.resting_order_made.forget();
  if (2 * rows.size() > contacts.resting.pair.size()) return remove_most(data, rows);
  for (std::size_t i = rows.size(); i-- > 0;) {  // so that the last row is never one of those to remove
    const auto row = static_cast<std::size_t>(rows[i]);
    const std::size_t last = contacts.resting.pair.size() - 1;
    unlink_row(data, row);
    if (row != last) move_row(data, last, row);
    drop_rows(data, 1);
  }
}

void link_resting(WorldData& data) {
  Contacts& contacts = data.contacts;
  for (std::uint32_t& first : data.shapes.first_resting) {
    if (first != 0) first = 0;  // unwritten rows of zeros take no memory
  }
  contacts.resting_links.resize_for_overwrite(contacts.resting.pair.size());
  link_rows(data, 0);
  contacts.resting_order_made.forget();
}

}  // namespace scree
