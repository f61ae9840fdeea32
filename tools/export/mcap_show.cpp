// See mcap_show.h.
#include <tools/export/mcap.h>
#include <tools/export/mcap_show.h>
#include <tools/export/shape_mesh.h>
#include <tools/render/coloring.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>
#include <vector>

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
                                  ? render::fixed_color()
                                  : render::palette_color(actor.body.index % render::kPaletteSize);
  return {{"r", std::sqrt(light.x)}, {"g", std::sqrt(light.y)}, {"b", std::sqrt(light.z)}, {"a", 1.0}};
}

// Bodies as entities of the scene, in text. Shapes of triangles are long, and many bodies have the same.
class Entities {
 public:
  std::string text_of(const Actor& actor, std::uint64_t time) {
    Json entity = {{"timestamp", time_of(time)},
                   {"frame_id", frame_of(actor)},
                   {"id", frame_of(actor)},
                   {"lifetime", time_of(0)},
                   {"frame_locked", true}};
    for (const char* name :
         {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "texts", "models"})
      entity[name] = Json::array();
    std::string triangles;
    for (const ActorShape& shape : actor.shapes) {
      Json primitive = {{"pose", message_of(shape.pose)}, {"color", color_of(actor)}};
      if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
        const float size = 2.0f * sphere->radius;
        primitive["size"] = message_of(Vec3{size, size, size});
        entity["spheres"].push_back(primitive);
      } else if (const auto* box = std::get_if<Box>(&shape.geometry);
                 box != nullptr && box->rounding == 0.0f) {
        primitive["size"] = message_of(2.0f * box->half_extents);
        entity["cubes"].push_back(primitive);
      } else {
        primitive["colors"] = Json::array();
        if (!triangles.empty()) triangles += ',';
        triangles += joined(primitive, triangles_of(shape.geometry));
      }
    }
    return joined(entity, "\"triangles\":[" + triangles + "]");
  }

 private:
  // An object with more members.
  static std::string joined(const Json& object, const std::string& members) {
    std::string text = object.dump();
    text.back() = ',';
    return text + members + "}";
  }
  const std::string& triangles_of(const Geometry& geometry) {
    std::string key = exports::key_of(geometry);
    const Vec3 scale = scale_of(geometry);
    for (int axis = 0; axis < 3; ++axis) {
      key += ',';
      key += std::to_string(std::bit_cast<std::uint32_t>(scale[axis]));
    }
    std::string& text = triangles_[key];
    if (!text.empty()) return text;
    const ShapeMesh mesh = mesh_of(geometry);
    Json points = Json::array();
    for (const Vec3& position : mesh.positions) points.push_back(message_of(position));
    text = "\"points\":" + points.dump() + ",\"indices\":" + Json(mesh.indices).dump();
    return text;
  }

  std::map<std::string, std::string> triangles_;
};

bool lives(const Actor& actor, std::size_t sample) {
  return sample >= actor.first && sample < actor.first + actor.poses.size();
}

// What appears and goes. A viewer that jumps into the middle looks at the latest message alone, so now and
// then one has all that live.
class SceneMessages {
 public:
  explicit SceneMessages(const Show& show)
      : show_(show), comes_(show.times.size()), goes_(show.times.size() + 1) {
    for (const Actor& actor : show.actors) {
      if (actor.shapes.empty()) continue;
      comes_[actor.first].push_back(&actor);
      goes_[actor.first + actor.poses.size()].push_back(&actor);
    }
  }
  // Empty where nothing is to be said.
  std::string at(std::size_t sample, std::uint64_t time) {
    constexpr std::size_t kSpacing = 64;  // samples from one whole scene to the next, at least
    constexpr int kById = 0, kAll = 1;    // types of deletions
    has_changed_ = has_changed_ || !comes_[sample].empty() || !goes_[sample].empty();
    if (sample == 0 || (has_changed_ && sample - last_whole_ >= kSpacing)) {
      has_changed_ = false;
      last_whole_ = sample;
      std::vector<const Actor*> living;
      for (const Actor& actor : show_.actors) {
        if (lives(actor, sample) && !actor.shapes.empty()) living.push_back(&actor);
      }
      return text_of({{{"timestamp", time_of(time)}, {"type", kAll}, {"id", ""}}}, living, time);
    }
    if (comes_[sample].empty() && goes_[sample].empty()) return {};
    Json deletions = Json::array();
    for (const Actor* actor : goes_[sample])
      deletions.push_back({{"timestamp", time_of(time)}, {"type", kById}, {"id", frame_of(*actor)}});
    return text_of(deletions, comes_[sample], time);
  }

 private:
  std::string text_of(const Json& deletions, const std::vector<const Actor*>& actors, std::uint64_t time) {
    std::string text = "{\"deletions\":" + deletions.dump() + ",\"entities\":[";
    for (const Actor* actor : actors) {
      if (text.back() != '[') text += ',';
      text += entities_.text_of(*actor, time);
    }
    return text + "]}";
  }

  const Show& show_;
  Entities entities_;
  std::vector<std::vector<const Actor*>> comes_, goes_;  // by sample
  std::size_t last_whole_ = 0;
  bool has_changed_ = false;  // since the last whole scene
};

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
  Json json = {{"step", show.steps[sample]}, {"bodies", bodies}};
  if (sample > 0) {  // no step was played for the first one
    json["contacts"] = stats.contacts;
    json["awake_bodies"] = stats.awake_bodies;
    json["kinetic_energy"] = stats.kinetic_energy;
    json["residual"] = stats.residual;
  }
  return json.dump();
}

}  // namespace

std::string to_mcap(const Show& show) {
  McapWriter writer;
  const std::uint16_t scene = writer.add_channel("/scene", "foxglove.SceneUpdate", kSceneSchema);
  const std::uint16_t transforms = writer.add_channel("/tf", "foxglove.FrameTransforms", kTransformsSchema);
  const std::uint16_t stats = writer.add_channel("/stats", "scree.Stats", kStatsSchema);
  SceneMessages messages(show);
  for (std::size_t sample = 0; sample < show.times.size(); ++sample) {
    const std::uint64_t time = nanoseconds(show.times[sample]);
    writer.add_message(transforms, time, transforms_at(show, sample, time));
    const std::string changes = messages.at(sample, time);
    if (!changes.empty()) writer.add_message(scene, time, changes);
    writer.add_message(stats, time, stats_at(show, sample));
  }
  return writer.finish();
}

}  // namespace scree::exports
