// See pieces.h.
#include <tools/view/pieces.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <variant>

namespace scree::view {
namespace {

using exports::Actor;

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

const char* type_name(BodyType type) {
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

}  // namespace

std::vector<Piece> Meshes::pieces_of(const exports::ActorShape& shape) {
  if (const auto* capsule = std::get_if<Capsule>(&shape.geometry)) return pieces_of(*capsule, shape.pose);
  const auto known = list_.size();
  const std::size_t mesh = number_of(exports::key_of(shape.geometry),
                                     [&] { return exports::mesh_of(exports::unit_of(shape.geometry)); });
  if (list_.size() > known) {
    list_.back()["surface"] = std::holds_alternative<TriangleMesh>(shape.geometry) ||
                              std::holds_alternative<HalfSpace>(shape.geometry);
  }
  return {{mesh, shape.pose, exports::scale_of(shape.geometry)}};
}

float Meshes::reach_of(const Piece& piece) const {
  const Vec3 bound = bounds_[piece.mesh];
  return length(piece.pose.position) +
         length(Vec3{piece.scale.x * bound.x, piece.scale.y * bound.y, piece.scale.z * bound.z});
}

Json Meshes::take_list() { return std::exchange(list_, Json::array()); }

std::vector<Piece> Meshes::pieces_of(const Capsule& capsule, const Pose& pose) {
  const auto half_ball = [] {
    const exports::ShapeMesh ball = exports::mesh_of(Sphere{1.0f});
    return part_of(ball, [&](std::uint32_t i) { return ball.positions[i].y >= -1e-6f; });
  };
  const auto drum_side = [] {
    const exports::ShapeMesh drum = exports::mesh_of(Cylinder{1.0f, 1.0f});
    return part_of(drum, [&](std::uint32_t i) { return drum.normals[i].y == 0.0f; });
  };
  const std::size_t half = number_of("half ball", half_ball), tube = number_of("tube", drum_side);
  constexpr Quat kTurned{1.0f, 0.0f, 0.0f, 0.0f};  // by half a turn about x
  const float h = capsule.half_height, r = capsule.radius;
  return {{half, pose * Pose{{0.0f, h, 0.0f}, {}}, {r, r, r}},
          {half, pose * Pose{{0.0f, -h, 0.0f}, kTurned}, {r, r, r}},
          {tube, pose, {r, h, r}}};
}

template <class Make>
std::size_t Meshes::number_of(const std::string& key, const Make& make) {
  const auto [known, is_new] = known_.try_emplace(key, bounds_.size());
  if (is_new) add(make());
  return known->second;
}

void Meshes::add(const exports::ShapeMesh& mesh) {
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

Json json_of(Vec3 v) { return {v.x, v.y, v.z}; }

BodyPieces pieces_of(const std::vector<exports::ActorShape>& shapes, Meshes& meshes) {
  BodyPieces body;
  for (const exports::ActorShape& shape : shapes) {
    for (const Piece& piece : meshes.pieces_of(shape)) {
      body.pieces.push_back(piece);
      if (!std::holds_alternative<HalfSpace>(shape.geometry))
        body.reach = std::max(body.reach, meshes.reach_of(piece));
    }
  }
  return body;
}

Json json_of(const Actor& actor, const std::vector<Piece>& pieces) {
  Json body = {{"index", actor.body.index},
               {"type", type_name(actor.type)},
               {"first", actor.first},
               {"count", actor.poses.size()}};
  const Pose& pose = actor.poses.front();
  body["pose"] = {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x,
                  pose.rotation.y, pose.rotation.z, pose.rotation.w};
  body["shape_count"] = actor.shapes.size();  // a shape may be several pieces
  body["shapes"] = Json::array();
  for (const Piece& piece : pieces) {
    const Vec3 p = piece.pose.position, s = piece.scale;
    const Quat q = piece.pose.rotation;
    body["shapes"].push_back({piece.mesh, p.x, p.y, p.z, q.x, q.y, q.z, q.w, s.x, s.y, s.z});
  }
  return body;
}

}  // namespace scree::view
