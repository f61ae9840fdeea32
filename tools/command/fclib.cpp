// See fclib.h.
#include <tools/command/fclib.h>
#include <tools/command/options.h>
#include <tools/command/run.h>

namespace scree::command {

namespace {

constexpr int kMostFclibSteps = 1'000'000;

}  // namespace

fclib::FclibFigures write_fclib(const FclibArguments& arguments) {
  fclib::check_available();
  check_backend(arguments.threads, arguments.isa);
  check_range("--at", arguments.at, 0, kMostFclibSteps);
  const std::vector<scenes::Scene> worlds = find_scene(arguments.scene, arguments.parameters);
  fclib::FclibOptions options;
  options.file = arguments.file;
  options.at = arguments.at;
  options.dt = worlds.front().dt;
  options.threads = arguments.threads;
  options.isa = arguments.isa;
  return fclib::write(worlds, options);
}

}  // namespace scree::command
