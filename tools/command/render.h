// Pictures of scenes and recordings: options -> source -> camera -> pictures -> figures.
#pragma once

#include <scree/scree.h>
#include <tools/command/picture.h>
#include <tools/files/output_file.h>
#include <tools/scenes/scene.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace scree::command {

struct RenderOptions {
  std::string source;             // a recording, a built-in scene or a scene file
  scenes::Parameters parameters;  // of a built-in scene
  PictureOptions picture;
  std::optional<std::uint64_t> at;      // the step of a single picture; default: the last
  std::optional<std::uint64_t> every;   // steps from one picture of a series to the next
  std::optional<std::uint64_t> from;    // of a series; default: the first step
  std::optional<std::uint64_t> to;      // of a series; default: the last step
  std::optional<int> rate;              // pictures a second of a film; default: 30
  std::string file;                     // of a series: NAME.png for NAME-000000.png, ...
  std::vector<files::NamedFile> taken;  // inputs and other outputs: no picture may replace them
  int threads = 0;                      // 0: one per core
  Isa isa = Isa::automatic;
  bool quiet = false;  // no progress
};

struct RenderFigures {
  std::string source;
  std::string first_file, last_file;
  std::uint64_t first_step = 0, last_step = 0;  // of the pictures
  std::uint64_t pictures = 0;
  bool series = false;
  std::string film;          // its file; empty: none
  std::uint64_t bodies = 0;  // at the last picture
  int width = 0, height = 0;
  render::Camera camera;
  double seconds_playing = 0.0;  // of all pictures, as those that follow
  double seconds_drawing = 0.0;
  double seconds_writing = 0.0;
  std::uint64_t rays = 0;
  Isa isa = Isa::scalar;
  int threads = 1;
};

// Throws scree::Error for bad options.
RenderFigures render_pictures(const RenderOptions& options);

std::string to_table(const RenderFigures& figures);
std::string to_json(const RenderFigures& figures);

}  // namespace scree::command
