// See clip.h.
#include <tools/view/clip.h>
#include <tools/view/pieces.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace scree::view {
namespace {

using exports::Actor;
using exports::Show;

// Of numbers below 256^bytes.
void append_differences(const std::vector<std::uint32_t>& codes, int bytes, std::string& to) {
  std::vector<std::string> planes(static_cast<std::size_t>(bytes));
  std::uint32_t last = 0;
  for (const std::uint32_t code : codes) {
    const std::uint32_t difference = code - last;  // modulo 2^32, and so modulo each smaller power of 256
    for (int k = 0; k < bytes; ++k)
      planes[static_cast<std::size_t>(k)] += static_cast<char>(difference >> 8 * k & 0xff);
    last = code;
  }
  for (const std::string& plane : planes) to += plane;
}

// `size`: m, of the body.
Json append_track(const Actor& actor, float size, std::string& to) {
  constexpr double kUnit = 32767.0, kShare = 1.0 / 500.0;
  constexpr int kRotationBytes = 2;
  Vec3 lower = actor.poses.front().position, upper = lower;
  for (const Pose& pose : actor.poses) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], pose.position[axis]);
      upper[axis] = std::max(upper[axis], pose.position[axis]);
    }
  }
  const auto side = [&](int axis) { return double{upper[axis]} - double{lower[axis]}; };
  const double largest = std::max({side(0), side(1), side(2)});
  const auto parts = [](int bytes) { return std::ldexp(1.0, 8 * bytes) - 1.0; };
  int bytes = 2;
  while (bytes < 4 && largest / parts(bytes) > kShare * double{size}) ++bytes;
  const Json track = {
      {"offset", to.size()}, {"bytes", bytes}, {"lower", json_of(lower)}, {"upper", json_of(upper)}};
  std::vector<std::uint32_t> codes(actor.poses.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const double from = double{actor.poses[i].position[axis]} - double{lower[axis]};
      codes[i] =
          static_cast<std::uint32_t>(std::llround(side(axis) > 0.0 ? parts(bytes) * from / side(axis) : 0.0));
    }
    append_differences(codes, bytes, to);
  }
  std::vector<Quat> rotations;
  for (const Pose& pose : actor.poses) {
    Quat rotation = normalize(pose.rotation);
    // Of q and -q the one that is nearer to the last.
    if (!rotations.empty() && dot(rotation, rotations.back()) < 0.0f)
      rotation = {-rotation.x, -rotation.y, -rotation.z, -rotation.w};
    rotations.push_back(rotation);
  }
  for (float Quat::*part : {&Quat::x, &Quat::y, &Quat::z, &Quat::w}) {
    for (std::size_t i = 0; i < codes.size(); ++i)
      codes[i] = static_cast<std::uint32_t>(std::lround(kUnit * double{rotations[i].*part}));
    append_differences(codes, kRotationBytes, to);
  }
  return track;
}

// m, of the largest dynamic body; where there are none, of kinematic or fixed ones.
float size_of(const Show& show, const std::vector<BodyPieces>& bodies) {
  for (const BodyType type : {BodyType::dynamic, BodyType::kinematic, BodyType::fixed}) {
    float largest = 0.0f;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (show.actors[i].type == type) largest = std::max(largest, bodies[i].reach);
    }
    if (largest > 0.0f) return largest;
  }
  return 1.0f;
}

Json stats_of(const Show& show) {
  Json bodies = Json::array(), awake = Json::array(), contacts = Json::array(), energy = Json::array();
  std::vector<std::ptrdiff_t> changes(show.times.size() + 1);
  for (const Actor& actor : show.actors) {
    ++changes[actor.first];
    --changes[actor.first + actor.poses.size()];
  }
  std::ptrdiff_t living = 0;
  for (std::size_t sample = 0; sample < show.times.size(); ++sample) {
    living += changes[sample];
    bodies.push_back(living);
    const StepStats& stats = show.stats[sample];
    const bool is_known = sample > 0;  // no step was played for the first one
    awake.push_back(is_known ? Json(stats.awake_bodies) : Json());
    contacts.push_back(is_known ? Json(stats.contacts) : Json());
    energy.push_back(is_known ? Json(stats.kinetic_energy) : Json());
  }
  return {{"bodies", bodies}, {"awake", awake}, {"contacts", contacts}, {"energy", energy}};
}

std::string pack(const std::string& bytes) {
  constexpr int kLevel = 6, kGzip = 15 + 16, kMemory = 9;
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string packed;
  std::vector<unsigned char> block(1 << 20);
  std::size_t taken = 0;
  int result = Z_OK;
  while (result == Z_OK) {
    if (stream.avail_in == 0) {
      const std::size_t size = std::min<std::size_t>(bytes.size() - taken, 1 << 30);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + taken));
      stream.avail_in = static_cast<uInt>(size);
      taken += size;
    }
    stream.next_out = block.data();
    stream.avail_out = static_cast<uInt>(block.size());
    result = deflate(&stream, taken == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    packed.append(reinterpret_cast<const char*>(block.data()), block.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw std::runtime_error("zlib: error " + std::to_string(result));
  return packed;
}

}  // namespace

std::string make_clip(const Show& show, const std::string& title) {
  std::string numbers;
  Meshes meshes(numbers);
  std::vector<BodyPieces> bodies;
  for (const Actor& actor : show.actors) bodies.push_back(pieces_of(actor.shapes, meshes));
  const float size = size_of(show, bodies);
  Json list = Json::array();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const float reach = bodies[i].reach > 0.0f ? bodies[i].reach : size;
    list.push_back(json_of(show.actors[i], bodies[i].pieces));
    if (!exports::stands_still(show.actors[i]))
      list.back()["track"] = append_track(show.actors[i], reach, numbers);
  }
  const Json head = {{"title", title},
                     {"up", json_of(show.up)},
                     {"size", size},
                     {"times", show.times},
                     {"steps", show.steps},
                     {"stats", stats_of(show)},
                     {"meshes", meshes.take_list()},
                     {"bodies", std::move(list)}};
  const std::string text = head.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string bytes(sizeof(std::uint32_t), '\0');
  const auto length = static_cast<std::uint32_t>(text.size());
  std::memcpy(bytes.data(), &length, sizeof length);
  return pack(bytes + text + numbers);
}

}  // namespace scree::view
