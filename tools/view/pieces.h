// Bodies as pages draw them: shapes as pieces, which are meshes, put in place and stretched. A page has each
// mesh once. Capsules are two half balls and a tube, so that all of them share two meshes.
#pragma once

#include <tools/export/shape_mesh.h>
#include <tools/export/show.h>

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace scree::view {

using Json = nlohmann::ordered_json;

// A mesh, where it is in the body's frame, and how it is stretched.
struct Piece {
  std::size_t mesh;
  Pose pose;
  Vec3 scale;
};

// The meshes of a page. Their positions and normals (float) and indices (u32) go to the end of `numbers`; the
// list says at which bytes.
class Meshes {
 public:
  explicit Meshes(std::string& numbers) : numbers_(numbers) {}

  std::vector<Piece> pieces_of(const exports::ActorShape& shape);
  // m, from the body's origin to the farthest point, or some more.
  float reach_of(const Piece& piece) const;
  // Of the meshes that are new since the last call.
  Json take_list();

 private:
  std::vector<Piece> pieces_of(const Capsule& capsule, const Pose& pose);
  template <class Make>
  std::size_t number_of(const std::string& key, const Make& make);
  void add(const exports::ShapeMesh& mesh);

  std::string& numbers_;
  std::map<std::string, std::size_t> known_;
  std::vector<Vec3> bounds_;
  Json list_ = Json::array();
};

// The pieces of a body, and how far it reaches from its origin, m, but for half-spaces.
struct BodyPieces {
  std::vector<Piece> pieces;
  float reach = 0.0f;
};

BodyPieces pieces_of(const std::vector<exports::ActorShape>& shapes, Meshes& meshes);

// A body in the JSON of a page, with its pieces.
Json json_of(const exports::Actor& actor, const std::vector<Piece>& pieces);

Json json_of(Vec3 v);

}  // namespace scree::view
