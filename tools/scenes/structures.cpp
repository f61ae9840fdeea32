// Scenes that are built, not poured: pyramids, stack, wall, card house, slope.
#include <tools/scenes/angles.h>
#include <tools/scenes/builders.h>

#include <algorithm>

namespace scree::scenes {
namespace {

constexpr float kHalf = 0.5f;  // m, half-extent of the cubes

// A pyramid `base` cubes wide in the plane z, its rows i = 0 .. base - 1 at heights i + 0.5.
void add_pyramid(Scene& scene, int base, float x0, float z, std::uint32_t shape) {
  for (int i = 0; i < base; ++i) {
    for (int j = i; j < base; ++j) {
      BodyDef def;
      def.position = {0.5f * static_cast<float>(i + 1) + static_cast<float>(j - i) + x0,
                      static_cast<float>(i) + 0.5f, z};
      add_body(scene, def, shape);
    }
  }
}

}  // namespace

Scene large_pyramid(const Parameters& parameters) {
  const int base = whole(parameters, "base");
  Scene scene = start_scene("large_pyramid", 200);
  scene.settings.sleeping = false;
  scene.settings.continuous = false;
  add_ground(scene, std::max(400.0f, static_cast<float>(base)));
  const std::uint32_t shape = add_shape(scene, Box{{kHalf, kHalf, kHalf}}, {.density = 100.0f});
  add_pyramid(scene, base, -kHalf * static_cast<float>(base), 0.0f, shape);
  return scene;
}

Scene many_pyramids(const Parameters& parameters) {
  const int base = whole(parameters, "base");
  const int columns = whole(parameters, "columns");
  const int rows = whole(parameters, "rows");
  // The published scene has 14 columns and rows on a ground of half-width 77.
  const float half_width = kHalf * static_cast<float>(columns * (base + 1));
  constexpr double kRowPitch = 152.0 / 13.0;  // m
  const double rows_start = -0.5 * kRowPitch * (rows - 1);
  Scene scene = start_scene("many_pyramids", 100);
  scene.settings.sleeping = false;
  scene.settings.continuous = false;
  add_ground(scene, std::max(half_width, static_cast<float>(1.0 - rows_start)));
  const std::uint32_t shape = add_shape(scene, Box{{kHalf, kHalf, kHalf}}, {.density = 100.0f});
  for (int row = 0; row < rows; ++row) {
    const float z = static_cast<float>(rows_start + kRowPitch * row);
    for (int column = 0; column < columns; ++column) {
      const float center = -half_width + 1.0f + static_cast<float>((base + 1) * column);
      add_pyramid(scene, base, center - 0.5f, z, shape);
    }
  }
  return scene;
}

Scene stack(const Parameters& parameters) {
  Scene scene = start_scene("stack", 3600);
  add_ground(scene, 50.0f);
  const std::uint32_t shape = add_shape(scene, Box{{kHalf, kHalf, kHalf}});
  for (int i = 0; i < whole(parameters, "bodies"); ++i) {
    BodyDef def;
    def.position = {0.0f, static_cast<float>(i) + 0.5f, 0.0f};
    add_body(scene, def, shape);
  }
  return scene;
}

Scene wall(const Parameters& parameters) {
  constexpr Vec3 kBrick{0.5f, 0.25f, 0.25f};  // m, half-extents; every other row starts with half a brick
  const int columns = whole(parameters, "columns");
  Scene scene = start_scene("wall", 600);
  add_ground(scene, 50.0f + static_cast<float>(columns));
  const std::uint32_t brick = add_shape(scene, Box{kBrick});
  const std::uint32_t half_brick = add_shape(scene, Box{{0.5f * kBrick.x, kBrick.y, kBrick.z}});
  const float left = -0.5f * static_cast<float>(columns);
  for (int row = 0; row < whole(parameters, "rows"); ++row) {
    BodyDef def;
    def.position.y = kBrick.y * static_cast<float>(2 * row + 1);
    const bool shifted = row % 2 == 1;
    const int whole_bricks = shifted ? columns - 1 : columns;
    for (int i = 0; i < whole_bricks; ++i) {
      def.position.x = left + static_cast<float>(i) + (shifted ? 1.0f : 0.5f);
      add_body(scene, def, brick);
    }
    if (!shifted) continue;
    for (const float side : {-1.0f, 1.0f}) {
      def.position.x = side * (0.25f + left);
      add_body(scene, def, half_brick);
    }
  }
  return scene;
}

// Planks of 15 : 3 : 1, the proportions of the toy, laid crosswise, layer by layer, the outer ones flush with
// the ends of those below.
Scene kapla(const Parameters& parameters) {
  constexpr Vec3 kPlank{0.585f, 0.039f, 0.117f};  // m, half-extents: ten times the toy
  const int planks = whole(parameters, "planks");
  const int base = whole(parameters, "base");
  Scene scene = start_scene("kapla", 3600);
  add_ground(scene, 50.0f);
  const std::uint32_t along = add_shape(scene, Box{kPlank});
  const std::uint32_t across = add_shape(scene, Box{{kPlank.z, kPlank.y, kPlank.x}});
  const float pitch = 2.0f * (kPlank.x - kPlank.z) / static_cast<float>(base - 1);
  for (int i = 0; i < planks; ++i) {
    const int layer = i / base, place = i % base;
    const float offset = pitch * static_cast<float>(place) - (kPlank.x - kPlank.z);
    BodyDef def;
    def.position.y = kPlank.y * static_cast<float>(2 * layer + 1);
    (layer % 2 == 0 ? def.position.z : def.position.x) = offset;
    add_body(scene, def, layer % 2 == 0 ? along : across);
  }
  return scene;
}

// Pairs of cards lean against each other and carry flat cards, each reaching from one ridge to the next; the
// pairs of the next story stand on those. Everything touches exactly and nothing overlaps:
// with thickness 2 t, height 2 h, lean a, c = cos a, s = sin a, a card's lowest edge lies h c + t s below its
// center and (h s - t c) to the outside, its inner upper edge (t c + h s) to the inside, its highest edge
// h c + t s above the center and 2 t c away from the ridge.
Scene card_house(const Parameters& parameters) {
  constexpr double kThickness = 0.005;  // m, half of the 1 cm
  constexpr double kHeight = 0.25;      // m, half
  constexpr double kDepth = 0.175;      // m, half
  constexpr double kLean = 24.0;        // degrees from upright
  // The thrust of a leaning card needs tan(lean) = 0.45 at most, the transfer of load within an end pair
  // more: four and five stories stand at 21 to 27 degrees, with 0.6 four stand at 24 alone.
  constexpr float kCardFriction = 0.8f;
  constexpr double kGap = 0.002;  // m, between neighboring feet and neighboring flat cards
  // The outer flat cards reach past their ridge: a load on both upper edges of the ridge keeps its pair in
  // balance, on the inner edge alone it would push that card down along the other.
  constexpr double kOverhang = 0.03;  // m
  const auto [sine, cosine] = sine_cosine(kLean);
  const double center_height = kHeight * cosine + kThickness * sine;
  const double half_pair = kThickness * cosine + kHeight * sine;  // from the ridge to a card's center
  const double pitch = 4.0 * half_pair + kGap;                    // from ridge to ridge
  const double story_height = 2.0 * (center_height + kThickness);

  Scene scene = start_scene("card_house", 1800);
  const Material paper{.friction = kCardFriction};
  add_ground(scene, 50.0f, paper);
  const auto box = [](double x, double y, double z) {
    return Box{{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}};
  };
  const std::uint32_t card = add_shape(scene, box(kThickness, kHeight, kDepth), paper);
  const auto place = [&](double x, double y, double lean, std::uint32_t shape) {
    BodyDef def;
    def.position = {static_cast<float>(x), static_cast<float>(y), 0.0f};
    def.rotation = rotation_about({0.0f, 0.0f, 1.0f}, lean);
    add_body(scene, def, shape);
  };
  const int stories = whole(parameters, "stories");
  for (int story = 0; story < stories; ++story) {
    const int pairs = stories - story;
    const double ground = story_height * story;
    const double first_ridge = -0.5 * pitch * (pairs - 1);
    for (int i = 0; i < pairs; ++i) {
      const double ridge = first_ridge + pitch * i;
      place(ridge - half_pair, ground + center_height, -kLean, card);
      place(ridge + half_pair, ground + center_height, kLean, card);
    }
    for (int i = 0; i + 1 < pairs; ++i) {
      double left = first_ridge + pitch * i + 0.5 * kGap;
      double right = first_ridge + pitch * (i + 1) - 0.5 * kGap;
      if (i == 0) left -= kOverhang;
      if (i + 2 == pairs) right += kOverhang;
      const std::uint32_t flat = add_shape(scene, box(0.5 * (right - left), kThickness, kDepth), paper);
      place(0.5 * (left + right), ground + story_height - kThickness, 0.0, flat);
    }
  }
  return scene;
}

// Flat boxes side by side at the upper end of a ramp. The mixing rule is the product and the ramp has
// friction 1, so that a box's coefficient is its contact's.
Scene slope(const Parameters& parameters) {
  constexpr double kHalfLength = 30.0;    // m, of the ramp
  constexpr double kHalfThickness = 0.5;  // m, of the ramp
  constexpr Vec3 kBlock{0.5f, 0.25f, 0.5f};
  constexpr double kLane = 2.0;  // m, from box to box across the ramp
  const double angle = parameters.at("angle");
  const int boxes = whole(parameters, "boxes");
  const auto [sine, cosine] = sine_cosine(angle);
  Scene scene = start_scene("slope", 300);
  add_ground(scene, static_cast<float>(100.0 + kLane * boxes));
  const double half_breadth = 0.5 * kLane * boxes;
  // The ramp climbs along +x; its lower end is just above the ground.
  const Quat tilt = rotation_about({0.0f, 0.0f, 1.0f}, angle);
  const double ramp_y = kHalfLength * sine + kHalfThickness * cosine + 0.1;
  const Material rough{.friction = 1.0f, .friction_mix = MixRule::product};
  const std::uint32_t ramp =
      add_shape(scene,
                Box{{static_cast<float>(kHalfLength), static_cast<float>(kHalfThickness),
                     static_cast<float>(half_breadth)}},
                rough);
  add_body(scene,
           {.type = BodyType::fixed, .position = {0.0f, static_cast<float>(ramp_y), 0.0f}, .rotation = tilt},
           ramp);
  const double along = kHalfLength - 2.0;  // from the ramp's center
  const double above = kHalfThickness + static_cast<double>(kBlock.y);
  const double low = parameters.at("friction_min");
  const double high = parameters.at("friction_max");
  for (int i = 0; i < boxes; ++i) {
    const double share = boxes > 1 ? static_cast<double>(i) / (boxes - 1) : 0.0;
    Material material = rough;
    material.friction = static_cast<float>(low + (high - low) * share);
    BodyDef def;
    def.position = {static_cast<float>(along * cosine - above * sine),
                    static_cast<float>(ramp_y + along * sine + above * cosine),
                    static_cast<float>(kLane * (i + 0.5) - half_breadth)};
    def.rotation = tilt;
    add_body(scene, def, add_shape(scene, Box{kBlock}, material));
  }
  return scene;
}

}  // namespace scree::scenes
