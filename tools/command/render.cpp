// See render.h.
#include <tools/command/clock.h>
#include <tools/command/options.h>
#include <tools/command/progress.h>
#include <tools/command/render.h>
#include <tools/command/run.h>
#include <tools/command/source.h>
#include <tools/command/text.h>
#include <tools/render/film.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

namespace scree::command {
namespace {

constexpr std::uint64_t kMostPictures = 100'000;  // of a series
constexpr int kMostRate = 1000;
constexpr int kDefaultRate = 30;

void check_options(const RenderOptions& options) {
  check_backend(options.threads, options.isa);
  if (options.at && options.every) throw Error("--at is for one picture, --every for a series");
  if (!options.every) {
    if (options.from || options.to) throw Error("--from and --to say nothing without --every");
    if (options.rate) throw Error("--rate says nothing without --every");
  }
  if (options.every && *options.every == 0) throw Error("--every 0 must be at least 1");
  if (options.rate) check_range("--rate", *options.rate, 1, kMostRate);
  check_picture_name("--out", options.file);
}

void check_step(const Source& source, const char* option, std::uint64_t step) {
  constexpr std::uint64_t kMostSteps = 1'000'000'000;  // of a scene
  const std::uint64_t last = source.is_recording() ? source.last() : kMostSteps;
  if (step >= source.first() && step <= last) return;
  throw Error(std::string(option) + " " + std::to_string(step) + " must be from " +
              std::to_string(source.first()) + " to " + std::to_string(last));
}

struct Shot {
  std::uint64_t step;
  std::string file;
};

std::string series_file(const std::string& file, std::uint64_t step) {
  return file.substr(0, file.size() - 4) + format("-%06llu.png", static_cast<unsigned long long>(step));
}

std::string film_file(const std::string& file) { return file.substr(0, file.size() - 4) + ".mp4"; }

// By step, ascending.
std::vector<Shot> plan_shots(const RenderOptions& options, const Source& source) {
  if (!options.every) {
    const std::uint64_t step = options.at.value_or(source.last());
    check_step(source, "--at", step);
    return {{step, options.file}};
  }
  const std::uint64_t from = options.from.value_or(source.first()), to = options.to.value_or(source.last());
  check_step(source, "--from", from);
  check_step(source, "--to", to);
  if (from > to)
    throw Error("--from " + std::to_string(from) + " must not be beyond --to " + std::to_string(to));
  if ((to - from) / *options.every >= kMostPictures) {
    throw Error("--every " + std::to_string(*options.every) + ": there would be more than " +
                std::to_string(kMostPictures) + " pictures");
  }
  std::vector<Shot> shots;
  for (std::uint64_t i = 0; i <= (to - from) / *options.every; ++i) {
    const std::uint64_t step = from + i * *options.every;
    shots.push_back({step, series_file(options.file, step)});
  }
  return shots;
}

void check_files(const RenderOptions& options, const std::vector<Shot>& shots) {
  for (const Shot& shot : shots) {
    const files::NamedFile file{"--out", shot.file};
    files::check_outputs(options.taken, std::span(&file, 1));
  }
  if (!options.every) return;
  const files::NamedFile film{"--out", film_file(options.file)};
  files::check_outputs(options.taken, std::span(&film, 1));
}

// What all pictures are about: what moves at the first one, and where a recording tells it without
// simulation, what moves in the end.
render::Subject find_subject(Source& source, const std::vector<Shot>& shots, Workers& workers) {
  std::optional<render::Subject> late;
  const std::uint64_t keyframe = source.keyframe_before(shots.back().step);
  if (keyframe > shots.front().step) {
    source.go_to(keyframe, workers);
    late = render::subject_of(source.world());
  }
  source.go_to(shots.front().step, workers);
  const render::Subject first = render::subject_of(source.world());
  return late ? render::join(first, *late) : first;
}

void take_pictures(const RenderOptions& options, const std::vector<Shot>& shots, Source& source,
                   Workers& workers, RenderFigures& figures) {
  const PicturePlan plan = read_picture(options.picture);
  auto start = Clock::now();
  const render::Subject subject = find_subject(source, shots, workers);
  figures.seconds_playing = seconds_since(start);
  figures.camera = camera_for(plan, subject);
  std::optional<render::Film> film;
  if (options.every && render::is_installed("ffmpeg"))
    film.emplace(figures.film = film_file(options.file), options.rate.value_or(kDefaultRate));
  Progress progress(options.source, static_cast<int>(shots.size()), !options.quiet);
  for (const Shot& shot : shots) {
    start = Clock::now();
    source.go_to(shot.step, workers);
    figures.seconds_playing += seconds_since(start);
    const PictureFigures picture =
        take_picture(source.world(), plan, figures.camera, subject, shot.file, workers);
    figures.seconds_drawing += picture.seconds;
    figures.rays += picture.rays;
    start = Clock::now();
    files::write_file({"--out", shot.file}, picture.png);
    if (film) film->add(picture.png);
    figures.seconds_writing += picture.seconds_packing + seconds_since(start);
    progress.show(static_cast<int>(++figures.pictures));
  }
  start = Clock::now();
  if (film) film->finish();
  figures.seconds_writing += seconds_since(start);
  progress.finish();
  figures.width = plan.draw.width;
  figures.height = plan.draw.height;
}

// As --camera takes it, and reads the same place.
std::string exact(Vec3 v) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    char digits[40];
    if (axis > 0) text += ',';
    text.append(digits, std::to_chars(digits, digits + sizeof digits, v[axis]).ptr);
  }
  return text;
}

nlohmann::ordered_json json_of(Vec3 v) { return {v.x, v.y, v.z}; }

}  // namespace

RenderFigures render_pictures(const RenderOptions& options) {
  check_options(options);
  read_picture(options.picture);  // before a scene is built
  Source source(options.source, options.parameters);
  const std::vector<Shot> shots = plan_shots(options, source);
  check_files(options, shots);
  if (!options.quiet) tell_of_idle_threads(options.threads);
  Workers workers(WorkersOptions{.threads = options.threads, .isa = options.isa});
  RenderFigures figures;
  figures.source = options.source;
  figures.series = options.every.has_value();
  figures.first_file = shots.front().file;
  figures.last_file = shots.back().file;
  figures.first_step = shots.front().step;
  figures.last_step = shots.back().step;
  take_pictures(options, shots, source, workers, figures);
  figures.bodies = source.world().body_count();
  figures.isa = workers.isa();
  figures.threads = workers.threads();
  return figures;
}

std::string to_table(const RenderFigures& figures) {
  std::string table = figures.source + "\n";
  if (figures.series) {
    table +=
        row("pictures", grouped(figures.pictures) + ", " + figures.first_file + " to " + figures.last_file);
    table += row("film", figures.film.empty() ? "none: ffmpeg is not installed" : figures.film);
  } else {
    table += row("picture", figures.first_file);
  }
  table += row("steps", figures.series ? grouped(figures.first_step) + " to " + grouped(figures.last_step)
                                       : grouped(figures.first_step));
  table += row("size", format("%d x %d pixels", figures.width, figures.height));
  table += row("bodies", grouped(figures.bodies));
  table += row("camera", exact(figures.camera.eye) + "," + exact(figures.camera.target) +
                             format(", view %g degrees", figures.camera.view));
  table += row("rays", grouped(figures.rays));
  table += row("seconds", format("%.2f to play, %.2f to draw, %.2f to write", figures.seconds_playing,
                                 figures.seconds_drawing, figures.seconds_writing));
  table += row("instruction set", isa_name(figures.isa));
  table += row("threads", std::to_string(figures.threads));
  return table;
}

std::string to_json(const RenderFigures& figures) {
  nlohmann::ordered_json json;
  json["source"] = figures.source;
  json["pictures"] = figures.pictures;
  json["first"] = {{"file", figures.first_file}, {"step", figures.first_step}};
  json["last"] = {{"file", figures.last_file}, {"step", figures.last_step}};
  json["film"] = figures.film.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(figures.film);
  json["width"] = figures.width;
  json["height"] = figures.height;
  json["bodies"] = figures.bodies;
  json["camera"] = {{"eye", json_of(figures.camera.eye)},
                    {"target", json_of(figures.camera.target)},
                    {"up", json_of(figures.camera.up)},
                    {"view", figures.camera.view}};
  json["rays"] = figures.rays;
  json["seconds"] = {{"playing", figures.seconds_playing},
                     {"drawing", figures.seconds_drawing},
                     {"writing", figures.seconds_writing}};
  json["isa"] = isa_name(figures.isa);
  json["threads"] = figures.threads;
  // A file's name may hold any bytes.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace scree::command
