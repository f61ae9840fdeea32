// A track: one history of a world, to be looked at at any of its steps. A recording is one; a scene that runs
// and a branch of another track are live ones, which grow at their end and can be touched there. A live track
// records itself into a file, and looks back as recordings do: by playing on from a keyframe.
#pragma once

#include <scree/recording.h>
#include <scree/scree.h>
#include <tools/scenes/stage.h>
#include <tools/view/frame.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scree::view {

// Figures of a step, by what is written beside them; and what happened in it.
struct PastStep {
  static constexpr int kFigures = 8;

  // time in s, bodies, bodies awake, contacts, kinetic energy in J, residual in m/s, milliseconds, 1 if a
  // step was played (the first state has no figures but the first two); then milliseconds by phase.
  std::array<double, kFigures + kPhaseCount> figures{};
};

enum class EventKind : std::uint8_t { sleep, wake, hit, break_joint, restore };

struct PastEvent {
  std::uint64_t step;
  EventKind kind;
  std::uint32_t index;  // of a body, of a hit the one with the lower index; of a joint that broke
  std::uint32_t count;  // of its kind in the step: events of a kind share one entry, which tells the first
  float value;          // m/s of the fastest hit, else 0
};

// Frames that have been made, within a budget; those far from where the user is are forgotten first.
class FrameCache {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{512} << 20;  // of all tracks of a server

  // A frame that has what is asked for, and maybe more.
  Bytes find(std::uint64_t step, const FrameOptions& options) const;
  bool has(std::uint64_t step) const { return frames_.contains(step); }
  void keep(std::uint64_t step, const FrameOptions& options, Bytes frame, std::uint64_t near);
  void forget(std::uint64_t step) { erase(frames_.find(step)); }
  void set_limit(std::size_t bytes) { most_bytes_ = bytes; }

 private:
  struct Entry {
    FrameOptions options;
    Bytes bytes;
  };
  using Frames = std::map<std::uint64_t, Entry>;
  void erase(Frames::iterator entry);

  Frames frames_;
  std::size_t bytes_ = 0, most_bytes_ = kMostBytes;
};

class Track {
 public:
  // Of a recording. Throws Error, which names the file.
  Track(std::string name, const std::string& file);
  // Of a scene's first world, which records itself into `file`.
  Track(std::string name, const scenes::Scene& scene, const std::string& file);
  // Of a world of its own, which records itself into `file`. `dt`: s, or 0: the usual one.
  Track(std::string name, World world, float dt, const std::string& file);

  bool is_live() const { return live_ != nullptr; }
  std::uint64_t first() const { return first_; }
  std::uint64_t last() const { return last_; }
  // The last step that the scene or the recording states.
  std::uint64_t planned() const { return planned_; }
  float dt() const { return dt_; }  // s, nominal; of a recording known once a step was played
  const std::string& file() const { return file_; }
  // Where looking back begins, ascending: of a recording its own keyframes.
  std::vector<std::uint64_t> keyframes() const;
  const std::vector<PastStep>& past() const { return past_; }
  const std::vector<PastEvent>& events() const { return events_; }

  // Brings the state at a step nearer by at most one step of simulation; true once it is there. Runs on at
  // the end of a live track.
  bool approach(std::uint64_t step, Workers& workers);
  // The state that approach() or look_ahead() has brought last, its step, and the length of the step that
  // brought it: 0 where none did.
  const World& shown() const { return *shown_; }
  std::uint64_t shown_step() const { return shown_step_; }
  float shown_dt() const { return shown_dt_; }
  // False where a seek to a keyframe has brought the state: it has no contact forces then, and no figures.
  bool is_whole() const { return is_whole_; }

  // Of a recording: plays on by a step behind the user's back, and notes its figures. False: all is known.
  bool look_ahead(Workers& workers);

  // Of a live track: the world at its end, to be changed.
  World& end() { return *live_; }
  const World& end() const { return *live_; }
  // A world of its own in the state that is shown.
  World branch() const;
  // A player of the steps so far, up to this one at least. Waits for the file of a live track.
  Player open(std::uint64_t step) const;
  Player open() const { return open(last_); }

  std::string name;
  std::uint32_t parent = kNoParent;
  std::string error;  // what ended it
  FrameCache frames;
  Cast::Memory memory;
  std::uint64_t near = 0;    // the step that a page has asked for last
  bool was_touched = false;  // at its end: the state there is what it was before, once it has gone on

  static constexpr std::uint32_t kNoParent = 0xffffffffu;

 private:
  void begin_live(World& world, const std::string& file);
  void advance(Workers& workers);
  void note(const World& world, double time, bool was_played);
  bool approach_past(std::uint64_t step, Workers& workers);
  bool play_towards(std::uint64_t step, Workers& workers);
  void show(const World& world, std::uint64_t step, std::optional<float> dt);

  std::string file_;
  std::uint64_t first_ = 0, last_ = 0, planned_ = 0;
  float dt_ = 0.0f;
  std::vector<PastStep> past_;
  std::vector<PastEvent> events_;

  std::unique_ptr<scenes::Stage> stage_;  // of a scene
  std::unique_ptr<World> world_;          // of a branch
  World* live_ = nullptr;
  std::optional<Recorder> recorder_;  // after what it records: it ends first

  std::optional<Player> player_, scout_;
  const World* shown_ = nullptr;
  std::uint64_t shown_step_ = 0;
  float shown_dt_ = 0.0f;
  bool is_whole_ = true;
};

}  // namespace scree::view
