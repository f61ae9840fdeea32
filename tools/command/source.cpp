// See source.h.
#include <tools/command/run.h>
#include <tools/command/source.h>
#include <tools/files/recordings.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace scree::command {

bool is_recording_file(const std::string& file) {
  if (!is_scene_file(file)) return false;  // but a built-in scene, or nothing
  if (file.ends_with(".scree")) return true;
  constexpr std::string_view kMark = "SCREEREC";  // see the format in core/README.md
  std::error_code problem;
  if (!std::filesystem::is_regular_file(file, problem))
    return false;  // reading a pipe would take the mark out
  char bytes[kMark.size()] = {};
  std::ifstream(file, std::ios::binary).read(bytes, sizeof bytes);
  return std::string_view(bytes, sizeof bytes) == kMark;
}

Source::Source(const std::string& name, const scenes::Parameters& parameters) : name_(name) {
  if (is_recording_file(name)) {
    if (!parameters.empty())
      throw Error("--set " + parameters.begin()->first + ": a recording has no parameters");
    player_.emplace(files::open_recording(name));
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

std::uint64_t Source::keyframe_before(std::uint64_t step) const {
  if (!player_) return position();
  const std::span<const std::uint64_t> steps = player_->keyframe_steps();
  const auto after = std::upper_bound(steps.begin(), steps.end(), step);
  return after == steps.begin() ? steps.front() : after[-1];
}

const World& Source::world() const { return player_ ? player_->world() : stage_->worlds().front(); }

void Source::go_to(std::uint64_t step, Workers& workers) {
  if (player_) {
    files::naming(name_, [&] { player_->seek(step, workers); });
    files::check_repeats(*player_, name_);
    return;
  }
  if (step < position())
    throw Error(name_ + ": step " + std::to_string(step) + " is over; a scene goes on only");
  while (position() < step) stage_->advance(dt_, workers);
}

}  // namespace scree::command
