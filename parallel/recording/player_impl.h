// The inside of Player. Private to player.cpp and compare_recordings.cpp.
#pragma once

#include <parallel/recording/recording_file.h>
#include <scree/export.h>
#include <scree/recording.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace scree {

struct SCREE_HIDDEN Player::Impl {
  template <class Source>
  explicit Impl(const Source& source) : file(source), stream(file) {
    restore_keyframe(0);
  }

  // Puts the world into the state of a keyframe.
  void restore_keyframe(std::size_t keyframe);
  bool step(Workers& workers);
  // The recorded calls up to the next step, and what that step is.
  const RecordStream::Step& make_calls();
  // Settings that the recorded calls have brought, with what is measured besides.
  void turn_measures_on();
  void measure(const PlayerMeasures& to);
  void seek(std::uint64_t step, Workers& workers, const char* call);
  std::size_t keyframe_chunk(std::size_t keyframe) const { return file.keyframes()[keyframe]; }
  std::uint64_t keyframe_step(std::size_t keyframe) const { return file.keyframe_steps()[keyframe]; }
  // Where the world, which stands at the keyframe's step, differs from its state; empty if it does not.
  std::string difference_from(std::size_t keyframe);
  // Plays on to the next keyframe, or compares at once if there is one at this step.
  void find_difference(Divergence& divergence, Workers& workers);
  std::optional<Divergence> compare_step();
  std::optional<Divergence> compare_state();

  RecordingFile file;
  RecordStream stream;
  World world;
  Snapshot scratch;  // of the world, to compare with keyframes
  std::uint64_t position = 0;
  std::optional<std::uint64_t> hash;       // recorded after the last step
  std::optional<float> dt;                 // s, of the last step
  std::optional<RecordStream::Step> next;  // where the calls before it have been made already
  PlayerMeasures measures;
  bool is_measured = false;  // the world's settings ask for more than the recorded ones
  bool is_lost = false;      // the world is not the recorded one: only a keyframe helps
};

}  // namespace scree
