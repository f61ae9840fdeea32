// What can be played and looked at, step by step: a scene, which is simulated, or a recording.
#pragma once

#include <scree/recording.h>
#include <scree/scree.h>
#include <tools/scenes/stage.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace scree::command {

// A file that begins as recordings do, or is called *.scree.
bool is_recording_file(const std::string& file);

class Source {
 public:
  // What is no recording is the name of a scene, as for `scree run`; of a scene of many worlds the first is
  // taken. Throws Error for what is neither, and for parameters of recordings.
  Source(const std::string& name, const scenes::Parameters& parameters);

  bool is_recording() const { return player_.has_value(); }
  std::uint64_t first() const;  // step counters; of a scene 0
  // Of a recording its last step, of a scene the number of steps that it states; it may go on.
  std::uint64_t last() const;
  std::uint64_t position() const;
  const World& world() const;

  // Throws Error for a step outside of a recording, or before the position of a scene.
  void go_to(std::uint64_t step, Workers& workers);

  // The latest step up to this one that takes no simulation.
  std::uint64_t keyframe_before(std::uint64_t step) const;

 private:
  std::string name_;
  std::optional<Player> player_;
  std::unique_ptr<scenes::Stage> stage_;
  int steps_ = 0;  // that the scene states
  float dt_ = 0.0f;
};

}  // namespace scree::command
