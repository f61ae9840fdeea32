// See export.h.
#include <tools/command/clock.h>
#include <tools/command/export.h>
#include <tools/command/options.h>
#include <tools/command/progress.h>
#include <tools/command/replay.h>
#include <tools/command/text.h>
#include <tools/export/gltf.h>
#include <tools/export/mcap_show.h>
#include <tools/export/show.h>
#include <tools/files/recordings.h>
#include <tools/view/page.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <limits>
#include <utility>

namespace scree::command {
namespace {

using Format = std::function<std::string(const exports::Show&)>;

Format format_of(const ExportOptions& options) {
  const std::string& file = options.output;
  if (file.ends_with(".gltf")) return exports::to_gltf;
  if (file.ends_with(".glb")) return exports::to_glb;
  if (file.ends_with(".mcap")) return exports::to_mcap;
  if (!file.ends_with(".html"))
    throw Error("--out " + file + ": the name of the file must end in .html, .gltf, .glb or .mcap");
  if (!view::has_page()) throw Error("--out " + file + ": " + view::kNoPage);
  const std::string title = std::filesystem::path(options.file).filename().string();
  return [title](const exports::Show& show) { return view::make_page(show, title); };
}

}  // namespace

ExportFigures export_show(const ExportOptions& options) {
  check_backend(options.threads, options.isa);
  const Format format = format_of(options);
  if (options.every == 0) throw Error("--every 0 must be at least 1");
  Player player = files::open_recording(options.file);
  const RecordingInfo info = player.info();
  ExportFigures figures;
  figures.file = options.file;
  figures.output = options.output;
  figures.from = options.from.value_or(info.first_step);
  figures.to = options.to.value_or(info.last_step);
  check_span(info, figures.from, figures.to);
  if (!options.quiet) tell_of_idle_threads(options.threads);
  Workers workers({.threads = options.threads, .isa = options.isa});
  const auto start = Clock::now();
  constexpr std::uint64_t kMostTicks = std::numeric_limits<int>::max();
  Progress progress(options.file,
                    static_cast<int>(std::clamp<std::uint64_t>(figures.to - figures.from, 1, kMostTicks)),
                    !options.quiet);
  const exports::Show show = files::naming(options.file, [&] {
    return exports::play(player, figures.from, figures.to, options.every, workers,
                         [&](std::uint64_t done, std::uint64_t) {
                           progress.show(static_cast<int>(std::min(done, kMostTicks)));
                         });
  });
  files::check_repeats(player, options.file);
  progress.finish();
  figures.bytes = format(show);
  figures.samples = show.times.size();
  figures.bodies = show.actors.size();
  figures.duration = show.times.back();
  figures.seconds = seconds_since(start);
  figures.isa = workers.isa();
  figures.threads = workers.threads();
  return figures;
}

std::string to_table(const ExportFigures& figures) {
  return table_head(figures) +
         row("samples", grouped(figures.samples) + format(" of %.2f s", figures.duration)) +
         row("bodies", grouped(figures.bodies)) + table_tail(figures);
}

std::string to_json(const ExportFigures& figures) {
  nlohmann::ordered_json json = json_head(figures);
  json["duration"] = figures.duration;
  return finish_json(std::move(json), figures);
}

}  // namespace scree::command
