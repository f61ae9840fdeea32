// Laws of scene files: they can state every value, and every mistake is reported with its place and reason.
#include <gtest/gtest.h>
#include <tools/scenes/scene_file.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace scree::scenes {
namespace {

std::string scene_error_of(const std::string& text) {
  try {
    parse_scene(text, "scene.json");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// A document with one body that has this one shape.
std::string with_shape(const std::string& shape) { return R"({"bodies": [{"shapes": [)" + shape + "]}]}"; }
std::string with_body(const std::string& body) { return R"({"bodies": [)" + body + "]}"; }

TEST(SceneFile, SaysEverythingThatASceneHolds) {
  const Scene scene = parse_scene(R"({
    "name": "all of it",
    "gravity": [0, -1.5, 0.25],
    "settings": {"substeps": 8, "contact_hertz": 60, "contact_damping_ratio": 5, "push_speed": 2,
                 "restitution_threshold": 0.5, "max_linear_speed": 100, "max_angular_speed": 50,
                 "warm_start": false, "sleeping": false, "sleep_linear_speed": 0.1, "sleep_angular_speed": 0.2,
                 "sleep_time": 1, "solver": "gauss_seidel",
                 "solver_options": {"iterations": 77, "tolerance": 0.001, "relaxation": 0.5, "baumgarte": 0.75,
                                    "slop": 0.25, "shuffle_seed": 4294967295, "points_together": true}},
    "steps": 30, "dt": 0.01,
    "materials": {"ice": {"friction": 0.02, "restitution": 0.5, "rolling_resistance": 0.1, "patch_radius": 0.25,
                          "density": 900,
                          "surface_velocity": [1, 0, 0], "friction_mix": "minimum", "restitution_mix": "average"}},
    "shapes": {"ball": {"type": "sphere", "radius": 0.3, "material": "ice"}},
    "bodies": [
      {"type": "kinematic", "position": [1, 2, 3], "rotation": [0, 0, 1, 0], "linear_velocity": [4, 5, 6],
       "angular_velocity": [7, 8, 9], "linear_damping": 0.1, "angular_damping": 0.2, "gravity_factor": -1,
       "locks": ["translation_z", "rotation_x"], "mass": 12, "can_sleep": false, "user_data": 77,
       "shapes": ["ball",
                  {"type": "capsule", "half_height": 1, "radius": 0.5, "position": [0, 1, 0],
                   "rotation": {"axis": [0, 0, 2], "degrees": 90},
                   "filter": {"category": 2, "mask": 4294967295, "group": -3}, "user_data": 5, "sensor": true},
                  {"type": "box", "half_extents": [1, 2, 3], "material": {"friction": 1}}]}
    ]
  })",
                                  "scene.json");
  EXPECT_EQ(scene.name, "all of it");
  EXPECT_EQ(scene.settings.gravity, (Vec3{0, -1.5f, 0.25f}));
  EXPECT_EQ(scene.settings.substeps, 8);
  EXPECT_EQ(scene.settings.contact_hertz, 60.0f);
  EXPECT_FALSE(scene.settings.warm_start);
  EXPECT_FALSE(scene.settings.sleeping);
  EXPECT_EQ(scene.settings.sleep_time, 1.0f);
  EXPECT_EQ(scene.settings.solver, Solver::gauss_seidel);
  EXPECT_EQ(scene.settings.solver_options, (SolverOptions{.iterations = 77,
                                                          .tolerance = 0.001f,
                                                          .relaxation = 0.5f,
                                                          .baumgarte = 0.75f,
                                                          .slop = 0.25f,
                                                          .shuffle_seed = 0xffffffffu,
                                                          .points_together = true}));
  EXPECT_EQ(scene.steps, 30);
  EXPECT_EQ(scene.dt, 0.01f);
  ASSERT_EQ(scene.bodies.size(), 1u);
  const BodyDef& def = scene.bodies[0].def;
  EXPECT_EQ(def.type, BodyType::kinematic);
  EXPECT_EQ(def.position, (Vec3{1, 2, 3}));
  EXPECT_EQ(def.rotation, (Quat{0, 0, 1, 0}));
  EXPECT_EQ(def.linear_velocity, (Vec3{4, 5, 6}));
  EXPECT_EQ(def.angular_velocity, (Vec3{7, 8, 9}));
  EXPECT_EQ(def.gravity_factor, -1.0f);
  EXPECT_EQ(def.locks, AxisLocks::translation_z | AxisLocks::rotation_x);
  EXPECT_EQ(def.mass, 12.0f);
  EXPECT_FALSE(def.can_sleep);
  EXPECT_EQ(def.user_data, 77u);
  ASSERT_EQ(scene.bodies[0].shape_count, 3u);
  EXPECT_EQ(std::get<Sphere>(scene.shapes[0].geometry).radius, 0.3f);
  EXPECT_EQ(scene.shapes[0].material.density, 900.0f);
  EXPECT_EQ(scene.shapes[0].material.friction_mix, MixRule::minimum);
  EXPECT_EQ(scene.shapes[0].material.restitution_mix, MixRule::average);
  EXPECT_EQ(std::get<Capsule>(scene.shapes[1].geometry).half_height, 1.0f);
  EXPECT_NEAR(scene.shapes[1].options.local_pose.rotation.z, 0.70710678f, 1e-7f);
  EXPECT_EQ(scene.shapes[1].options.filter.group, -3);
  EXPECT_EQ(scene.shapes[1].options.filter.mask, 0xffffffffu);
  EXPECT_EQ(scene.shapes[1].options.user_data, 5u);
  EXPECT_TRUE(scene.shapes[1].options.sensor);
  EXPECT_FALSE(scene.shapes[0].options.sensor);
  EXPECT_EQ(scene.shapes[2].material.friction, 1.0f);
}

TEST(SceneFile, MayHaveHalfSpacesWhereBodiesMay) {
  const Scene scene =
      parse_scene(with_body(R"({"type": "fixed", "shapes": [{"type": "half_space"}]})"), "a.json");
  ASSERT_EQ(scene.shapes.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<HalfSpace>(scene.shapes[0].geometry));
  EXPECT_EQ(scene_error_of(with_shape(R"({"type": "half_space"})")),
            "scene.json: /bodies/0: World::add_shape: a half-space belongs to fixed and kinematic bodies "
            "only, but the body is dynamic");
}

TEST(SceneFile, MayHaveCylindersConesAndRoundings) {
  const auto shape = [](const std::string& text) {
    return parse_scene(with_shape(text), "a.json").shapes[0];
  };
  const Geometry cylinder = shape(R"({"type": "cylinder", "half_height": 2, "radius": 0.5})").geometry;
  EXPECT_EQ(std::get<Cylinder>(cylinder).half_height, 2.0f);
  EXPECT_EQ(std::get<Cylinder>(cylinder).radius, 0.5f);
  const Geometry cone = shape(R"({"type": "cone", "half_height": 3, "radius": 0.25})").geometry;
  EXPECT_EQ(std::get<Cone>(cone).half_height, 3.0f);
  EXPECT_EQ(std::get<Cone>(cone).radius, 0.25f);
  const Geometry box = shape(R"({"type": "box", "half_extents": [1, 2, 3], "rounding": 0.5})").geometry;
  EXPECT_EQ(std::get<Box>(box).rounding, 0.5f);
  const std::string points = R"({"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]})";
  const Geometry hull = shape(R"({"type": "hull", "rounding": 0.125, "hull": )" + points + "}").geometry;
  EXPECT_EQ(std::get<ConvexHull>(hull).rounding, 0.125f);
  const std::string where = "scene.json: /bodies/0/shapes/0/";
  EXPECT_EQ(scene_error_of(with_shape(R"({"type": "box", "half_extents": [1, 2, 3], "rounding": -1})")),
            where + "rounding: -1 must be from 0 to 100000");
  EXPECT_EQ(scene_error_of(with_shape(R"({"type": "cone", "half_height": 1})")),
            where.substr(0, where.size() - 1) + ": the key \"radius\" is missing");
  EXPECT_EQ(scene_error_of(with_shape(R"({"type": "cylinder", "half_height": 0, "radius": 1})")),
            where + "half_height: 0 must be from 0.0001 to 100000");
}

TEST(SceneFile, MissingKeysTakeTheLibrarysDefaults) {
  const Scene scene = parse_scene(with_shape(R"({"type": "sphere", "radius": 1})"), "dir/tower.json");
  EXPECT_EQ(scene.name, "tower");
  EXPECT_EQ(scene.settings.gravity, WorldSettings{}.gravity);
  EXPECT_EQ(scene.bodies[0].def.position, (Vec3{}));
  EXPECT_EQ(scene.bodies[0].def.type, BodyType::dynamic);
  EXPECT_EQ(scene.shapes[0].material, Material{});
}

TEST(SceneFile, RepeatsFillAGridAndShareTheirShapes) {
  const Scene scene =
      parse_scene(with_body(R"({"position": [1, 0, 0], "shapes": [{"type": "sphere", "radius": 1}],
    "repeat": {"count": [2, 3, 4], "spacing": [10, 20, 30]}})"),
                  "scene.json");
  ASSERT_EQ(scene.bodies.size(), 24u);
  EXPECT_EQ(scene.shapes.size(), 1u);
  EXPECT_EQ(scene.bodies[1].def.position, (Vec3{11, 0, 0}));
  EXPECT_EQ(scene.bodies[2].def.position, (Vec3{1, 20, 0}));
  EXPECT_EQ(scene.bodies[23].def.position, (Vec3{11, 40, 90}));
}

constexpr const char* kTetrahedron = R"("points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])";

TEST(SceneFile, HullsAreSharedByNameAndByContent) {
  const std::string points = kTetrahedron;
  const Scene scene = parse_scene(R"({"hulls": {"rock": {)" + points + R"(}},
    "shapes": {"stone": {"type": "hull", "hull": "rock", "scale": [1, 2, 3]}},
    "bodies": [{"shapes": ["stone", {"type": "hull", "hull": "rock"}, {"type": "hull", "hull": {)" +
                                      points + R"(, "max_vertices": 4}}]}]})",
                                  "scene.json");
  ASSERT_EQ(scene.shapes.size(), 3u);
  const auto hull = [&](std::size_t shape) { return std::get<ConvexHull>(scene.shapes[shape].geometry); };
  EXPECT_EQ(hull(0).scale, (Vec3{1, 2, 3}));
  EXPECT_EQ(hull(1).scale, (Vec3{1, 1, 1}));
  EXPECT_EQ(hull(0).hull, hull(1).hull);
  EXPECT_EQ(hull(1).hull, hull(2).hull);
  EXPECT_EQ(hull(0).hull.vertices().size(), 4u);
}

TEST(SceneFile, MistakesInHullsAreReportedWithTheirPlace) {
  const auto with_hull = [](const std::string& hull) {
    return with_shape(R"({"type": "hull", "hull": )" + hull + "}");
  };
  const std::string tetrahedron = kTetrahedron;
  const std::pair<std::string, std::string> mistakes[] = {
      {with_shape(R"({"type": "hull"})"), "/bodies/0/shapes/0: the key \"hull\" is missing"},
      {with_hull("3"), "/bodies/0/shapes/0/hull: expected the name of a hull or an object"},
      {with_hull(R"("rock")"), "/bodies/0/shapes/0/hull: no hull \"rock\" in /hulls; none is defined"},
      {with_hull(R"({"points": [[0, 0, 0]]})"),
       "/bodies/0/shapes/0/hull: Hull: 1 points, must be in [4, 2147483647]"},
      {with_hull(R"({"points": [[0, 0, 0], [1, 0, 1e6]]})"),
       "/bodies/0/shapes/0/hull/points/1/2: 1000000 must be from -100000 to 100000"},
      {R"({"hulls": {"flat": {"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}}, "bodies": []})",
       "/hulls/flat: Hull: the points lie within a plane: a hull must be at least 0.0001 m thick"},
      {with_hull("{" + tetrahedron + R"(, "max_vertices": 3})"),
       "/bodies/0/shapes/0/hull/max_vertices: 3 must be a whole number from 4 to 256"},
      {with_hull("{" + tetrahedron + R"(}, "scale": [1, 0, 1])"),
       "/bodies/0/shapes/0/scale/1: 0 must be from 1e-09 to 1e+09"},
  };
  for (const auto& [text, message] : mistakes)
    EXPECT_EQ(scene_error_of(text), "scene.json: " + message) << text;
  const std::string thin = scene_error_of(with_hull("{" + tetrahedron + R"(}, "scale": [1, 1e-5, 1])"));
  EXPECT_EQ(thin.rfind("scene.json: /bodies/0: World::add_shape: the scaled hull: ", 0), 0u) << thin;
}

TEST(SceneFile, SyntaxErrorsCarryLineAndColumn) {
  EXPECT_EQ(scene_error_of("{\n  \"bodies\": [}\n").rfind("scene.json:2:14: not JSON: ", 0), 0u)
      << scene_error_of("{\n  \"bodies\": [}\n");
  EXPECT_EQ(scene_error_of("").rfind("scene.json:1:1: not JSON: ", 0), 0u) << scene_error_of("");
  EXPECT_EQ(scene_error_of("{\"bodies\": []} x").rfind("scene.json:1:16: not JSON: ", 0), 0u);
}

TEST(SceneFile, EveryMistakeIsReportedWithItsPlaceAndReason) {
  const std::string ball = R"({"type": "sphere", "radius": 1)";
  const std::pair<std::string, std::string> mistakes[] = {
      {"[]", "scene.json: the document: expected an object, found an array"},
      {"{}", "scene.json: the document: the key \"bodies\" is missing"},
      {R"({"bodies": [], "bodys": 1})",
       "scene.json: /bodys: unknown key; known here: name, gravity, settings, steps, dt, materials, hulls, "
       "shapes, "
       "bodies, joints"},
      {R"({"bodies": 3})", "scene.json: /bodies: expected an array, found a number"},
      {R"({"bodies": [], "bodies": []})", "scene.json: /bodies: the key stands twice in its object"},
      {R"({"bodies": [], "dt": 2})", "scene.json: /dt: 2 must be from 0 to 1"},
      {R"({"bodies": [], "steps": 0})", "scene.json: /steps: 0 must be a whole number from 1 to 1000000000"},
      {R"({"bodies": [], "steps": 1.5})",
       "scene.json: /steps: 1.5 must be a whole number from 1 to 1000000000"},
      {R"({"bodies": [], "gravity": [0, 1]})",
       "scene.json: /gravity: expected an array of 3 numbers, found 2"},
      {R"({"bodies": [], "settings": {"substeps": 100}})",
       "scene.json: /settings/substeps: 100 must be a whole number from 1 to 64"},
      {R"({"bodies": [], "materials": {"a/b~c": {"friction": -1}}})",
       "scene.json: /materials/a~1b~0c/friction: -1 must be from 0 to 1000000"},
      {R"({"bodies": [], "materials": {"a": {"friction_mix": "sum"}}})",
       "scene.json: /materials/a/friction_mix: \"sum\" is none of: minimum, average, product, "
       "geometric_mean, "
       "maximum"},
      {with_body(R"({"position": "here"})"),
       "scene.json: /bodies/0/position: expected an array of 3 numbers, found a string"},
      {with_body(R"({"position": [0, true, 0]})"),
       "scene.json: /bodies/0/position/1: expected a number, found a boolean"},
      {with_body(R"({"position": [0, 1e8, 0]})"),
       "scene.json: /bodies/0/position/1: 100000000 must be from -10000000 to 10000000"},
      {with_body(R"({"mass": 0})"), "scene.json: /bodies/0/mass: 0 must be from 1e-20 to 1e+30"},
      {with_body(R"({"rotation": [0, 0, 0, 2]})"),
       "scene.json: /bodies/0/rotation: a quaternion must have length 1 within 0.001"},
      {with_body(R"({"rotation": {"axis": [0, 0, 0], "degrees": 1}})"),
       "scene.json: /bodies/0/rotation/axis: must not be zero"},
      {with_body(R"({"rotation": {"axis": [0, 1, 0]}})"),
       "scene.json: /bodies/0/rotation: the key \"degrees\" is missing"},
      {with_body(R"({"locks": ["translation_w"]})"),
       "scene.json: /bodies/0/locks/0: \"translation_w\" is none of: translation_x, translation_y, "
       "translation_z, rotation_x, rotation_y, rotation_z"},
      {with_body(R"({"repeat": {"count": [1, 0, 1], "spacing": [1, 1, 1]}})"),
       "scene.json: /bodies/0/repeat/count/1: 0 must be a whole number from 1 to 10000000"},
      {with_body(R"({"repeat": {"count": [10000, 10000, 10000], "spacing": [1, 1, 1]}})"),
       "scene.json: /bodies/0/repeat/count: more than 10000000 bodies"},
      {with_body(R"({"repeat": {"count": [11, 1, 1], "spacing": [1e6, 1, 1]}, "position": [1, 0, 0]})"),
       "scene.json: /bodies/0: the repeats reach further than 1e7 m from the origin"},
      {with_shape("\"ball\""),
       "scene.json: /bodies/0/shapes/0: no shape \"ball\" in /shapes; none is defined"},
      {with_shape("{}"), "scene.json: /bodies/0/shapes/0: the key \"type\" is missing"},
      {with_shape(R"({"type": "torus"})"),
       "scene.json: /bodies/0/shapes/0/type: \"torus\" is none of: sphere, capsule, box, hull, mesh, "
       "half_space, cylinder, cone"},
      {with_shape(R"({"type": "sphere", "radius": 0})"),
       "scene.json: /bodies/0/shapes/0/radius: 0 must be from 0.0001 to 100000"},
      {with_shape(R"({"type": "sphere", "radius": 1, "half_height": 1})"),
       "scene.json: /bodies/0/shapes/0/half_height: unknown key; known here: type, radius, material, "
       "position, "
       "rotation, filter, user_data, sensor"},
      {with_shape(ball + R"(, "material": "wood"})"),
       "scene.json: /bodies/0/shapes/0/material: no material \"wood\" in /materials; none is defined"},
      {with_shape(ball + R"(, "filter": {"mask": -1}})"),
       "scene.json: /bodies/0/shapes/0/filter/mask: -1 must be a whole number from 0 to 4294967295"},
  };
  for (const auto& [text, error] : mistakes) EXPECT_EQ(scene_error_of(text), error) << text;
}

TEST(SceneFile, LimitsAreTheLibrarysOwnAndReportedWithTheirPlace) {
  const auto setting = [](const std::string& text) {
    return R"({"bodies": [], "settings": {)" + text + "}}";
  };
  const auto material = [](const std::string& text) {
    return R"({"bodies": [], "materials": {"m": {)" + text + "}}}";
  };
  const auto ball = [](const std::string& text) {
    return with_shape(R"({"type": "sphere", "radius": 1, )" + text + "}");
  };
  const std::pair<std::string, std::string> mistakes[] = {
      {material(R"("friction": 1e7)"), "/materials/m/friction: "},
      {material(R"("rolling_resistance": 2e5)"), "/materials/m/rolling_resistance: "},
      {material(R"("patch_radius": -0.1)"), "/materials/m/patch_radius: "},
      {material(R"("density": 2e9)"), "/materials/m/density: "},
      {material(R"("density": 1e-7)"), "/materials/m/density: "},
      {material(R"("surface_velocity": [0, 2e6, 0])"), "/materials/m/surface_velocity/1: "},
      {ball(R"("position": [0, 0, 1e6])"), "/bodies/0/shapes/0/position/2: "},
      {with_body(R"({"linear_velocity": [2e9, 0, 0]})"), "/bodies/0/linear_velocity/0: "},
      {with_body(R"({"angular_velocity": [2e9, 0, 0]})"), "/bodies/0/angular_velocity/0: "},
      {with_body(R"({"linear_damping": 2e6})"), "/bodies/0/linear_damping: "},
      {with_body(R"({"angular_damping": 2e6})"), "/bodies/0/angular_damping: "},
      {with_body(R"({"gravity_factor": -2e6})"), "/bodies/0/gravity_factor: "},
      {with_body(R"({"mass": 1e-25})"), "/bodies/0/mass: "},
      {with_body(R"({"mass": 1e31})"), "/bodies/0/mass: "},
      {setting(R"("contact_hertz": 1e9)"), "/settings/contact_hertz: "},
      {setting(R"("contact_hertz": 1e-4)"), "/settings/contact_hertz: "},
      {setting(R"("contact_damping_ratio": 1e5)"), "/settings/contact_damping_ratio: "},
      {setting(R"("push_speed": 2e6)"), "/settings/push_speed: "},
      {setting(R"("restitution_threshold": 2e6)"), "/settings/restitution_threshold: "},
      {setting(R"("max_linear_speed": 2e6)"), "/settings/max_linear_speed: "},
      {setting(R"("max_angular_speed": 1e-4)"), "/settings/max_angular_speed: "},
      {setting(R"("sleep_linear_speed": 2e6)"), "/settings/sleep_linear_speed: "},
      {setting(R"("sleep_angular_speed": 2e6)"), "/settings/sleep_angular_speed: "},
      {setting(R"("sleep_time": 2e6)"), "/settings/sleep_time: "},
  };
  for (const auto& [text, place] : mistakes) {
    EXPECT_EQ(scene_error_of(text).rfind("scene.json: " + place, 0), 0u) << text << "\n"
                                                                         << scene_error_of(text);
  }
}

TEST(SceneFile, ABodyThatNoWorldTakesIsReportedWithItsPlace) {
  // Each value is allowed, but their total inertia is not.
  const std::string error = scene_error_of(
      with_body(R"({"mass": 1e30, "shapes": [{"type": "box", "half_extents": [1e5, 1e5, 1e5]}]})"));
  EXPECT_EQ(error.rfind("scene.json: /bodies/0: ", 0), 0u) << error;
  EXPECT_NE(error.find("the body's moment of inertia"), std::string::npos) << error;
}

TEST(SceneFile, NumbersOutsideTheRangeOfFloatsAreErrors) {
  EXPECT_EQ(
      scene_error_of(R"({"bodies": [], "gravity": [0, 1e999, 0]})").rfind("scene.json: /gravity/1: ", 0), 0u);
  EXPECT_EQ(scene_error_of("1e999").rfind("scene.json: the document: ", 0), 0u) << scene_error_of("1e999");
  EXPECT_NE(scene_error_of(R"({"bodies": [], "gravity": [0, 1e300, 0]})"), "no error");
  EXPECT_NE(scene_error_of(with_body(R"({"linear_velocity": [1e39, 0, 0]})")), "no error");
}

TEST(SceneFile, MissingFilesDirectoriesAndEmptyFilesAreErrors) {
  EXPECT_THROW(read_scene_file("/no/such/scene.json"), Error);
  EXPECT_THROW(read_scene_file(std::filesystem::temp_directory_path().string()), Error);
}

TEST(SceneFile, TheExamplesAreScenes) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SCREE_EXAMPLES)) {
    const Scene scene = read_scene_file(entry.path().string());
    EXPECT_GT(scene.bodies.size(), 1u) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 2);
}

TEST(SceneFile, WhatTheParserFindsWrongIsReportedWithItsPlaceHoweverDeepItLies) {
  const std::pair<std::string, std::string> mistakes[] = {
      {with_body(R"({}, {"position": [0, 1e999, 0]})"),
       "/bodies/1/position/1: number overflow parsing '1e999'"},
      {with_body(R"({}, {}, {"shapes": [[], {"a": {"b": 1, "c": [], "b": 2}}]})"),
       "/bodies/2/shapes/1/a/b: the key stands twice in its object"},
      {R"({"materials": {"a": {}, "a/b": {}, "a": {}}})", "/materials/a: the key stands twice in its object"},
      {"1e999", "the document: number overflow parsing '1e999'"},
      {"[[1e999]]", "/0/0: number overflow parsing '1e999'"},
  };
  for (const auto& [text, message] : mistakes)
    EXPECT_EQ(scene_error_of(text), "scene.json: " + message) << text;
}

// Reading an entry must not scan all earlier entries: that would take most of an hour here.
TEST(SceneFile, HoldsHundredsOfThousandsOfOneKindAndManyOfEach) {
  constexpr int kMaterials = 400'000, kOthers = 50'000;
  std::ostringstream text;
  const auto list = [&text](const char* begin, int count, const auto& write, const char* end) {
    text << begin;
    for (int i = 0; i < count; ++i) write(text << (i > 0 ? "," : ""), i);
    text << end;
  };
  const auto write_material = [](auto& out, int i) { out << R"("m)" << i << R"(":{"friction":0.5})"; };
  const auto write_shape = [](auto& out, int i) {
    out << R"("s)" << i << R"(":{"type":"sphere","radius":1,"material":"m)" << i << R"("})";
  };
  const auto write_body = [](auto& out, int i) {
    out << R"({"name":"b)" << i << R"(","shapes":["s)" << i << R"("]})";
  };
  const auto write_joint = [](auto& out, int i) { out << R"({"type":"ball","body_a":"b)" << i << R"("})"; };
  list(R"({"materials": {)", kMaterials, write_material, "},");
  list(R"("shapes": {)", kOthers, write_shape, "},");
  list(R"("bodies": [)", kOthers, write_body, "],");
  list(R"("joints": [)", kOthers, write_joint, "]}");
  const Scene scene = parse_scene(text.str(), "scene.json");
  ASSERT_EQ(scene.bodies.size(), static_cast<std::size_t>(kOthers));
  ASSERT_EQ(scene.shapes.size(), static_cast<std::size_t>(kOthers));
  ASSERT_EQ(scene.joints.size(), static_cast<std::size_t>(kOthers));
  EXPECT_EQ(scene.shapes.back().material.friction, 0.5f);
  EXPECT_EQ(scene.joints.back().body_a, static_cast<std::uint32_t>(kOthers - 1));
}

}  // namespace
}  // namespace scree::scenes
