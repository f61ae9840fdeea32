// The inside of Recorder. Private to recorder.cpp and shared_keyframe.cpp.
#pragma once

#include <parallel/recording/recording_writer.h>
#include <scree/export.h>
#include <scree/recording.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>

namespace scree {

struct SCREE_HIDDEN Recorder::Impl final : CallSink {
  // Records the whole world from its state now on; of a part of a world, that is for write_shared_keyframe()
  // to write.
  Impl(WorldData& world, const std::string& file, const RecorderOptions& options);
  ~Impl();

  void called(const MadeCall& call) noexcept override;
  void restored(const WorldData& world) noexcept override;
  void stepped(const WorldData& world, float dt, std::uint64_t hash) noexcept override;
  void world_ended() noexcept override;
  void step_failed() noexcept override;

  // Whether a keyframe would hold what the last step has left, and there is none of it yet.
  bool can_add_keyframe() const { return !has_state || (!calls_follow && last_keyframe != steps); }
  // Lets go of the world and writes the rest, with a keyframe if that is asked for and the world is as its
  // last step has left it.
  void end(bool with_keyframe) noexcept;
  // Does the work, or ends the recording if that fails.
  template <class Work>
  void keep(Work&& work) noexcept;
  void append_new_solids(SolidVectors& to);
  void add_state(const WorldData& world, ChunkKind kind);
  void note_keyframe() {
    last_keyframe = steps;
    has_state = true;
  }
  std::uint64_t position() const { return first_step + steps; }

  const std::uint64_t spacing;
  const std::uint64_t first_step;
  WorldData* data = nullptr;  // null: the recording has ended
  std::uint64_t steps = 0;
  std::uint64_t last_keyframe = 0;                    // steps before it
  bool has_state = false;                             // the first keyframe is there
  bool calls_follow = false;                          // since the last step
  SolidList solids;                                   // of the whole recording
  std::size_t hulls_told = 0, meshes_told = 0;        // of them, how many the writer knows
  bool finished = false;                              // finish() has been called
  const int exceptions = std::uncaught_exceptions();  // on their way when the recording began
  RecordingWriter writer;
};

// Of a world that many ranks have, rank 0's.
struct SCREE_HIDDEN SharedRecorder {
  static Recorder record_part(World& world, const std::string& file, const RecorderOptions& options);
  using Impl = Recorder::Impl;
  static Impl* impl(Recorder& recorder) { return recorder.impl_.get(); }
};

}  // namespace scree
