// See picture.h.
#include <tools/command/clock.h>
#include <tools/command/options.h>
#include <tools/command/picture.h>
#include <tools/command/text.h>
#include <tools/render/cutaway.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string_view>
#include <vector>

namespace scree::command {
namespace {

constexpr double kLeastView = 1.0, kMostView = 170.0;  // degrees
constexpr float kFarthestEye = 1e7f;                   // m, as far as queries go

constexpr const char* kSides[] = {"corner", "front", "side", "top"};  // in the order of Side

// All of the text as a number.
template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  return problem == std::errc() && end == text.data() + text.size();
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(at);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

void read_size(const std::string& text, render::DrawOptions& draw) {
  const std::vector<std::string_view> parts = split(text, 'x');
  if (parts.size() != 2 || !read_number(parts[0], draw.width) || !read_number(parts[1], draw.height))
    throw Error("--size " + text + ": expected WIDTHxHEIGHT in pixels, such as 1280x720");
  for (const int side : {draw.width, draw.height}) {
    if (side < render::kSmallestSide || side > render::kLargestSide) {
      throw Error("--size " + text + ": " + std::to_string(side) + " must be from " +
                  std::to_string(render::kSmallestSide) + " to " + std::to_string(render::kLargestSide));
    }
  }
  if (std::int64_t{draw.width} * draw.height > render::kMostPixels) {
    throw Error("--size " + text + ": there must be at most " + std::to_string(render::kMostPixels) +
                " pixels");
  }
}

render::ColorBy read_coloring(const std::string& name) {
  std::string names;
  const auto known = render::color_names();
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (name == known[i]) return static_cast<render::ColorBy>(i);
    names += (names.empty() ? "" : ", ") + std::string(known[i]);
  }
  throw Error("--color-by " + name + ": unknown quantity; there are: " + names);
}

void read_camera(const std::string& text, PicturePlan& plan) {
  for (std::size_t i = 0; i < std::size(kSides); ++i) {
    if (text == kSides[i]) {
      plan.side = static_cast<render::Side>(i);
      return;
    }
  }
  const std::vector<std::string_view> parts = split(text, ',');
  float values[6] = {};
  bool all_read = parts.size() == 3 || parts.size() == 6;
  for (std::size_t i = 0; all_read && i < parts.size(); ++i) all_read = read_number(parts[i], values[i]);
  if (!all_read) {
    throw Error(
        "--camera " + text +
        ": expected corner, front, side, top, X,Y,Z (the eye) or X,Y,Z,X,Y,Z (the eye and its target)");
  }
  for (const float value : values) {
    if (!(std::abs(value) <= kFarthestEye))
      throw Error("--camera " + text + ": each number must be within +-1e7 m");
  }
  plan.eye = {values[0], values[1], values[2]};
  if (parts.size() == 3) return;
  plan.target = Vec3{values[3], values[4], values[5]};
  if (normalize(plan.eye - *plan.target) == Vec3{})
    throw Error("--camera " + text + ": the eye is where its target is");
}

}  // namespace

PicturePlan read_picture(const PictureOptions& options) {
  PicturePlan plan;
  read_size(options.size, plan.draw);
  read_camera(options.camera, plan);
  plan.draw.color_by = read_coloring(options.color_by);
  plan.draw.smooth = !options.rough;
  plan.keeps_walls = options.walls;
  if (options.view) {
    plan.view = *options.view;
    if (!(plan.view >= kLeastView && plan.view <= kMostView))
      throw Error("--view " + format("%g", plan.view) + " must be from 1 to 170 degrees");
  }
  return plan;
}

render::Camera camera_for(const PicturePlan& plan, const render::Subject& subject) {
  const double aspect = static_cast<double>(plan.draw.width) / plan.draw.height;
  if (plan.side) {
    const render::Camera camera = render::look_from(*plan.side, subject, plan.view, aspect);
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(camera.eye[axis]) > kFarthestEye)
        throw Error("--camera: from where all that moves is in the picture is beyond 1e7 m; name a place");
    }
    return camera;
  }
  render::Camera camera{plan.eye, plan.target.value_or(subject.middle), subject.up, plan.view};
  if (normalize(camera.eye - camera.target) == Vec3{})
    throw Error("--camera: the eye is in the middle of what moves; name a target");
  return camera;
}

void check_picture_name(const char* option, const std::string& file) {
  if (!file.ends_with(".png") || file == ".png" || file.ends_with("/.png"))
    throw Error(std::string(option) + " " + file + ": the name of the file must end in .png");
}

PictureFigures take_picture(const World& world, const PicturePlan& plan, const render::Camera& camera,
                            const render::Subject& subject, const std::string& file, Workers& workers) {
  render::DrawOptions draw = plan.draw;
  draw.reach = subject.reach;
  if (!plan.keeps_walls) draw.left_out = render::find_walls(world, camera.eye, subject, workers);
  PictureFigures figures;
  figures.file = file;
  const auto start = Clock::now();
  const render::Drawing drawing = render::draw(world, camera, draw, workers);
  figures.seconds = seconds_since(start);
  figures.rays = drawing.rays;
  const auto drawn = Clock::now();
  figures.png = render::to_png(drawing.picture);
  figures.seconds_packing = seconds_since(drawn);
  return figures;
}

std::string picture_row(const PictureFigures& figures) {
  return row("picture", figures.file + format(", %.2f s to draw", figures.seconds));
}

}  // namespace scree::command
