// See draw.h. A band of pixels at a time: rays, hits, rays from the sun, colors.
#include <tools/render/draw.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>
#include <optional>
#include <vector>

namespace scree::render {
namespace {

constexpr std::size_t kBand = 1 << 16;  // rays: a band keeps 10 MB
constexpr float kFarthest = 1.9e7f;     // m, that a ray goes

// A place in a picture, in pixels from its left and upper edge.
struct Place {
  float x, y;
};

// All that colors depend on and that is the same for all rays.
struct Look {
  const World& world;
  DrawOptions options;
  Vec3 eye{}, up{}, sun{};              // unit but for the eye
  Vec3 across{}, upright{}, forward{};  // `forward` + x `across` + y `upright` goes through (x, y)
  Vec3 ground_a{}, ground_b{};          // unit, along the lines on the ground
  float pixel = 0.0f;                   // rad, in the middle of the picture
  float spacing = 0.0f;                 // m, of the lines
  float haze = 0.0f;                    // m, where half of a color is lost
  float sunway = 0.0f;                  // m, from which shadows come
  std::vector<Color> body_colors{};     // by BodyId::index
};

// What a band works with.
struct Band {
  std::vector<Ray> rays, sun_rays;
  std::vector<std::optional<CastHit>> hits;
  std::vector<std::size_t> sun_of;  // by ray from the sun: the ray of the picture
  std::vector<std::uint8_t> blocked;
  std::vector<std::uint8_t> lit;  // by ray of the picture
};

float spacing_for(float reach) {
  float spacing = 1e-4f;
  while (spacing < 0.15f * reach) spacing *= 10.0f;
  return spacing;
}

Look look_of(const World& world, const Camera& camera, const DrawOptions& options) {
  const Axes axes = axes_of(camera);
  const auto tangent = static_cast<float>(std::tan(camera.view * std::numbers::pi / 360.0));
  const auto half_height = 0.5f * static_cast<float>(options.height);
  Look look{world, options};
  look.eye = camera.eye;
  look.up = camera.up;
  look.sun = sun_of(camera);
  look.across = tangent / half_height * axes.right;
  look.upright = -(tangent / half_height) * axes.up;  // rows go down
  look.forward =
      -axes.backward - 0.5f * static_cast<float>(options.width) * look.across - half_height * look.upright;
  const Vec3 sideways = std::abs(camera.up.x) < 0.9f ? Vec3{1.0f, 0.0f, 0.0f} : Vec3{0.0f, 0.0f, 1.0f};
  look.ground_a = normalize(sideways - dot(sideways, camera.up) * camera.up);
  look.ground_b = cross(look.ground_a, camera.up);
  look.pixel = tangent / half_height;
  look.spacing = spacing_for(options.reach);
  look.haze = 40.0f * options.reach + 2.0f * distance(camera.eye, camera.target);
  look.sunway = std::min(look.haze, 1e7f);
  look.body_colors = color_bodies(world, options.color_by);
  return look;
}

Color sky(const Look& look, Vec3 direction) {
  const float height = dot(direction, look.up);
  const Color horizon = color_of(226, 233, 240), zenith = color_of(126, 164, 206),
              below = color_of(190, 194, 198);
  return height > 0.0f ? lerp(horizon, zenith, std::sqrt(height))
                       : lerp(horizon, below, std::min(-6.0f * height, 1.0f));
}

// From 0 to 1: how much of a pixel lies on a line of the ground.
float line_share(const Look& look, Vec3 point, float footprint) {
  const float width = 0.012f * look.spacing;
  float most = 0.0f;
  for (const Vec3& axis : {look.ground_a, look.ground_b}) {
    const float along = dot(point, axis) / look.spacing;
    const float off = std::abs(along - std::round(along)) * look.spacing;
    const float blur = 0.5f * (width + footprint);
    if (off < blur) most = std::max(most, std::min(width / footprint, 1.0f));
  }
  // Lines closer than a few pixels would flicker.
  return most * std::clamp(0.4f * look.spacing / footprint - 1.0f, 0.0f, 1.0f);
}

Color surface_color(const Look& look, const CastHit& hit, Vec3 normal, float footprint) {
  const bool is_fixed = look.world.body_type(hit.body) == BodyType::fixed;
  if (look.options.color_by == ColorBy::part && !is_fixed) return palette_color(hit.shape.index);
  const Color color = look.body_colors[hit.body.index];
  if (!is_fixed || dot(normal, look.up) < 0.8f) return color;
  return (1.0f - 0.35f * line_share(look, hit.point, footprint)) * color;
}

Color shade(const Look& look, const Ray& ray, const CastHit& hit, bool lit) {
  const Vec3 direction = normalize(ray.translation);
  const Vec3 normal = dot(hit.normal, direction) > 0.0f ? -hit.normal : hit.normal;
  const float facing = std::max(-dot(normal, direction), 0.05f);
  const Color color = surface_color(look, hit, normal, look.pixel * hit.distance / facing);
  const float sunlight = lit ? 0.95f * std::max(dot(normal, look.sun), 0.0f) : 0.0f;
  const Color from_sky =
      lerp(Color{0.26f, 0.26f, 0.27f}, Color{0.48f, 0.51f, 0.56f}, 0.5f + 0.5f * dot(normal, look.up));
  const Color light = from_sky + sunlight * Color{1.0f, 0.96f, 0.88f};
  const Color seen{color.x * light.x, color.y * light.y, color.z * light.z};
  const float lost = hit.distance * hit.distance / (hit.distance * hit.distance + look.haze * look.haze);
  return lerp(seen, sky(look, direction), lost);
}

// Queries take no place beyond.
bool is_too_far(Vec3 place) {
  constexpr float kMost = 1e7f;  // m
  return std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)}) > kMost;
}

// Rays from the sun to where a surface faces it. They meet meshes from the sun's side, so that the backs of
// meshes, which are not seen, throw no shadows.
void aim_from_sun(const Look& look, Band& band) {
  band.sun_rays.clear();
  band.sun_of.clear();
  for (std::size_t i = 0; i < band.rays.size(); ++i) {
    if (!band.hits[i]) continue;
    const CastHit& hit = *band.hits[i];
    const Vec3 normal = dot(hit.normal, band.rays[i].translation) > 0.0f ? -hit.normal : hit.normal;
    if (!(dot(normal, look.sun) > 0.0f)) continue;
    // Off the surface by half a pixel, and by more than single precision resolves there.
    const float size = std::abs(hit.point.x) + std::abs(hit.point.y) + std::abs(hit.point.z) + look.sunway;
    const float off = 0.5f * look.pixel * hit.distance + 4e-7f * size;
    const Vec3 start = hit.point + off * normal + look.sunway * look.sun;
    if (is_too_far(start)) {
      band.lit[i] = 1;
      continue;
    }
    band.sun_rays.push_back({start, -look.sunway * look.sun});
    band.sun_of.push_back(i);
  }
}

// Meshes are open from behind, so that one sees into a drum.
QueryOptions what_is_seen(const Look& look) {
  QueryOptions seen{.start_inside = StartInside::skip};
  const std::vector<ShapeId>& left_out = look.options.left_out;
  if (left_out.empty()) return seen;
  seen.predicate = [&left_out](ShapeId shape, BodyId) {
    return !std::binary_search(left_out.begin(), left_out.end(), shape);
  };
  return seen;
}

// Casts the rays of the band, and calls use(ray, color) for each in order.
template <class Use>
std::uint64_t cast(const Look& look, Band& band, Workers& workers, const Use& use) {
  const QueryOptions seen = what_is_seen(look);
  band.hits.assign(band.rays.size(), {});
  band.lit.assign(band.rays.size(), 0);
  cast_rays(look.world, band.rays, band.hits, workers, seen);
  aim_from_sun(look, band);
  band.blocked.assign(band.sun_rays.size(), 0);
  are_blocked(look.world, band.sun_rays, band.blocked, workers, seen);
  for (std::size_t i = 0; i < band.sun_of.size(); ++i) band.lit[band.sun_of[i]] = band.blocked[i] == 0;
  for (std::size_t i = 0; i < band.rays.size(); ++i) {
    use(i, band.hits[i] ? shade(look, band.rays[i], *band.hits[i], band.lit[i] != 0)
                        : sky(look, normalize(band.rays[i].translation)));
  }
  return band.rays.size() + band.sun_rays.size();
}

// Calls use(i, color) for each of `count` places, in order.
template <class PlaceOf, class Use>
std::uint64_t cast_through(const Look& look, std::size_t count, const PlaceOf& place_of, Workers& workers,
                           const Use& use) {
  std::uint64_t rays = 0;
  Band band;
  for (std::size_t begin = 0; begin < count; begin += kBand) {
    const std::size_t size = std::min(kBand, count - begin);
    band.rays.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      const Place place = place_of(begin + i);
      const Vec3 direction = look.forward + place.x * look.across + place.y * look.upright;
      band.rays[i] = {look.eye, kFarthest * normalize(direction)};
    }
    rays += cast(look, band, workers, [&](std::size_t i, Color color) { use(begin + i, color); });
  }
  return rays;
}

// Whether eyes see a difference.
bool differ(const std::uint8_t* a, const std::uint8_t* b) {
  constexpr int kSeen = 10;  // of 255
  return std::abs(a[0] - b[0]) > kSeen || std::abs(a[1] - b[1]) > kSeen || std::abs(a[2] - b[2]) > kSeen;
}

// Pixels that differ from a neighbor.
std::vector<std::uint32_t> edge_pixels(const Picture& picture) {
  std::vector<std::uint32_t> edges;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const std::uint8_t* here = picture.pixel(x, y);
      if ((x > 0 && differ(here, picture.pixel(x - 1, y))) ||
          (x + 1 < picture.width && differ(here, picture.pixel(x + 1, y))) ||
          (y > 0 && differ(here, picture.pixel(x, y - 1))) ||
          (y + 1 < picture.height && differ(here, picture.pixel(x, y + 1)))) {
        edges.push_back(static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(picture.width) +
                        static_cast<std::uint32_t>(x));
      }
    }
  }
  return edges;
}

void put(Picture& picture, std::size_t pixel, Color color) {
  std::uint8_t* bytes = picture.bytes.data() + 3 * pixel;
  bytes[0] = byte_of(color.x);
  bytes[1] = byte_of(color.y);
  bytes[2] = byte_of(color.z);
}

// Draws edges anew, as means of four places that lie in different rows and columns.
std::uint64_t smooth(const Look& look, Workers& workers, Picture& picture) {
  constexpr Place kPlaces[] = {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}};
  constexpr std::size_t kSamples = std::size(kPlaces);
  const std::vector<std::uint32_t> edges = edge_pixels(picture);
  const auto width = static_cast<std::uint32_t>(picture.width);
  const auto place_of = [&](std::size_t i) {
    const std::uint32_t pixel = edges[i / kSamples];
    const Place& place = kPlaces[i % kSamples];
    return Place{static_cast<float>(pixel % width) + place.x, static_cast<float>(pixel / width) + place.y};
  };
  Color sum;
  return cast_through(look, edges.size() * kSamples, place_of, workers, [&](std::size_t i, Color color) {
    sum = i % kSamples == 0 ? color : sum + color;
    if (i % kSamples == kSamples - 1) put(picture, edges[i / kSamples], sum / static_cast<float>(kSamples));
  });
}

}  // namespace

Vec3 sun_of(const Camera& camera) {
  const Axes axes = axes_of(camera);
  return normalize(0.9f * camera.up - 0.55f * axes.right + 0.6f * axes.backward);
}

Drawing draw(const World& world, const Camera& camera, const DrawOptions& options, Workers& workers) {
  const Look look = look_of(world, camera, options);
  const auto width = static_cast<std::size_t>(options.width),
             height = static_cast<std::size_t>(options.height);
  Drawing drawing{{options.width, options.height, std::vector<std::uint8_t>(3 * width * height)}};
  const auto middle_of = [width](std::size_t i) {
    return Place{static_cast<float>(i % width) + 0.5f, static_cast<float>(i / width) + 0.5f};
  };
  drawing.rays = cast_through(look, width * height, middle_of, workers,
                              [&](std::size_t i, Color color) { put(drawing.picture, i, color); });
  if (options.smooth) drawing.rays += smooth(look, workers, drawing.picture);
  return drawing;
}

}  // namespace scree::render
