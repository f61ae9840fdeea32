// See source.h.
#include <tools/command/run.h>
#include <tools/command/source.h>

#include <fstream>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace scree::command {
namespace {

bool is_recording_file(const std::string& file) {
  if (!is_scene_file(file)) return false;  // but a built-in scene, or nothing
  if (file.ends_with(".scree")) return true;
  constexpr std::string_view kMark = "SCREEREC";  // see the format in core/README.md
  char bytes[kMark.size()] = {};
  std::ifstream(file, std::ios::binary).read(bytes, sizeof bytes);
  return std::string_view(bytes, sizeof bytes) == kMark;
}

}  // namespace

Source::Source(const std::string& name, const scenes::Parameters& parameters) : name_(name) {
  if (is_recording_file(name)) {
    if (!parameters.empty())
      throw Error("--set " + parameters.begin()->first + ": a recording has no parameters");
    try {
      player_.emplace(name);
    } catch (const Error& error) {
      const std::string reason = error.what();
      throw Error(reason.find(name) != std::string::npos ? reason : name + ": " + reason);
    }
    return;
  }
  std::vector<scenes::Scene> worlds = find_scene(name, parameters);
  worlds.resize(1);
  steps_ = worlds.front().steps;
  dt_ = worlds.front().dt;
  stage_ = std::make_unique<scenes::Stage>(worlds);
}

std::uint64_t Source::first() const { return player_ ? player_->info().first_step : 0; }

std::uint64_t Source::last() const {
  return player_ ? player_->info().last_step : static_cast<std::uint64_t>(steps_);
}

std::uint64_t Source::position() const {
  return player_ ? player_->position() : static_cast<std::uint64_t>(stage_->steps());
}

std::uint64_t Source::last_keyframe() const { return player_ ? player_->keyframe_steps().back() : 0; }

const World& Source::world() const { return player_ ? player_->world() : stage_->worlds().front(); }

void Source::go_to(std::uint64_t step, Workers& workers) {
  if (player_) {
    player_->seek(step, workers);
    return;
  }
  if (step < position())
    throw Error(name_ + ": step " + std::to_string(step) + " is over; a scene goes on only");
  while (position() < step) stage_->advance(dt_, workers);
}

}  // namespace scree::command
