// Laws of exported recordings: other programs read them, and find each body where the recording has it.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/recording/recording_fixture.h>
#include <tools/export/gltf.h>
#include <tools/export/mcap_show.h>
#include <tools/export/show.h>
#include <zstd.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace scree::exports {
namespace {

using test::kDt;
using test::TemporaryFile;

// Some bodies of all shapes; one leaves after 12 steps, and another arrives after 20, of 40.
struct Recorded {
  TemporaryFile file;
  BodyId leaves, arrives;

  Recorded() {
    test::Heap heap;
    const BodyId floor = heap.world.create_body({.type = BodyType::fixed, .position = {0.0f, -3.0f, 0.0f}});
    heap.world.add_shape(floor, HalfSpace{});
    leaves = heap.bodies.back();
    Recorder recorder(heap.world, file.path(), {.keyframe_spacing = 15});
    for (int i = 0; i < 40; ++i) {
      if (i == 12) heap.world.destroy_body(leaves);
      if (i == 20) {
        arrives = heap.world.create_body({.position = {0.0f, 9.0f, 0.0f}});
        heap.world.add_shape(arrives, Capsule{});
      }
      step(heap.world, kDt, heap.workers);
    }
    recorder.finish();
  }
  Show show(std::uint64_t from, std::uint64_t to, std::uint64_t every) const {
    Player player(file.path());
    Workers workers(1);
    return play(player, from, to, every, workers, [](std::uint64_t, std::uint64_t) {});
  }
};

TEST(Show, HasEachBodyWhileItLives) {
  const Recorded recorded;
  const Show show = recorded.show(0, 40, 2);
  ASSERT_EQ(show.times.size(), 21u);
  EXPECT_NEAR(show.times.back(), 40.0 * double{kDt}, 1e-6);
  Player player(recorded.file.path());
  Workers workers(1);
  for (std::size_t sample = 0; sample < show.times.size(); ++sample) {
    player.seek(2 * sample, workers);
    std::size_t living = 0;
    for (const Actor& actor : show.actors) {
      const bool lives = sample >= actor.first && sample < actor.first + actor.poses.size();
      ASSERT_EQ(player.world().is_alive(player.world().body_at(actor.body.index)) &&
                    player.world().body_at(actor.body.index).generation == actor.body.generation,
                lives);
      if (!lives) continue;
      ++living;
      EXPECT_EQ(actor.poses[sample - actor.first],
                player.world().pose(player.world().body_at(actor.body.index)));
    }
    EXPECT_EQ(living, player.world().body_count());
  }
}

TEST(Show, ABodyThatComesBackIsAnotherActor) {
  TemporaryFile file;
  World world({.gravity = {}});
  const BodyId body = world.create_body({.position = {1.0f, 0.0f, 0.0f}});
  world.add_shape(body, Sphere{});
  Workers workers(1);
  {
    Recorder recorder(world, file.path());
    Snapshot before;
    save(world, before);
    for (int i = 0; i < 30; ++i) {
      if (i == 10) world.destroy_body(body);
      if (i == 20) restore(world, before);
      step(world, kDt, workers);
    }
    recorder.finish();
  }
  Player player(file.path());
  const Show show = play(player, 0, 30, 1, workers, [](std::uint64_t, std::uint64_t) {});
  ASSERT_EQ(show.actors.size(), 2u);
  EXPECT_EQ(show.actors[0].poses.size(), 11u);
  EXPECT_EQ(show.actors[1].first, 21u);
  EXPECT_EQ(show.actors[1].poses.size(), 10u);
}

// By name, where a node is and how large.
aiMatrix4x4 place_of(const aiNode& node) {
  aiMatrix4x4 place = node.mTransformation;
  for (const aiNode* parent = node.mParent; parent != nullptr; parent = parent->mParent)
    place = parent->mTransformation * place;
  return place;
}

TEST(Gltf, IsReadByAssimpWithTheSamePosesShapesAndTimes) {
  const Recorded recorded;
  const Show show = recorded.show(0, 40, 1);
  for (const bool binary : {false, true}) {
    const std::string bytes = binary ? to_glb(show) : to_gltf(show);
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFileFromMemory(
        bytes.data(), bytes.size(), aiProcess_ValidateDataStructure, binary ? "glb" : "gltf");
    ASSERT_NE(scene, nullptr) << importer.GetErrorString();
    ASSERT_EQ(scene->mNumAnimations, 1u);
    const aiAnimation& animation = *scene->mAnimations[0];
    const double per_second = animation.mTicksPerSecond;
    EXPECT_NEAR(animation.mDuration / per_second, show.times.back(), 1e-3);
    std::map<std::string, const aiNodeAnim*> moves;
    for (unsigned i = 0; i < animation.mNumChannels; ++i)
      moves[animation.mChannels[i]->mNodeName.C_Str()] = animation.mChannels[i];
    std::size_t moving = 0;
    std::set<std::uint32_t> shared;  // indices that two bodies had after one another
    for (const Actor& actor : show.actors) {
      for (const Actor& other : show.actors) {
        if (&other != &actor && other.body.index == actor.body.index) shared.insert(actor.body.index);
      }
    }
    for (const Actor& actor : show.actors) {
      if (shared.count(actor.body.index) != 0) continue;
      const std::string name = "body " + std::to_string(actor.body.index);
      const aiNode* node = scene->mRootNode->FindNode(name.c_str());
      ASSERT_NE(node, nullptr) << name;
      EXPECT_EQ(node->mNumChildren, actor.shapes.size());
      if (stands_still(actor)) {
        EXPECT_NEAR(place_of(*node).b4, actor.poses.front().position.y, 1e-5f);
        continue;
      }
      ++moving;
      ASSERT_TRUE(moves.count(name) != 0);
      const aiNodeAnim& move = *moves[name];
      ASSERT_EQ(move.mNumPositionKeys, actor.poses.size());
      ASSERT_EQ(move.mNumRotationKeys, actor.poses.size());
      for (std::size_t i = 0; i < actor.poses.size(); ++i) {
        const Pose& pose = actor.poses[i];
        EXPECT_NEAR(move.mPositionKeys[i].mTime / per_second, show.times[actor.first + i], 1e-4);
        EXPECT_EQ(move.mPositionKeys[i].mValue.y, pose.position.y);
        const aiQuaternion q = move.mRotationKeys[i].mValue;
        EXPECT_NEAR(std::abs(dot(Quat{q.x, q.y, q.z, q.w}, pose.rotation)), 1.0f, 1e-5f);
      }
    }
    EXPECT_GT(moving, 8u);
    // All boxes share a mesh, once a color.
    EXPECT_LT(scene->mNumMeshes, 3 * show.actors.size());
  }
}

TEST(Gltf, BodiesThatAreNotThereHaveNoSize) {
  const Recorded recorded;
  const Show show = recorded.show(0, 40, 1);
  const nlohmann::json json = nlohmann::json::parse(to_gltf(show));
  std::size_t hidden = 0;
  for (const nlohmann::json& channel : json.at("animations").at(0).at("channels")) {
    if (channel.at("target").at("path") != "scale") continue;
    ++hidden;
    const nlohmann::json& sampler =
        json.at("animations").at(0).at("samplers").at(channel.at("sampler").get<std::size_t>());
    EXPECT_EQ(sampler.at("interpolation"), "STEP");
    const nlohmann::json& times = json.at("accessors").at(sampler.at("input").get<std::size_t>());
    EXPECT_EQ(times.at("count"), 2);
  }
  EXPECT_EQ(hidden, 2u);
}

TEST(Gltf, OfNothingThatMovesIsAScene) {
  TemporaryFile file;
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed}), Box{});
  Workers workers(1);
  {
    Recorder recorder(world, file.path());
    step(world, 0.0f, workers);
    step(world, kDt, workers);
    recorder.finish();
  }
  Player player(file.path());
  const Show show = play(player, 0, 2, 1, workers, [](std::uint64_t, std::uint64_t) {});
  EXPECT_EQ(show.times.size(), 2u);  // a step of no length is not seen
  const nlohmann::json json = nlohmann::json::parse(to_gltf(show));
  EXPECT_FALSE(json.contains("animations"));
  EXPECT_EQ(json.at("meshes").size(), 1u);
}

TEST(Gltf, PointsUpWhereGravityPointsDown) {
  for (const Vec3 up : {Vec3{0.0f, 1.0f, 0.0f}, Vec3{0.0f, 0.0f, 1.0f}, Vec3{0.0f, -1.0f, 0.0f},
                        Vec3{1.0f, 0.0f, 0.0f}, normalize(Vec3{1.0f, 2.0f, -3.0f})}) {
    for (const Vec3 to : {Vec3{0.0f, 1.0f, 0.0f}, Vec3{0.0f, 0.0f, 1.0f}}) {
      const Vec3 turned = rotate(turn_to(up, to), up);
      EXPECT_LT(distance(turned, to), 1e-5f);
    }
  }
}

// Takes an MCAP file apart by its specification.
struct Reader {
  std::string_view bytes;
  std::size_t at = 0;

  template <class Number>
  Number take() {
    Number number{};
    if (at + sizeof number > bytes.size()) throw std::runtime_error("cut off");
    std::memcpy(&number, bytes.data() + at, sizeof number);
    at += sizeof number;
    return number;
  }
  std::string_view take(std::size_t size) {
    if (at + size > bytes.size()) throw std::runtime_error("cut off");
    at += size;
    return bytes.substr(at - size, size);
  }
  std::string_view text() { return take(take<std::uint32_t>()); }
  bool ends() const { return at == bytes.size(); }
};

struct Message {
  std::uint16_t channel;
  std::uint64_t time;
  nlohmann::json json;
};

struct Contents {
  std::vector<std::uint8_t> opcodes;  // in order
  std::map<std::uint16_t, std::string> topics, schemas;
  std::vector<Message> messages;
};

void read_message(std::string_view content, Contents& contents) {
  Reader message{content};
  const auto channel = message.take<std::uint16_t>();
  message.take<std::uint32_t>();
  const auto time = message.take<std::uint64_t>();
  EXPECT_EQ(message.take<std::uint64_t>(), time);
  contents.messages.push_back(
      {channel, time, nlohmann::json::parse(message.take(content.size() - message.at))});
}

void read_chunk(std::string_view content, Contents& contents) {
  Reader chunk{content};
  const auto start = chunk.take<std::uint64_t>(), end = chunk.take<std::uint64_t>(),
             size = chunk.take<std::uint64_t>();
  chunk.take<std::uint32_t>();
  EXPECT_EQ(chunk.text(), "zstd");
  const std::string_view stored = chunk.take(chunk.take<std::uint64_t>());
  EXPECT_TRUE(chunk.ends());
  std::string records(size, '\0');
  ASSERT_EQ(ZSTD_decompress(records.data(), size, stored.data(), stored.size()), size);
  for (Reader reader{records}; !reader.ends();) {
    ASSERT_EQ(reader.take<std::uint8_t>(), 5);
    read_message(reader.take(reader.take<std::uint64_t>()), contents);
    EXPECT_GE(contents.messages.back().time, start);
    EXPECT_LE(contents.messages.back().time, end);
  }
}

Contents read_mcap(std::string_view bytes) {
  constexpr std::string_view kMagic = "\x89MCAP0\r\n";
  Contents contents;
  EXPECT_TRUE(bytes.starts_with(kMagic) && bytes.ends_with(kMagic));
  Reader file{bytes.substr(0, bytes.size() - kMagic.size()), kMagic.size()};
  while (!file.ends()) {
    const auto opcode = file.take<std::uint8_t>();
    const std::string_view content = file.take(file.take<std::uint64_t>());
    contents.opcodes.push_back(opcode);
    Reader record{content};
    if (opcode == 3) {
      const auto id = record.take<std::uint16_t>();
      contents.schemas[id] = record.text();
      EXPECT_EQ(record.text(), "jsonschema");
      EXPECT_TRUE(nlohmann::json::parse(record.text()).is_object());
    } else if (opcode == 4) {
      const auto id = record.take<std::uint16_t>();
      EXPECT_TRUE(contents.schemas.count(record.take<std::uint16_t>()) != 0);
      contents.topics[id] = record.text();
      EXPECT_EQ(record.text(), "json");
    } else if (opcode == 6) {
      read_chunk(content, contents);
    } else if (opcode == 8) {  // points at chunks and their indices
      record.at = 16;
      const auto offset = record.take<std::uint64_t>();
      EXPECT_EQ(bytes[offset], 6);
      record.take<std::uint64_t>();  // the chunk's length
      Reader index{record.take(record.take<std::uint32_t>())};
      while (!index.ends()) {
        const auto channel = index.take<std::uint16_t>();
        Reader at{bytes, index.take<std::uint64_t>()};
        EXPECT_EQ(at.take<std::uint8_t>(), 7);
        at.take<std::uint64_t>();
        EXPECT_EQ(at.take<std::uint16_t>(), channel);
      }
    } else if (opcode == 11) {
      EXPECT_EQ(record.take<std::uint64_t>(), contents.messages.size());
    } else if (opcode == 14) {
      const auto group = record.take<std::uint8_t>();
      EXPECT_EQ(static_cast<std::uint8_t>(bytes[record.take<std::uint64_t>()]), group);
    } else if (opcode == 2) {
      EXPECT_EQ(bytes[record.take<std::uint64_t>()], 3);  // the summary begins with schemas
      EXPECT_EQ(bytes[record.take<std::uint64_t>()], 14);
    }
  }
  return contents;
}

TEST(Mcap, HoldsTheSceneTheTransformsAndTheFigures) {
  const Recorded recorded;
  const Show show = recorded.show(0, 40, 1);
  const Contents contents = read_mcap(to_mcap(show));
  EXPECT_EQ(contents.opcodes.front(), 1);
  EXPECT_EQ(contents.opcodes.back(), 2);
  std::map<std::string, std::vector<const Message*>> by_topic;
  for (const Message& message : contents.messages)
    by_topic[contents.topics.at(message.channel)].push_back(&message);
  ASSERT_EQ(by_topic["/tf"].size(), show.times.size());
  ASSERT_EQ(by_topic["/stats"].size(), show.times.size());
  ASSERT_EQ(by_topic["/scene"].size(), 3u);  // at first, as one leaves and as one arrives
  for (std::size_t sample = 0; sample < show.times.size(); ++sample) {
    const Message& message = *by_topic["/tf"][sample];
    EXPECT_NEAR(static_cast<double>(message.time), 1e9 * show.times[sample], 1.0);
    std::map<std::string, nlohmann::json> transforms;
    for (const nlohmann::json& transform : message.json.at("transforms"))
      transforms[transform.at("child_frame_id").get<std::string>()] = transform;
    for (const Actor& actor : show.actors) {
      if (sample < actor.first || sample >= actor.first + actor.poses.size()) continue;
      const Pose& pose = actor.poses[sample - actor.first];
      const nlohmann::json& transform = transforms.at("body_" + std::to_string(actor.body.index) + "_" +
                                                      std::to_string(actor.body.generation));
      EXPECT_EQ(transform.at("parent_frame_id"), "world");
      EXPECT_EQ(transform.at("translation").at("y").get<float>(), pose.position.y);
      EXPECT_EQ(transform.at("rotation").at("w").get<float>(), pose.rotation.w);
    }
    EXPECT_EQ(by_topic["/stats"][sample]->json.at("step"), show.steps[sample]);
    EXPECT_EQ(by_topic["/stats"][sample]->json.contains("residual"), sample > 0);
    EXPECT_EQ(by_topic["/stats"][sample]->json.at("bodies"), transforms.size() - 1);
  }
  const nlohmann::json& first = by_topic["/scene"][0]->json;
  EXPECT_EQ(first.at("entities").size(), by_topic["/stats"][0]->json.at("bodies"));
  std::size_t primitives = 0;
  for (const nlohmann::json& entity : first.at("entities"))
    primitives += entity.at("cubes").size() + entity.at("spheres").size() + entity.at("triangles").size();
  EXPECT_GE(primitives, first.at("entities").size());
  const nlohmann::json& second = by_topic["/scene"][1]->json;
  EXPECT_TRUE(second.at("entities").empty());
  EXPECT_EQ(second.at("deletions").size(), 1u);
  EXPECT_EQ(second.at("deletions").at(0).at("id"), "body_" + std::to_string(recorded.leaves.index) + "_" +
                                                       std::to_string(recorded.leaves.generation));
  const nlohmann::json& third = by_topic["/scene"][2]->json;
  EXPECT_TRUE(third.at("deletions").empty());
  EXPECT_EQ(third.at("entities").size(), 1u);
  EXPECT_EQ(third.at("entities").at(0).at("triangles").size(), 1u);
}

TEST(Mcap, TellsTheWholeSceneAgainNowAndThenWhereItChanges) {
  TemporaryFile file;
  World world({.gravity = {}});
  Workers workers(1);
  {
    Recorder recorder(world, file.path());
    BodyId last;
    for (int i = 0; i < 200; ++i) {
      if (i >= 20 && i % 2 == 0) {
        if (last != BodyId{}) world.destroy_body(last);
        last = world.create_body({.position = {static_cast<float>(i), 0.0f, 0.0f}});
        world.add_shape(last, Cone{});
      }
      step(world, kDt, workers);
    }
    recorder.finish();
  }
  Player player(file.path());
  const Show show = play(player, 0, 200, 1, workers, [](std::uint64_t, std::uint64_t) {});
  const Contents contents = read_mcap(to_mcap(show));
  std::set<std::string> living;
  std::size_t whole = 0, messages = 0;
  for (const Message& message : contents.messages) {
    if (contents.topics.at(message.channel) != "/scene") continue;
    ++messages;
    for (const nlohmann::json& deletion : message.json.at("deletions")) {
      if (deletion.at("type") == 1) {
        ++whole;
        living.clear();
      } else {
        EXPECT_EQ(living.erase(deletion.at("id")), 1u);
      }
    }
    for (const nlohmann::json& entity : message.json.at("entities")) living.insert(entity.at("id"));
    EXPECT_LE(living.size(), 1u);
  }
  EXPECT_EQ(living.size(), 1u);
  EXPECT_GE(messages, 90u);
  EXPECT_GE(whole, 3u);
  EXPECT_LE(whole, 4u);
}

TEST(Mcap, OfManyMessagesHasManyChunks) {
  const Recorded recorded;
  Show show = recorded.show(0, 40, 1);
  const Show once = show;
  for (int i = 0; i < 12; ++i) {  // as if it went on and on
    for (Actor& actor : show.actors) {
      if (is_always_there(once, once.actors[static_cast<std::size_t>(&actor - show.actors.data())]))
        actor.poses.insert(actor.poses.end(),
                           once.actors[static_cast<std::size_t>(&actor - show.actors.data())].poses.begin(),
                           once.actors[static_cast<std::size_t>(&actor - show.actors.data())].poses.end());
    }
    for (std::size_t sample = 0; sample < once.times.size(); ++sample) {
      show.times.push_back(show.times.back() + double{kDt});
      show.steps.push_back(show.steps.back() + 1);
      show.stats.push_back(once.stats[sample]);
    }
  }
  const Contents contents = read_mcap(to_mcap(show));
  EXPECT_GT(std::count(contents.opcodes.begin(), contents.opcodes.end(), 6), 1);
}

}  // namespace
}  // namespace scree::exports
