// Pictures as the command line asks for them, for `scree render` and `scree run --picture`.
#pragma once

#include <scree/scree.h>
#include <tools/render/camera.h>
#include <tools/render/draw.h>

#include <cstdint>
#include <optional>
#include <string>

namespace scree::command {

struct PictureOptions {
  std::string size = "1280x720";
  std::string camera = "corner";  // corner, front, side, top, or the eye as X,Y,Z, or eye and target
  std::optional<double> view;     // degrees
  std::string color_by = "body";
  bool rough = false;  // edges are not smooth
  bool walls = false;  // what hides the subject stays
};

// The same, read.
struct PicturePlan {
  render::DrawOptions draw;
  double view = render::kDefaultView;  // degrees
  std::optional<render::Side> side;    // or else a place:
  Vec3 eye{};                          // m
  std::optional<Vec3> target;          // m; without one the middle of the subject
  bool keeps_walls = false;
};

// Throws scree::Error, which names the option.
PicturePlan read_picture(const PictureOptions& options);

// Throws scree::Error for a name that does not end in .png.
void check_picture_name(const char* option, const std::string& file);

// Throws scree::Error where there is no such camera.
render::Camera camera_for(const PicturePlan& plan, const render::Subject& subject);

// A picture, as it goes into a file.
struct PictureFigures {
  std::string file;
  std::string png;
  double seconds = 0.0;  // to draw it; the first query after a step brings what queries keep up to date
  double seconds_packing = 0.0;
  std::uint64_t rays = 0;
};

PictureFigures take_picture(const World& world, const PicturePlan& plan, const render::Camera& camera,
                            const render::Subject& subject, const std::string& file, Workers& workers);

// The row of a table.
std::string picture_row(const PictureFigures& figures);

}  // namespace scree::command
