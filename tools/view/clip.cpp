// See clip.h.
#include <tools/export/shape_mesh.h>
#include <tools/view/clip.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <variant>
#include <vector>

namespace scree::view {
namespace {

using Json = nlohmann::ordered_json;
using exports::Actor;
using exports::Show;

static_assert(std::endian::native == std::endian::little);

template <class Number>
std::size_t append(const std::vector<Number>& numbers, std::string& bytes) {
  const std::size_t offset = bytes.size();
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
  return offset;
}

std::vector<float> flat(const std::vector<Vec3>& vectors) {
  std::vector<float> numbers;
  for (const Vec3& vector : vectors) numbers.insert(numbers.end(), {vector.x, vector.y, vector.z});
  return numbers;
}

// The triangles all of whose corners pass.
template <class Passes>
exports::ShapeMesh part_of(const exports::ShapeMesh& whole, const Passes& passes) {
  exports::ShapeMesh part = whole;
  part.indices.clear();
  for (std::size_t i = 0; i < whole.indices.size(); i += 3) {
    const auto first = whole.indices.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::all_of(first, first + 3, passes)) part.indices.insert(part.indices.end(), first, first + 3);
  }
  return part;
}

// A shape as a page draws it: a mesh, where it is in the body's frame, and how it is stretched.
struct Piece {
  std::size_t mesh;
  Pose pose;
  Vec3 scale;
};

// Meshes, each once, and where they are in the numbers.
class Meshes {
 public:
  explicit Meshes(std::string& numbers) : numbers_(numbers) {}

  std::vector<Piece> pieces_of(const exports::ActorShape& shape) {
    if (const auto* capsule = std::get_if<Capsule>(&shape.geometry)) return pieces_of(*capsule, shape.pose);
    const std::size_t mesh = number_of(exports::key_of(shape.geometry),
                                       [&] { return exports::mesh_of(exports::unit_of(shape.geometry)); });
    list_[mesh]["surface"] = std::holds_alternative<TriangleMesh>(shape.geometry) ||
                             std::holds_alternative<HalfSpace>(shape.geometry);
    return {{mesh, shape.pose, exports::scale_of(shape.geometry)}};
  }
  // m, from the body's origin to the farthest point, or some more.
  float reach_of(const Piece& piece) const {
    const Vec3 bound = bounds_[piece.mesh];
    return length(piece.pose.position) +
           length(Vec3{piece.scale.x * bound.x, piece.scale.y * bound.y, piece.scale.z * bound.z});
  }
  const Json& list() const { return list_; }

 private:
  std::vector<Piece> pieces_of(const Capsule& capsule, const Pose& pose) {
    const exports::ShapeMesh ball = exports::mesh_of(Sphere{1.0f}),
                             drum = exports::mesh_of(Cylinder{1.0f, 1.0f});
    const std::size_t half = number_of("half ball", [&] {
      return part_of(ball, [&](std::uint32_t i) { return ball.positions[i].y >= -1e-6f; });
    });
    const std::size_t tube = number_of(
        "tube", [&] { return part_of(drum, [&](std::uint32_t i) { return drum.normals[i].y == 0.0f; }); });
    constexpr Quat kTurned{1.0f, 0.0f, 0.0f, 0.0f};  // by half a turn about x
    const float h = capsule.half_height, r = capsule.radius;
    return {{half, pose * Pose{{0.0f, h, 0.0f}, {}}, {r, r, r}},
            {half, pose * Pose{{0.0f, -h, 0.0f}, kTurned}, {r, r, r}},
            {tube, pose, {r, h, r}}};
  }
  template <class Make>
  std::size_t number_of(const std::string& key, const Make& make) {
    const auto [known, is_new] = known_.try_emplace(key, list_.size());
    if (is_new) add(make());
    return known->second;
  }
  void add(const exports::ShapeMesh& mesh) {
    Vec3 bound;
    for (const Vec3& position : mesh.positions) {
      for (int axis = 0; axis < 3; ++axis) bound[axis] = std::max(bound[axis], std::abs(position[axis]));
    }
    bounds_.push_back(bound);
    const std::size_t positions = append(flat(mesh.positions), numbers_);
    const std::size_t normals = append(flat(mesh.normals), numbers_);
    const std::size_t indices = append(mesh.indices, numbers_);
    list_.push_back({{"positions", positions},
                     {"normals", normals},
                     {"vertices", mesh.positions.size()},
                     {"indices", indices},
                     {"corners", mesh.indices.size()},
                     {"surface", false}});
  }

  std::string& numbers_;
  std::map<std::string, std::size_t> known_;
  std::vector<Vec3> bounds_;
  Json list_ = Json::array();
};

const char* name_of(BodyType type) {
  switch (type) {
    case BodyType::fixed:
      return "fixed";
    case BodyType::kinematic:
      return "kinematic";
    case BodyType::dynamic:
      break;
  }
  return "dynamic";
}

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

Json json_of(Vec3 v) { return {v.x, v.y, v.z}; }

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

// A body as pages know it, and how far it reaches from its origin, m.
struct PageBody {
  Json json;
  float reach = 0.0f;
};

PageBody body_of(const Actor& actor, Meshes& meshes) {
  PageBody body;
  body.json = {{"index", actor.body.index},
               {"type", name_of(actor.type)},
               {"first", actor.first},
               {"count", actor.poses.size()}};
  const Pose& pose = actor.poses.front();
  body.json["pose"] = {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x,
                       pose.rotation.y, pose.rotation.z, pose.rotation.w};
  body.json["shape_count"] = actor.shapes.size();  // a shape may be several pieces
  body.json["shapes"] = Json::array();
  for (const exports::ActorShape& shape : actor.shapes) {
    for (const Piece& piece : meshes.pieces_of(shape)) {
      const Vec3 p = piece.pose.position, s = piece.scale;
      const Quat q = piece.pose.rotation;
      body.json["shapes"].push_back({piece.mesh, p.x, p.y, p.z, q.x, q.y, q.z, q.w, s.x, s.y, s.z});
      if (!std::holds_alternative<HalfSpace>(shape.geometry))
        body.reach = std::max(body.reach, meshes.reach_of(piece));
    }
  }
  return body;
}

// m, of the largest dynamic body; where there are none, of kinematic or fixed ones.
float size_of(const Show& show, const std::vector<PageBody>& bodies) {
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
  std::vector<PageBody> bodies;
  for (const Actor& actor : show.actors) bodies.push_back(body_of(actor, meshes));
  const float size = size_of(show, bodies);
  Json list = Json::array();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const float reach = bodies[i].reach > 0.0f ? bodies[i].reach : size;
    if (!exports::stands_still(show.actors[i]))
      bodies[i].json["track"] = append_track(show.actors[i], reach, numbers);
    list.push_back(std::move(bodies[i].json));
  }
  const Json head = {{"title", title},          {"up", json_of(show.up)},   {"size", size},
                     {"times", show.times},     {"steps", show.steps},      {"stats", stats_of(show)},
                     {"meshes", meshes.list()}, {"bodies", std::move(list)}};
  const std::string text = head.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string bytes(sizeof(std::uint32_t), '\0');
  const auto length = static_cast<std::uint32_t>(text.size());
  std::memcpy(bytes.data(), &length, sizeof length);
  return pack(bytes + text + numbers);
}

}  // namespace scree::view
