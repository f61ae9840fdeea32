// libFuzzer's program for snapshots. Seals mutated bytes again, because a wrong checksum would stop every
// test there. Changes columns as units: it also moves the bytes after a column whose size changes.
#include <core/state/snapshot/snapshot_bytes.h>
#include <scree/scree.h>
#include <tests/fuzz/laws.h>
#include <tests/fuzz/mutation.h>

#include <algorithm>

namespace scree::fuzz {

namespace {

constexpr std::size_t kHeadBytes = 40;  // up to what the checksum covers
constexpr std::size_t kAlignment = 8;   // of columns

struct Place {
  std::size_t rows_at;  // of the number of rows, which the number of bytes follows
  std::size_t begin;
  std::uint64_t rows;
  std::uint64_t bytes;
};

std::uint64_t number_at(const Buffer& bytes, std::size_t at) {
  std::uint64_t number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}
void put_number(Buffer& bytes, std::size_t at, std::uint64_t number) {
  std::memcpy(bytes.data() + at, &number, sizeof number);
}

// Behind the number that says how many bytes are left; 0: nowhere.
std::size_t find_begin_of_columns(const Buffer& bytes) {
  for (std::size_t at = kHeadBytes; at + sizeof(std::uint64_t) <= bytes.size(); ++at) {
    if (number_at(bytes, at) == bytes.size() - at - sizeof(std::uint64_t)) return at + sizeof(std::uint64_t);
  }
  return 0;
}

// The columns as far as they fit together.
std::vector<Place> find_places(const Buffer& bytes, std::size_t begin) {
  std::vector<Place> places;
  std::size_t at = begin;
  while (at + 2 * sizeof(std::uint64_t) <= bytes.size()) {
    const Place place{at, at + 2 * sizeof(std::uint64_t), number_at(bytes, at),
                      number_at(bytes, at + sizeof(std::uint64_t))};
    if (place.bytes > bytes.size() - place.begin) break;
    places.push_back(place);
    at = begin + (place.begin + static_cast<std::size_t>(place.bytes) - begin + kAlignment - 1) / kAlignment *
                     kAlignment;
  }
  return places;
}

// Gives a column other bytes, and as many rows if they come to whole ones.
void replace_column(Buffer& bytes, std::size_t begin, const Place& place, const Buffer& column) {
  const auto old = static_cast<std::size_t>(place.bytes);
  const std::size_t row = place.rows > 0 ? old / static_cast<std::size_t>(place.rows) : 0;
  put_number(bytes, place.rows_at + sizeof(std::uint64_t), column.size());
  if (row > 0) put_number(bytes, place.rows_at, column.size() / row);
  const auto padded = [&](std::size_t count) {
    const std::size_t end = place.begin - begin + count;
    return std::min((end + kAlignment - 1) / kAlignment * kAlignment + begin,
                    std::max(bytes.size(), end + begin));
  };
  const std::size_t next = padded(old);
  Buffer rest(bytes.begin() + static_cast<std::ptrdiff_t>(next), bytes.end());
  bytes.resize(place.begin);
  bytes.insert(bytes.end(), column.begin(), column.end());
  while ((bytes.size() - begin) % kAlignment != 0) bytes.push_back({});
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  put_number(bytes, begin - sizeof(std::uint64_t), bytes.size() - begin);
}

// Copies a few bytes of a column over others: rows that are equal, out of order or another's.
void copy_within(std::span<std::byte> column, scenes::Random& random) {
  constexpr std::uint32_t kStride = 4;
  const auto words = static_cast<std::uint32_t>(column.size() / kStride);
  if (words < 2) return;
  const std::uint32_t count = 1 + random.below(std::min(words / 2, 8u));
  const std::size_t from = kStride * random.below(words - count + 1),
                    to = kStride * random.below(words - count + 1);
  std::memmove(column.data() + to, column.data() + from, kStride * count);
}

// Changes a world by calls, so that the fuzzer sees states that flipped bytes do not reach.
void call_something(Buffer& bytes, std::size_t most, scenes::Random& random) {
  try {
    World world;
    restore(world, read_snapshot(bytes));
    const BodyId body = world.body_at(random.below(32));
    ShapeId shapes[1];
    const bool alive = world.is_alive(body);
    switch (random.below(6)) {
      case 0:
        if (alive) world.destroy_body(body);
        break;
      case 1:
        if (alive && world.shapes_of(body, shapes) > 0) world.destroy_shape(shapes[0]);
        break;
      case 2:
        world.add_shape(alive ? body : world.create_body({.position = {0.0f, 2.0f, 0.0f}}), Sphere{0.3f});
        break;
      case 3:
        if (alive) world.set_body_type(body, static_cast<BodyType>(random.below(3)));
        break;
      case 4:
        if (alive) world.set_pose(body, {{random.between(-1.0f, 1.0f), random.unit(), 0.0f}, {}});
        break;
      default:
        break;
    }
    for (std::uint32_t i = random.below(4); i > 0 && world.shape_count() < 64; --i) {
      step(world, 1.0f / 60.0f, wide_workers());
    }
    Buffer written = bytes_of(world);
    if (written.size() <= most) bytes = std::move(written);
  } catch (const Error&) {
    // Bytes that are no snapshot stay as they are: the target checks their error.
  }
}

void mutate(Buffer& bytes, std::size_t most, scenes::Random& random) {
  const std::size_t begin = bytes.size() > kHeadBytes ? find_begin_of_columns(bytes) : 0;
  const std::uint32_t how = random.below(16);
  if (begin == 0 || how < 2) return mutate_freely(bytes, most);
  if (how < 3) return call_something(bytes, most, random);
  if (how < 5) {  // settings and hulls
    const std::size_t end = begin - sizeof(std::uint64_t);
    const std::span<std::byte> front = std::span(bytes).subspan(kHeadBytes, end - kHeadBytes);
    return how == 3 ? put_a_word(front, random) : mutate_in_place(front);
  }
  const std::vector<Place> places = find_places(bytes, begin);
  if (places.empty()) return mutate_freely(bytes, most);
  const Place& place = places[random.below(static_cast<std::uint32_t>(places.size()))];
  const std::span<std::byte> column =
      std::span(bytes).subspan(place.begin, static_cast<std::size_t>(place.bytes));
  if (how < 8) return put_a_word(column, random);
  if (how < 10) return copy_within(column, random);
  if (how < 13) return mutate_in_place(column);
  if (how < 14) return mutate_in_place(std::span(bytes).subspan(place.rows_at, 2 * sizeof(std::uint64_t)));
  Buffer other(column.begin(), column.end());
  const std::size_t room = most > bytes.size() + kAlignment ? most - bytes.size() - kAlignment : 0;
  mutate_freely(other, other.size() + std::min<std::size_t>(room, 512));
  replace_column(bytes, begin, place, other);
}

}  // namespace

}  // namespace scree::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t bytes) {
  scree::fuzz::snapshot_target({data, bytes});
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t bytes, std::size_t most,
                                               unsigned seed) {
  scree::scenes::Random random(seed);
  const auto* first = reinterpret_cast<const std::byte*>(data);
  scree::fuzz::Buffer mutated(first, first + bytes);
  for (std::uint32_t count = 1 + random.below(3); count > 0; --count) {
    scree::fuzz::mutate(mutated, most, random);
  }
  if (mutated.size() > most) return bytes;
  const bool sealed = mutated.size() >= scree::fuzz::kHeadBytes && random.below(32) != 0;
  if (sealed) scree::seal_snapshot(mutated);
  std::copy(mutated.begin(), mutated.end(), reinterpret_cast<std::byte*>(data));
  return mutated.size();
}
