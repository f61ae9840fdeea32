// Laws of pages: what a page carries is the recording within 16 bits, and all that it takes is inside.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/recording/recording_fixture.h>
#include <tools/export/show.h>
#include <tools/view/clip.h>
#include <tools/view/page.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace scree::view {
namespace {

using exports::Actor;
using exports::Show;
using test::kDt;
using test::TemporaryFile;

Show heap_show() {
  TemporaryFile file;
  test::Heap heap;
  {
    Recorder recorder(heap.world, file.path());
    for (int i = 0; i < 50; ++i) {
      if (i == 20) heap.world.destroy_body(heap.bodies.back());
      if (i == 30) heap.world.add_shape(heap.world.create_body({.position = {0.0f, 9.0f, 0.0f}}), Capsule{});
      step(heap.world, kDt, heap.workers);
    }
    recorder.finish();
  }
  Player player(file.path());
  Workers workers(1);
  return exports::play(player, 0, 50, 1, workers, [](std::uint64_t, std::uint64_t) {});
}

std::string unpack(const std::string& packed) {
  constexpr int kGzip = 15 + 16;
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, kGzip), Z_OK);
  std::string bytes(64 << 20, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  bytes.resize(stream.total_out);
  inflateEnd(&stream);
  return bytes;
}

struct Clip {
  nlohmann::json head;
  std::string numbers;
};

Clip read_clip(const Show& show) {
  const std::string bytes = unpack(make_clip(show, "heap"));
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof length);
  return {nlohmann::json::parse(bytes.substr(4, length)), bytes.substr(4 + length)};
}

// A track's components, in parts.
struct Codes {
  std::vector<std::uint64_t> parts[7];
  double most = 0.0;  // of positions
};

Codes read_codes(const Clip& clip, const nlohmann::json& track, std::size_t count) {
  Codes codes;
  std::size_t plane = track.at("offset");
  codes.most = std::ldexp(1.0, 8 * track.at("bytes").get<int>()) - 1.0;
  for (std::size_t part = 0; part < 7; ++part) {
    const std::size_t bytes = part < 3 ? track.at("bytes").get<std::size_t>() : 2;
    const std::uint64_t mask = (std::uint64_t{1} << 8 * bytes) - 1;
    std::uint64_t code = 0;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < bytes; ++k)
        code += std::uint64_t{static_cast<std::uint8_t>(clip.numbers.at(plane + k * count + i))} << 8 * k;
      codes.parts[part].push_back(code &= mask);
    }
    plane += bytes * count;
  }
  return codes;
}

// The largest distance between a body's poses and what the clip has of them, m; and of rotations, 1 - |q .
// q'|.
struct Errors {
  double distance = 0.0, turn = 0.0;
};

Errors errors_of(const Clip& clip, const nlohmann::json& track, const Actor& actor) {
  const Codes codes = read_codes(clip, track, actor.poses.size());
  Errors errors;
  for (std::size_t sample = 0; sample < actor.poses.size(); ++sample) {
    const Pose& pose = actor.poses[sample];
    for (int axis = 0; axis < 3; ++axis) {
      const auto part = static_cast<std::size_t>(axis);
      const double lower = track.at("lower").at(part), upper = track.at("upper").at(part);
      const double place =
          lower + (upper - lower) * static_cast<double>(codes.parts[part][sample]) / codes.most;
      errors.distance = std::max(errors.distance, std::abs(place - double{pose.position[axis]}));
    }
    const auto at = [&](std::size_t part) {
      return static_cast<float>(static_cast<std::int16_t>(codes.parts[part][sample])) / 32767.0f;
    };
    const Quat rotation{at(3), at(4), at(5), at(6)};
    errors.turn = std::max(errors.turn, double{std::abs(std::abs(dot(rotation, pose.rotation)) - 1.0f)});
  }
  return errors;
}

TEST(Clip, HoldsThePosesWithinAFiveHundredthOfTheBody) {
  const Show show = heap_show();
  const Clip clip = read_clip(show);
  ASSERT_EQ(clip.head.at("bodies").size(), show.actors.size());
  std::size_t tracks = 0;
  for (std::size_t i = 0; i < show.actors.size(); ++i) {
    const Actor& actor = show.actors[i];
    const nlohmann::json& body = clip.head.at("bodies").at(i);
    EXPECT_EQ(body.at("index"), actor.body.index);
    EXPECT_EQ(body.at("first"), actor.first);
    ASSERT_EQ(body.at("count"), actor.poses.size());
    EXPECT_EQ(body.at("shape_count"), actor.shapes.size());
    EXPECT_GE(body.at("shapes").size(), actor.shapes.size());  // a capsule is three
    ASSERT_EQ(body.contains("track"), !exports::stands_still(actor));
    if (!body.contains("track")) continue;
    ++tracks;
    const Errors errors = errors_of(clip, body.at("track"), actor);
    EXPECT_LE(errors.distance, 0.5 / 500.0);  // bodies are smaller than 0.5 m from their middles
    EXPECT_LE(errors.turn, 1e-4);
  }
  EXPECT_GT(tracks, 10u);
}

TEST(Clip, KeepsBodiesThatGoFarAsExactAsOthers) {
  for (const float far : {50.0f, 5e3f, 1e6f}) {
    TemporaryFile file;
    World world;
    const BodyId body = world.create_body({});
    world.add_shape(body, Sphere{0.1f});
    Workers workers(1);
    {
      Recorder recorder(world, file.path());
      for (int i = 0; i < 60; ++i) {
        if (i == 50) world.set_pose(body, {{far, -far, 0.0f}, {}});
        step(world, kDt, workers);
      }
      recorder.finish();
    }
    Player player(file.path());
    const Show show = exports::play(player, 0, 60, 1, workers, [](std::uint64_t, std::uint64_t) {});
    const Clip clip = read_clip(show);
    const Errors errors = errors_of(clip, clip.head.at("bodies").at(0).at("track"), show.actors.at(0));
    // Single precision itself has parts of 0.06 m at 1e6 m.
    EXPECT_LE(errors.distance, std::max(0.1 / 500.0, double{far} * 1e-7)) << far;
  }
}

TEST(Clip, HasFewMeshesForManyCapsules) {
  TemporaryFile file;
  World world;
  for (int i = 1; i <= 50; ++i) {
    const BodyId body = world.create_body({.position = {static_cast<float>(i), 0.0f, 0.0f}});
    world.add_shape(body, Capsule{0.01f * static_cast<float>(i), 0.2f}, {},
                    {.local_pose = {{0.0f, 0.1f, 0.0f}, {}}});
  }
  Workers workers(1);
  {
    Recorder recorder(world, file.path());
    step(world, kDt, workers);
    recorder.finish();
  }
  Player player(file.path());
  const Clip clip = read_clip(exports::play(player, 0, 1, 1, workers, [](std::uint64_t, std::uint64_t) {}));
  EXPECT_EQ(clip.head.at("meshes").size(), 2u);
  const nlohmann::json& shapes = clip.head.at("bodies").at(9).at("shapes");
  ASSERT_EQ(shapes.size(), 3u);  // two half balls and a tube
  EXPECT_NEAR(shapes.at(0).at(2).get<double>(), 0.1 + 0.1, 1e-6);
  EXPECT_NEAR(shapes.at(1).at(2).get<double>(), 0.1 - 0.1, 1e-6);
  EXPECT_NEAR(shapes.at(2).at(9).get<double>(), 0.1, 1e-6);
}

TEST(Clip, HoldsTheMeshesOfTheShapes) {
  const Clip clip = read_clip(heap_show());
  for (const nlohmann::json& mesh : clip.head.at("meshes")) {
    const std::size_t vertices = mesh.at("vertices"), corners = mesh.at("corners"), at = mesh.at("indices");
    EXPECT_EQ(at % 4, 0u);
    EXPECT_EQ(mesh.at("positions").get<std::size_t>() % 4, 0u);
    ASSERT_LE(at + 4 * corners, clip.numbers.size());
    std::vector<std::uint32_t> indices(corners);
    std::memcpy(indices.data(), clip.numbers.data() + at, 4 * corners);
    for (const std::uint32_t index : indices) EXPECT_LT(index, vertices);
  }
  for (const nlohmann::json& body : clip.head.at("bodies")) {
    for (const nlohmann::json& shape : body.at("shapes")) {
      ASSERT_EQ(shape.size(), 11u);
      EXPECT_LT(shape.at(0).get<std::size_t>(), clip.head.at("meshes").size());
    }
  }
  const std::size_t samples = clip.head.at("times").size();
  EXPECT_EQ(samples, 51u);
  for (const char* name : {"bodies", "awake", "contacts", "energy"})
    EXPECT_EQ(clip.head.at("stats").at(name).size(), samples);
  EXPECT_TRUE(clip.head.at("stats").at("contacts").at(0).is_null());  // no step was played
  EXPECT_TRUE(clip.head.at("stats").at("contacts").at(1).is_number());
  EXPECT_EQ(clip.head.at("stats").at("bodies").at(25).get<int>(),
            clip.head.at("stats").at("bodies").at(0).get<int>() - 1);
}

TEST(Clip, OfAWorldOfNothingIsRead) {
  TemporaryFile file;
  World world;
  Workers workers(1);
  {
    Recorder recorder(world, file.path());
    recorder.finish();
  }
  Player player(file.path());
  const Clip clip = read_clip(exports::play(player, 0, 0, 1, workers, [](std::uint64_t, std::uint64_t) {}));
  EXPECT_TRUE(clip.head.at("bodies").empty());
  EXPECT_EQ(clip.head.at("times").size(), 1u);
}

TEST(Page, HasAllThatItTakesInside) {
  const Show show = heap_show();
  if (!has_page()) {
    EXPECT_THROW(make_page(show, "heap"), Error);
    GTEST_SKIP() << kNoPage;
  }
  const std::string page = make_page(show, "<b>heap & co</b>");
  EXPECT_NE(make_page(show, "@CLIP@@TITLE@").find("<title>@CLIP@@TITLE@</title>"), std::string::npos);
  EXPECT_EQ(page.find("<b>heap"), std::string::npos);
  EXPECT_NE(page.find("<title>&lt;b&gt;heap &amp; co&lt;/b&gt;</title>"), std::string::npos);
  EXPECT_EQ(page.find("http:"), std::string::npos);
  EXPECT_EQ(page.find("https:"), std::string::npos);
  EXPECT_EQ(page.find("src="), std::string::npos);
  for (const char* mark : {"@TITLE@", "@STYLE@", "@IMPORTS@", "@CLIP@"})
    EXPECT_EQ(page.find(mark), std::string::npos);
  const std::size_t begin = page.find("{\"imports\""), end = page.find("</script>", begin);
  const nlohmann::json imports = nlohmann::json::parse(page.substr(begin, end - begin)).at("imports");
  for (const char* name :
       {"three", "scree/main", "scree/clip", "scree/scene", "scree/orbit", "scree/plot", "scree/walls"})
    EXPECT_TRUE(imports.at(name).get<std::string>().starts_with("data:text/javascript;base64,")) << name;
}

}  // namespace
}  // namespace scree::view
