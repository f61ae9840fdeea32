// See view.h.
#include <spawn.h>
#include <tools/command/options.h>
#include <tools/command/run.h>
#include <tools/command/source.h>
#include <tools/command/view.h>
#include <tools/files/output_file.h>
#include <tools/view/server.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>

namespace scree::command {
namespace {

view::Opening opening_of(const std::string& source, const scenes::Parameters& parameters) {
  view::Opening opening;
  opening.name = std::filesystem::path(source).filename().string();
  if (is_recording_file(source)) {
    if (!parameters.empty())
      throw Error("--set " + parameters.begin()->first + ": a recording has no parameters");
    opening.file = source;
    return opening;
  }
  opening.scene = std::move(find_scene(source, parameters).front());
  return opening;
}

void open_browser(std::string url) {
  std::string program = "xdg-open";
  char* const arguments[] = {program.data(), url.data(), nullptr};
  pid_t process = 0;
  if (posix_spawnp(&process, program.c_str(), nullptr, nullptr, arguments, environ) != 0)
    std::cerr << "scree: --open: xdg-open cannot be started; open the address yourself\n";
}

}  // namespace

void view_sources(const ViewOptions& options) {
  check_backend(options.threads, options.isa);
  tell_of_idle_threads(options.threads);
  view::ServerOptions server{.address = options.address, .port = options.port, .engine = {}};
  server.engine.threads = options.threads;
  server.engine.isa = options.isa;
  for (const std::string& source : options.sources)
    server.engine.openings.push_back(opening_of(source, options.parameters));
  view::serve(server, [&](const std::string& url) {
    files::write_standard_output(url + "\n");
    if (options.open) open_browser(url);
  });
}

}  // namespace scree::command
