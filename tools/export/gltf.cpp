// Bodies are nodes that the animation moves, and their shapes are nodes below them. Meshes are shared by all
// shapes that differ by their scale alone, once a color. Section numbers are those of the glTF 2.0
// specification.
#include <scree/error.h>
#include <tools/export/base64.h>
#include <tools/export/gltf.h>
#include <tools/export/shape_mesh.h>
#include <tools/render/coloring.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

namespace scree::exports {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little);

// Values of the specification: componentType, buffer views' target, mode.
constexpr int kFloat = 5126, kUnsignedInt = 5125;
constexpr int kVertexBuffer = 34962, kIndexBuffer = 34963;

Json json_of(Vec3 v) { return {v.x, v.y, v.z}; }
Json json_of(Quat q) { return {q.x, q.y, q.z, q.w}; }

[[noreturn]] void refuse_size(std::size_t bytes) {
  throw Error("export: the animation takes " + std::to_string(bytes >> 20) +
              " MiB, glTF holds 4096; ask for fewer steps");
}

class Writer {
 public:
  explicit Writer(const Show& show) : show_(show) {}

  Json write() {
    json_["asset"] = {{"version", "2.0"}, {"generator", "scree"}};
    json_["scene"] = 0;
    json_["scenes"] = {{{"nodes", {0}}}};
    Json root = {{"name", "world"}};
    root["rotation"] = json_of(turn_to(show_.up, {0.0f, 1.0f, 0.0f}));  // glTF's y points up (3.4)
    nodes_.push_back(root);
    Json children = Json::array();
    for (const Actor& actor : show_.actors) {
      if (!actor.shapes.empty()) children.push_back(add_actor(actor));
    }
    if (!children.empty()) nodes_[0]["children"] = children;
    json_["nodes"] = nodes_;
    if (!meshes_.empty()) json_["meshes"] = meshes_;
    if (!materials_.empty()) json_["materials"] = materials_;
    if (!channels_.empty())
      json_["animations"] = {{{"name", "recording"}, {"channels", channels_}, {"samplers", samplers_}}};
    if (buffer_.size() > std::numeric_limits<std::uint32_t>::max()) refuse_size(buffer_.size());
    if (!buffer_.empty()) {
      json_["accessors"] = accessors_;
      json_["bufferViews"] = views_;
      json_["buffers"] = {{{"byteLength", buffer_.size()}}};
    }
    return json_;
  }
  const std::string& buffer() const { return buffer_; }

 private:
  template <class Number>
  std::size_t add_view(const std::vector<Number>& numbers, int target) {
    Json view = {
        {"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", numbers.size() * sizeof(Number)}};
    if (target != 0) view["target"] = target;
    buffer_.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
    views_.push_back(view);
    return views_.size() - 1;
  }
  template <class Number>
  std::size_t add_accessor(const std::vector<Number>& numbers, std::size_t count, const char* type,
                           int target = 0) {
    accessors_.push_back({{"bufferView", add_view(numbers, target)},
                          {"componentType", std::is_same_v<Number, float> ? kFloat : kUnsignedInt},
                          {"count", count},
                          {"type", type}});
    return accessors_.size() - 1;
  }

  std::size_t add_positions(const std::vector<Vec3>& positions) {
    std::vector<float> numbers;
    Vec3 least = positions.front(), most = least;
    for (const Vec3& position : positions) {
      for (int axis = 0; axis < 3; ++axis) {
        numbers.push_back(position[axis]);
        least[axis] = std::min(least[axis], position[axis]);
        most[axis] = std::max(most[axis], position[axis]);
      }
    }
    const std::size_t accessor = add_accessor(numbers, positions.size(), "VEC3", kVertexBuffer);
    accessors_[accessor]["min"] = json_of(least);  // positions must state their bounds (3.7.2.1)
    accessors_[accessor]["max"] = json_of(most);
    return accessor;
  }
  std::size_t add_vectors(const std::vector<Vec3>& vectors, int target = 0) {
    std::vector<float> numbers;
    for (const Vec3& vector : vectors) {
      for (int axis = 0; axis < 3; ++axis) numbers.push_back(vector[axis]);
    }
    return add_accessor(numbers, vectors.size(), "VEC3", target);
  }

  std::size_t material_of(const Actor& actor) {
    const render::Color color = actor.type == BodyType::fixed
                                    ? render::fixed_color()
                                    : render::palette_color(actor.body.index % render::kPaletteSize);
    const auto [known, is_new] =
        material_by_color_.try_emplace({color.x, color.y, color.z}, materials_.size());
    if (is_new) {
      materials_.push_back({{"pbrMetallicRoughness",
                             {{"baseColorFactor", {color.x, color.y, color.z, 1.0f}},
                              {"metallicFactor", 0.0f},
                              {"roughnessFactor", 0.7f}}}});
    }
    return known->second;
  }

  // The attributes of a mesh, which meshes of several colors share.
  Json primitive_of(const Geometry& geometry, const std::string& key) {
    const auto known = primitive_by_key_.find(key);
    if (known != primitive_by_key_.end()) return known->second;
    const ShapeMesh mesh = mesh_of(unit_of(geometry));
    const std::size_t positions = add_positions(mesh.positions);
    const std::size_t normals = add_vectors(mesh.normals, kVertexBuffer);
    const std::size_t indices = add_accessor(mesh.indices, mesh.indices.size(), "SCALAR", kIndexBuffer);
    const Json primitive = {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                            {"indices", indices}};
    primitive_by_key_.emplace(key, primitive);
    return primitive;
  }
  std::size_t mesh_for(const Geometry& geometry, std::size_t material) {
    const std::string key = key_of(geometry);
    const auto [known, is_new] = mesh_by_key_.try_emplace({key, material}, meshes_.size());
    if (is_new) {
      Json primitive = primitive_of(geometry, key);
      primitive["material"] = material;
      meshes_.push_back({{"primitives", {primitive}}});
    }
    return known->second;
  }

  std::size_t add_actor(const Actor& actor) {
    const std::size_t node = nodes_.size();
    const Pose& pose = actor.poses.front();
    nodes_.push_back({{"name", "body " + std::to_string(actor.body.index)},
                      {"translation", json_of(pose.position)},
                      {"rotation", json_of(normalize(pose.rotation))}});
    Json children = Json::array();
    const std::size_t material = material_of(actor);
    for (const ActorShape& shape : actor.shapes) {
      children.push_back(nodes_.size());
      nodes_.push_back({{"mesh", mesh_for(shape.geometry, material)},
                        {"translation", json_of(shape.pose.position)},
                        {"rotation", json_of(normalize(shape.pose.rotation))},
                        {"scale", json_of(scale_of(shape.geometry))}});
    }
    nodes_[node]["children"] = children;
    if (!stands_still(actor)) animate(actor, node);
    if (!is_always_there(show_, actor)) hide(actor, node);
    return node;
  }

  // The times of an actor's poses; shared by all that live as long.
  std::size_t times_of(std::size_t first, std::size_t count) {
    const auto [known, is_new] = times_by_span_.try_emplace({first, count}, 0);
    if (is_new)
      known->second = add_times({show_.times.begin() + static_cast<std::ptrdiff_t>(first),
                                 show_.times.begin() + static_cast<std::ptrdiff_t>(first + count)});
    return known->second;
  }
  std::size_t add_times(const std::vector<double>& times) {
    const std::vector<float> numbers(times.begin(), times.end());
    const std::size_t accessor = add_accessor(numbers, numbers.size(), "SCALAR");
    accessors_[accessor]["min"] = {numbers.front()};  // as those of positions
    accessors_[accessor]["max"] = {numbers.back()};
    return accessor;
  }
  void add_channel(std::size_t node, const char* path, std::size_t times, std::size_t values,
                   const char* interpolation) {
    channels_.push_back({{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers_.push_back({{"input", times}, {"output", values}, {"interpolation", interpolation}});
  }

  void animate(const Actor& actor, std::size_t node) {
    std::vector<Vec3> positions;
    std::vector<float> rotations;
    Quat last = actor.poses.front().rotation;
    for (const Pose& pose : actor.poses) {
      positions.push_back(pose.position);
      // Of q and -q the one that is nearer to the last: not all viewers turn by the shorter way.
      Quat rotation = normalize(pose.rotation);
      if (dot(rotation, last) < 0.0f) rotation = {-rotation.x, -rotation.y, -rotation.z, -rotation.w};
      for (const float part : {rotation.x, rotation.y, rotation.z, rotation.w}) rotations.push_back(part);
      last = rotation;
    }
    const std::size_t times = times_of(actor.first, actor.poses.size());
    add_channel(node, "translation", times, add_vectors(positions), "LINEAR");
    add_channel(node, "rotation", times, add_accessor(rotations, actor.poses.size(), "VEC4"), "LINEAR");
  }

  // A body that arrives later, or leaves, has no size meanwhile.
  void hide(const Actor& actor, std::size_t node) {
    std::vector<double> times;
    std::vector<Vec3> scales;
    const auto add = [&](std::size_t sample, float scale) {
      times.push_back(show_.times[sample]);
      scales.push_back({scale, scale, scale});
    };
    const std::size_t end = actor.first + actor.poses.size();
    if (actor.first > 0) add(0, 0.0f);
    add(actor.first, 1.0f);
    if (end < show_.times.size()) add(end, 0.0f);
    add_channel(node, "scale", add_times(times), add_vectors(scales), "STEP");
  }

  const Show& show_;
  Json json_;
  std::vector<Json> nodes_, meshes_, materials_, accessors_, views_, channels_, samplers_;
  std::string buffer_;
  std::map<std::vector<float>, std::size_t> material_by_color_;
  std::map<std::string, Json> primitive_by_key_;
  std::map<std::pair<std::string, std::size_t>, std::size_t> mesh_by_key_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> times_by_span_;
};

void put_number(std::uint32_t number, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void put_chunk(const char* type, const std::string& content, char filler, std::string& bytes) {
  const std::size_t padding = (4 - content.size() % 4) % 4;
  put_number(static_cast<std::uint32_t>(content.size() + padding), bytes);
  bytes.append(type, 4);
  bytes += content;
  bytes.append(padding, filler);
}

}  // namespace

std::string to_gltf(const Show& show) {
  Writer writer(show);
  Json json = writer.write();
  if (!writer.buffer().empty())
    json["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(writer.buffer());
  return json.dump() + "\n";
}

std::string to_glb(const Show& show) {
  Writer writer(show);
  const std::string json = writer.write().dump();
  std::string chunks;  // section 4.4
  put_chunk("JSON", json, ' ', chunks);
  if (!writer.buffer().empty()) put_chunk("BIN\0", writer.buffer(), '\0', chunks);
  constexpr std::uint32_t kVersion = 2, kHead = 12;
  if (chunks.size() > std::numeric_limits<std::uint32_t>::max() - kHead) refuse_size(chunks.size());
  std::string bytes = "glTF";
  put_number(kVersion, bytes);
  put_number(static_cast<std::uint32_t>(kHead + chunks.size()), bytes);
  return bytes + chunks;
}

}  // namespace scree::exports
