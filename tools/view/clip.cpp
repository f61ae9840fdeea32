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

// Meshes, each once, and where they are in the numbers.
class Meshes {
 public:
  explicit Meshes(std::string& numbers) : numbers_(numbers) {}

  std::size_t number_of(const Geometry& geometry) {
    const auto [known, is_new] = known_.try_emplace(exports::key_of(geometry), list_.size());
    if (is_new) add(geometry);
    return known->second;
  }
  // m, from the origin of the shape to its farthest point.
  float reach_of(const Geometry& geometry) {
    const Vec3 scale = exports::scale_of(geometry), bound = bounds_[number_of(geometry)];
    return length(Vec3{scale.x * bound.x, scale.y * bound.y, scale.z * bound.z});
  }
  const Json& list() const { return list_; }

 private:
  void add(const Geometry& geometry) {
    const exports::ShapeMesh mesh = exports::mesh_of(exports::unit_of(geometry));
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
                     {"surface", std::holds_alternative<TriangleMesh>(geometry) ||
                                     std::holds_alternative<HalfSpace>(geometry)}});
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

void append_differences(const std::vector<std::uint16_t>& codes, std::string& bytes) {
  std::string low, high;
  std::uint16_t last = 0;
  for (const std::uint16_t code : codes) {
    const auto difference = static_cast<std::uint16_t>(code - last);
    low += static_cast<char>(difference & 0xff);
    high += static_cast<char>(difference >> 8);
    last = code;
  }
  bytes += low + high;
}

Json json_of(Vec3 v) { return {v.x, v.y, v.z}; }

Json append_track(const Actor& actor, std::string& bytes) {
  constexpr double kParts = 65535.0, kUnit = 32767.0;
  Vec3 lower = actor.poses.front().position, upper = lower;
  for (const Pose& pose : actor.poses) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], pose.position[axis]);
      upper[axis] = std::max(upper[axis], pose.position[axis]);
    }
  }
  const Json track = {{"offset", bytes.size()}, {"lower", json_of(lower)}, {"upper", json_of(upper)}};
  std::vector<std::uint16_t> codes(actor.poses.size());
  for (int axis = 0; axis < 3; ++axis) {
    const double size = double{upper[axis]} - double{lower[axis]};
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const double share =
          size > 0.0 ? (double{actor.poses[i].position[axis]} - double{lower[axis]}) / size : 0.0;
      codes[i] = static_cast<std::uint16_t>(std::lround(kParts * share));
    }
    append_differences(codes, bytes);
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
      codes[i] = static_cast<std::uint16_t>(std::lround(kUnit * double{rotations[i].*part}));
    append_differences(codes, bytes);
  }
  return track;
}

Json body_of(const Actor& actor, Meshes& meshes) {
  Json body = {{"index", actor.body.index},
               {"type", name_of(actor.type)},
               {"first", actor.first},
               {"count", actor.poses.size()}};
  const Pose& pose = actor.poses.front();
  body["pose"] = {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x,
                  pose.rotation.y, pose.rotation.z, pose.rotation.w};
  body["shapes"] = Json::array();
  for (const exports::ActorShape& shape : actor.shapes) {
    const Vec3 p = shape.pose.position, s = exports::scale_of(shape.geometry);
    const Quat q = shape.pose.rotation;
    body["shapes"].push_back(
        {meshes.number_of(shape.geometry), p.x, p.y, p.z, q.x, q.y, q.z, q.w, s.x, s.y, s.z});
  }
  return body;
}

// m: how far the largest dynamic bodies reach from their origins; where there are none, kinematic or fixed
// ones.
float size_of(const Show& show, Meshes& meshes) {
  for (const BodyType type : {BodyType::dynamic, BodyType::kinematic, BodyType::fixed}) {
    float largest = 0.0f;
    for (const Actor& actor : show.actors) {
      if (actor.type != type) continue;
      for (const exports::ActorShape& shape : actor.shapes) {
        if (std::holds_alternative<HalfSpace>(shape.geometry)) continue;
        largest = std::max(largest, length(shape.pose.position) + meshes.reach_of(shape.geometry));
      }
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
    awake.push_back(show.stats[sample].awake_bodies);
    contacts.push_back(show.stats[sample].contacts);
    energy.push_back(show.stats[sample].kinetic_energy);
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
  Json bodies = Json::array();
  for (const Actor& actor : show.actors) bodies.push_back(body_of(actor, meshes));
  const float size = size_of(show, meshes);
  for (std::size_t i = 0; i < show.actors.size(); ++i) {
    if (!exports::stands_still(show.actors[i])) bodies[i]["track"] = append_track(show.actors[i], numbers);
  }
  const Json head = {{"title", title},          {"up", json_of(show.up)},     {"size", size},
                     {"times", show.times},     {"steps", show.steps},        {"stats", stats_of(show)},
                     {"meshes", meshes.list()}, {"bodies", std::move(bodies)}};
  const std::string text = head.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string bytes(sizeof(std::uint32_t), '\0');
  const auto length = static_cast<std::uint32_t>(text.size());
  std::memcpy(bytes.data(), &length, sizeof length);
  return pack(bytes + text + numbers);
}

}  // namespace scree::view
