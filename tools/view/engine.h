// The worlds behind the pages of `scree view`, on a thread of their own: it plays tracks to where pages look,
// looks ahead where nothing is asked for, and makes branches.
//
// Pages ask in JSON, by "ask":
//
//   frames    frames (a track and a step each, in order of need), shade, details: replaces what the page has
//             asked for before. A step behind the end of a live track makes it run on.
//   touch     track, step, what (see touch.h): changes a live track that ends at the step, or a little later
//             where it is `running`; else begins a branch at the step
//   branch    track, step: a branch with nothing changed
//   name      track, name
//   run       track, to: runs on to a step whether or not a page looks; 0 ends that
//   parted    a, b: where two tracks part first
//
// and are told, by "kind": hello, tracks, past, branched, changed, parted, error; and in bytes, see frame.h.
#pragma once

#include <scree/scree.h>
#include <tools/view/touch.h>
#include <tools/view/track.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace scree::view {

// What is viewed: a recording's file, or a scene.
struct Opening {
  std::string name;
  std::string file;  // of a recording; empty: the scene
  std::optional<scenes::Scene> scene;
};

struct EngineOptions {
  std::vector<Opening> openings;  // two are compared
  int threads = 0;
  Isa isa = Isa::automatic;
};

using PageId = std::uint32_t;

class Engine {
 public:
  // Takes a message to a page that has joined; called on the engine's thread.
  using Send = std::function<void(PageId page, Bytes message, bool is_text)>;
  // Takes a file that was asked for, or what went wrong.
  using Take = std::function<void(std::string bytes, std::string error)>;

  // Opens all; throws Error as `scree run` and `scree replay` do.
  Engine(const EngineOptions& options, Send send);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // These may be called on any thread; what they ask for is done later.
  void join(PageId page);
  void leave(PageId page);
  void ask(PageId page, std::string text);
  // Of a track: its recording so far, and a page of some of its steps.
  void copy_recording(std::uint64_t track, Take take);
  void make_page(std::uint64_t track, std::uint64_t from, std::uint64_t to, std::uint64_t every, Take take);

 private:
  struct Ask {
    std::uint32_t track;
    std::uint64_t step;
  };
  struct Page {
    std::deque<Ask> asks;
    FrameOptions options;
    std::uint32_t held_track = 0;
    JointId held{};
  };

  void post(std::function<void()> job);
  void work();
  template <class Work>
  void guard(PageId page, const Work& work);
  void answer(PageId page, const Json& message);
  void answer_all(const Json& message);
  void take_ask(PageId page, const Json& message);
  void take_frames(Page& page, const Json& message);
  void take_touch(PageId page, const Json& message);
  std::uint32_t make_branch(std::uint32_t track, std::uint64_t step);
  void drop_last_track();
  void share_memory();
  void stop_if_ending() const;
  std::uint32_t owner(std::uint32_t track, std::uint64_t step) const;
  std::optional<Divergence> find_parting(std::uint32_t a, std::uint32_t b);
  void tell_parting(PageId page, std::uint32_t a, std::uint32_t b);
  void let_go(Page& page);

  bool serve();
  bool serve(PageId id, Page& page);
  bool run_on();
  bool look_ahead();
  Bytes make_frame(std::uint32_t track, const FrameOptions& options);
  void go_to(Track& track, std::uint64_t step);
  void end_with(std::uint32_t track, const std::string& error);

  void tell_past();
  Json past_of(std::uint32_t track, std::size_t row, std::size_t event) const;
  Json tracks() const;
  Track& track_at(std::uint64_t number);
  std::string new_file();
  std::string title() const;

  Send send_;
  std::string folder_;  // of the recordings of live tracks
  std::string session_;
  Workers workers_;
  std::vector<std::unique_ptr<Track>> tracks_;
  std::size_t openings_ = 0;
  Vec3 up_{0.0f, 1.0f, 0.0f};  // of the first track, as it was opened
  Cast cast_;
  std::map<PageId, Page> pages_;
  std::map<std::uint32_t, std::uint64_t> run_to_;  // by track
  struct Told {
    std::size_t rows = 0, events = 0;
  };
  std::vector<Told> told_;  // by track
  std::uint64_t files_ = 0;
  PageId turn_ = 0;     // the page that is served
  int turn_steps_ = 0;  // played for it so far

  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::function<void()>> jobs_;
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;
};

}  // namespace scree::view
