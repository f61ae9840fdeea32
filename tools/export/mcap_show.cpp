// See mcap_show.h.
#include <tools/export/mcap.h>
#include <tools/export/mcap_show.h>
#include <tools/export/shape_mesh.h>
#include <tools/render/coloring.h>

#include <charconv>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

namespace scree::exports {
namespace {

using Json = nlohmann::ordered_json;

// Viewers know the schemas by their names; these say what the messages are at the top.
constexpr const char* kSceneSchema =
    R"({"title": "foxglove.SceneUpdate", "type": "object", "properties": {"deletions": {"type": "array"}, )"
    R"("entities": {"type": "array"}}})";
constexpr const char* kTransformsSchema =
    R"({"title": "foxglove.FrameTransforms", "type": "object", "properties": {"transforms": {"type": "array"}}})";
constexpr const char* kStatsSchema =
    R"({"title": "scree.Stats", "type": "object", "properties": {"step": {"type": "integer"}, )"
    R"("bodies": {"type": "integer"}, "contacts": {"type": "integer"}, "awake_bodies": {"type": "integer"}, )"
    R"("kinetic_energy": {"type": "number"}, "residual": {"type": "number"}}})";

constexpr std::uint64_t kSecond = 1'000'000'000;  // ns

std::uint64_t nanoseconds(double seconds) { return static_cast<std::uint64_t>(std::llround(seconds * 1e9)); }

Json time_of(std::uint64_t time) { return {{"sec", time / kSecond}, {"nsec", time % kSecond}}; }
Json message_of(Vec3 v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }
Json message_of(Quat q) { return {{"x", q.x}, {"y", q.y}, {"z", q.z}, {"w", q.w}}; }
Json message_of(const Pose& pose) {
  return {{"position", message_of(pose.position)}, {"orientation", message_of(pose.rotation)}};
}

std::string frame_of(const Actor& actor) {
  return "body_" + std::to_string(actor.body.index) + "_" + std::to_string(actor.body.generation);
}

// Colors of messages are those of files, not light.
Json color_of(const Actor& actor) {
  const render::Color light = actor.type == BodyType::fixed
                                  ? render::color_of(168, 170, 172)
                                  : render::palette_color(actor.body.index % render::kPaletteSize);
  return {{"r", std::sqrt(light.x)}, {"g", std::sqrt(light.y)}, {"b", std::sqrt(light.z)}, {"a", 1.0}};
}

Json triangles_of(const ActorShape& shape, const Json& color) {
  const ShapeMesh mesh = mesh_of(shape.geometry);
  Json points = Json::array();
  for (const Vec3& position : mesh.positions) points.push_back(message_of(position));
  return {{"pose", message_of(shape.pose)},
          {"points", points},
          {"color", color},
          {"colors", Json::array()},
          {"indices", mesh.indices}};
}

Json entity_of(const Actor& actor, std::uint64_t time) {
  Json entity = {{"timestamp", time_of(time)},
                 {"frame_id", frame_of(actor)},
                 {"id", frame_of(actor)},
                 {"lifetime", time_of(0)},
                 {"frame_locked", true}};
  for (const char* name :
       {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"})
    entity[name] = Json::array();
  const Json color = color_of(actor);
  for (const ActorShape& shape : actor.shapes) {
    Json primitive = {{"pose", message_of(shape.pose)}, {"color", color}};
    if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
      const float size = 2.0f * sphere->radius;
      primitive["size"] = message_of(Vec3{size, size, size});
      entity["spheres"].push_back(primitive);
    } else if (const auto* box = std::get_if<Box>(&shape.geometry); box != nullptr && box->rounding == 0.0f) {
      primitive["size"] = message_of(2.0f * box->half_extents);
      entity["cubes"].push_back(primitive);
    } else {
      entity["triangles"].push_back(triangles_of(shape, color));
    }
  }
  return entity;
}

bool lives(const Actor& actor, std::size_t sample) {
  return sample >= actor.first && sample < actor.first + actor.poses.size();
}

// All that live. A viewer that jumps into the middle looks at the latest message alone.
std::string scene_at(const Show& show, std::size_t sample, std::uint64_t time) {
  constexpr int kAll = 1;  // of the types of deletions
  Json deletions = {{{"timestamp", time_of(time)}, {"type", kAll}, {"id", ""}}};
  if (sample == 0) deletions = Json::array();
  Json entities = Json::array();
  for (const Actor& actor : show.actors) {
    if (lives(actor, sample) && !actor.shapes.empty()) entities.push_back(entity_of(actor, time));
  }
  return Json{{"deletions", deletions}, {"entities", entities}}.dump();
}

// Written by hand: there are as many of these as poses.
class Transforms {
 public:
  explicit Transforms(std::uint64_t time)
      : stamp_("\"timestamp\":{\"sec\":" + std::to_string(time / kSecond) +
               ",\"nsec\":" + std::to_string(time % kSecond) + "}") {}

  void add(const std::string& parent, const std::string& child, const Pose& pose) {
    text_ += text_.empty() ? "{\"transforms\":[{" : ",{";
    text_ += stamp_ + ",\"parent_frame_id\":\"" + parent + "\",\"child_frame_id\":\"" + child +
             "\",\"translation\":";
    put({{'x', pose.position.x}, {'y', pose.position.y}, {'z', pose.position.z}});
    text_ += ",\"rotation\":";
    put({{'x', pose.rotation.x}, {'y', pose.rotation.y}, {'z', pose.rotation.z}, {'w', pose.rotation.w}});
    text_ += "}";
  }
  std::string finish() { return std::move(text_) + "]}"; }

 private:
  void put(std::initializer_list<std::pair<char, float>> members) {
    char separator = '{';
    for (const auto& [name, number] : members) {
      text_ += {separator, '"', name, '"', ':'};
      char digits[40];
      text_.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
      separator = ',';
    }
    text_ += '}';
  }

  std::string stamp_, text_;
};

std::string transforms_at(const Show& show, std::size_t sample, std::uint64_t time) {
  Transforms transforms(time);
  transforms.add("map", "world", {{}, turn_to(show.up, {0.0f, 0.0f, 1.0f})});
  for (const Actor& actor : show.actors) {
    if (lives(actor, sample)) transforms.add("world", frame_of(actor), actor.poses[sample - actor.first]);
  }
  return transforms.finish();
}

std::string stats_at(const Show& show, std::size_t sample) {
  const StepStats& stats = show.stats[sample];
  std::size_t bodies = 0;
  for (const Actor& actor : show.actors) bodies += lives(actor, sample) ? 1 : 0;
  return Json{{"step", show.steps[sample]},
              {"bodies", bodies},
              {"contacts", stats.contacts},
              {"awake_bodies", stats.awake_bodies},
              {"kinetic_energy", stats.kinetic_energy},
              {"residual", stats.residual}}
      .dump();
}

}  // namespace

std::string to_mcap(const Show& show) {
  McapWriter writer;
  const std::uint16_t scene = writer.add_channel("/scene", "foxglove.SceneUpdate", kSceneSchema);
  const std::uint16_t transforms = writer.add_channel("/tf", "foxglove.FrameTransforms", kTransformsSchema);
  const std::uint16_t stats = writer.add_channel("/stats", "scree.Stats", kStatsSchema);
  for (std::size_t sample = 0; sample < show.times.size(); ++sample) {
    const std::uint64_t time = nanoseconds(show.times[sample]);
    bool has_changed = sample == 0;
    for (const Actor& actor : show.actors)
      has_changed = has_changed || actor.first == sample || actor.first + actor.poses.size() == sample;
    writer.add_message(transforms, time, transforms_at(show, sample, time));
    if (has_changed) writer.add_message(scene, time, scene_at(show, sample, time));
    writer.add_message(stats, time, stats_at(show, sample));
  }
  return writer.finish();
}

}  // namespace scree::exports
