// See engine.h.
#include <tools/export/show.h>
#include <tools/files/recordings.h>
#include <tools/view/engine.h>
#include <tools/view/page.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <random>
#include <sstream>
#include <utility>

namespace scree::view {
namespace {

constexpr std::size_t kMostAsks = 256;     // of a page at once
constexpr std::size_t kMostTracks = 200;   // a live one is a world with a recorder
constexpr std::size_t kPastAtOnce = 2000;  // steps

std::string temporary_folder() {
  std::error_code problem;
  const std::filesystem::path parent = std::filesystem::temp_directory_path(problem);
  std::string folder = (parent / "scree-view-XXXXXX").string();
  if (problem || mkdtemp(folder.data()) == nullptr)
    throw Error(folder + ": cannot make a folder for recordings there; TMPDIR names another place");
  return folder;
}

std::string new_session() {
  std::random_device random;
  std::ostringstream text;
  text << std::hex << random() << random();
  return text.str();
}

// Whether the recorded hashes of a step differ.
bool moves_otherwise(Player& a, Player& b, std::uint64_t step, Workers& workers) {
  std::optional<std::uint64_t> hashes[2];
  for (const auto& [player, hash] : {std::pair(&a, &hashes[0]), std::pair(&b, &hashes[1])}) {
    if (step <= player->info().first_step) return true;
    player->seek(step - 1, workers);
    player->step(workers);
    *hash = player->recorded_hash();
  }
  return hashes[0] != hashes[1];
}

}  // namespace

Engine::Engine(const EngineOptions& options, Send send)
    : send_(std::move(send)),
      folder_(temporary_folder()),
      session_(new_session()),
      workers_({.threads = options.threads, .isa = options.isa}),
      openings_(options.openings.size()) {
  try {
    for (const Opening& opening : options.openings) {
      tracks_.push_back(opening.scene ? std::make_unique<Track>(opening.name, *opening.scene, new_file())
                                      : std::make_unique<Track>(opening.name, opening.file));
      told_.emplace_back();
      make_frame(static_cast<std::uint32_t>(tracks_.size() - 1), {});
    }
    share_memory();
    if (const Vec3 down = normalize(tracks_[0]->shown().settings().gravity); down != Vec3{}) up_ = -down;
    thread_ = std::thread([this] { work(); });
  } catch (...) {
    tracks_.clear();
    std::filesystem::remove_all(folder_);
    throw;
  }
}

Engine::~Engine() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
  tracks_.clear();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void Engine::post(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
}

void Engine::work() {
  bool is_idle = false;
  auto told = std::chrono::steady_clock::now();
  for (;;) {
    std::vector<std::function<void()>> jobs;
    {
      std::unique_lock lock(mutex_);
      if (is_idle) wake_.wait(lock, [this] { return is_ending_ || !jobs_.empty(); });
      if (is_ending_) return;
      jobs.swap(jobs_);
    }
    for (const auto& job : jobs) {
      try {
        job();
      } catch (const std::exception&) {  // of memory: jobs tell of all else themselves
      }
    }
    is_idle = !serve() && !run_on() && !look_ahead();
    const auto now = std::chrono::steady_clock::now();
    if (is_idle || now - told > std::chrono::milliseconds(50)) {
      tell_past();
      told = now;
    }
  }
}

// A page is told in words what went wrong; the others go on.
template <class Work>
void Engine::guard(PageId page, const Work& work) {
  std::string text;
  try {
    work();
    return;
  } catch (const std::bad_alloc&) {
    text = "out of memory";
  } catch (const Json::exception& error) {
    text = std::string("the page has asked for something that cannot be read: ") + error.what();
  } catch (const std::exception& error) {
    text = error.what();
  }
  answer(page, {{"kind", "error"}, {"text", text}});
}

void Engine::answer_all(const Json& message) {
  for (const auto& [page, state] : pages_) answer(page, message);
}

void Engine::answer(PageId page, const Json& message) {
  send_(page,
        std::make_shared<const std::string>(message.dump(-1, ' ', false, Json::error_handler_t::replace)),
        true);
}

Track& Engine::track_at(std::uint64_t number) {
  if (number >= tracks_.size()) throw Error("there is no track " + std::to_string(number));
  return *tracks_[number];
}

std::string Engine::new_file() { return folder_ + "/" + std::to_string(files_++) + ".scree"; }

std::string Engine::title() const {
  return openings_ > 1 ? tracks_[0]->name + " and " + tracks_[1]->name : tracks_[0]->name;
}

void Engine::join(PageId page) {
  post([this, page] {
    tell_past();  // to the others: it gets all of it below
    pages_[page];
    Json phases = Json::array();
    for (int i = 0; i < kPhaseCount; ++i) phases.push_back(phase_name(static_cast<Phase>(i)));
    Json solvers = Json::array(), joints = Json::array();
#define SCREE_NAME_JOINT(kind, Struct) joints.push_back(#kind);
    SCREE_FOR_EACH_JOINT_TYPE(SCREE_NAME_JOINT)
#undef SCREE_NAME_JOINT
    for (int i = 0; i < kSolverCount; ++i) solvers.push_back(solver_name(static_cast<Solver>(i)));
    answer(page, {{"kind", "hello"},
                  {"session", session_},
                  {"title", title()},
                  {"up", json_of(up_)},
                  {"size", cast_.size() > 0.0f ? cast_.size() : 1.0f},
                  {"phases", phases},
                  {"solvers", solvers},
                  {"joints", joints},
                  {"compares", openings_ > 1},
                  {"tracks", tracks()}});
    for (const Bytes& news : cast_.all_news()) send_(page, news, false);
    for (std::uint32_t track = 0; track < tracks_.size(); ++track) {
      for (std::size_t row = 0; row < told_[track].rows; row += kPastAtOnce)
        answer(page, past_of(track, row, 0));
    }
  });
}

void Engine::leave(PageId page) {
  post([this, page] {
    const auto known = pages_.find(page);
    if (known == pages_.end()) return;
    guard(page, [&] { let_go(known->second); });
    pages_.erase(known);
  });
}

void Engine::let_go(Page& page) {
  if (page.held == JointId{}) return;
  Track& track = track_at(page.held_track);
  touch(track.end(), {{"kind", "release"}}, page.held);
}

void Engine::ask(PageId page, std::string text) {
  post([this, page, text = std::move(text)] {
    if (!pages_.contains(page)) return;
    guard(page, [&] { take_ask(page, Json::parse(text)); });
  });
}

void Engine::take_ask(PageId page, const Json& message) {
  const auto ask = message.at("ask").get<std::string>();
  if (ask == "frames") return take_frames(pages_[page], message);
  if (ask == "touch") return take_touch(page, message);
  if (ask == "parted")
    return tell_parting(page, message.at("a").get<std::uint32_t>(), message.at("b").get<std::uint32_t>());
  const auto number = message.at("track").get<std::uint32_t>();
  Track& track = track_at(number);
  if (ask == "branch") {
    make_branch(number, message.at("step").get<std::uint64_t>());
    answer(page, {{"kind", "branched"}, {"track", tracks_.size() - 1}});
  } else if (ask == "name") {
    track.name = message.at("name").get<std::string>().substr(0, 80);
    answer_all(tracks());
  } else if (ask == "run") {
    if (!track.is_live()) throw Error(track.name + " is a recording, which ends where it ends");
    if (!track.error.empty()) throw Error(track.error);
    run_to_[number] = message.at("to").get<std::uint64_t>();
  } else {
    throw Error("a page asks for " + ask + ", which is not known");
  }
}

void Engine::take_frames(Page& page, const Json& message) {
  const int shade = message.value("shade", 0);
  if (shade < 0 || shade > static_cast<int>(Shade::force))
    throw Error("there is no color " + std::to_string(shade));
  page.options = {static_cast<Shade>(shade), message.value("details", false)};
  page.asks.clear();
  for (const Json& frame : message.at("frames")) {
    if (page.asks.size() >= kMostAsks) break;
    const auto track = frame.at(0).get<std::uint32_t>();
    track_at(track);
    page.asks.push_back({track, frame.at(1).get<std::uint64_t>()});
  }
}

// Brings a track to a step whatever time it takes.
void Engine::go_to(Track& track, std::uint64_t step) {
  if (step < track.first() || step > track.last()) {
    throw Error(track.name + ": step " + std::to_string(step) + " is not among " +
                std::to_string(track.first()) + " to " + std::to_string(track.last()));
  }
  while (!track.approach(step, workers_)) stop_if_ending();
}

void Engine::stop_if_ending() const {
  if (is_ending_) throw std::runtime_error("the server ends");
}

// Each track may keep as much as the others.
void Engine::share_memory() {
  for (const auto& track : tracks_) track->frames.set_limit(FrameCache::kMostBytes / tracks_.size());
}

void Engine::drop_last_track() {
  tracks_.pop_back();
  told_.pop_back();
  answer_all(tracks());
}

std::uint32_t Engine::make_branch(std::uint32_t number, std::uint64_t step) {
  if (tracks_.size() >= kMostTracks)
    throw Error("there are " + std::to_string(kMostTracks) + " tracks, as many as can be");
  Track& parent = track_at(number);
  go_to(parent, step);
  World world = parent.branch();
  if (world.stats().step != step) {
    throw Error(parent.name + ": a snapshot was restored before step " + std::to_string(step) +
                ", so the world counts that step as " + std::to_string(world.stats().step) +
                ": no branch can begin there");
  }
  release_all(world);
  const std::string name = "branch " + std::to_string(tracks_.size() + 1 - openings_);
  const float dt = parent.shown_dt() > 0.0f ? parent.shown_dt() : parent.dt();
  auto branch = std::make_unique<Track>(name, std::move(world), dt, new_file());
  branch->parent = number;
  tracks_.push_back(std::move(branch));
  told_.emplace_back();
  share_memory();
  make_frame(static_cast<std::uint32_t>(tracks_.size() - 1), {});
  answer_all(tracks());
  return static_cast<std::uint32_t>(tracks_.size() - 1);
}

void Engine::take_touch(PageId id, const Json& message) {
  Page& page = pages_[id];
  auto number = message.at("track").get<std::uint32_t>();
  const auto step = message.at("step").get<std::uint64_t>();
  const Json& what = message.at("what");
  const auto kind = what.at("kind").get<std::string>();
  const bool goes_on = kind == "move" || kind == "release";
  if (goes_on) {
    if (page.held == JointId{}) return;
    return touch(track_at(page.held_track).end(), what, page.held);
  }
  // What touches the end of a live track changes it. Pages are a few steps behind the end while it runs.
  const std::uint64_t most_behind = message.value("running", false) ? 32 : 0;
  const bool is_end = track_at(number).is_live() && step + most_behind >= track_at(number).last();
  const bool makes_branch = !is_end || kind == "nudge";
  if (kind == "drag") let_go(page);
  if (makes_branch) number = make_branch(number, is_end ? track_at(number).last() : step);
  Track& track = *tracks_[number];
  if (!track.error.empty()) throw Error(track.error);
  if (kind == "drag") page.held_track = number;
  try {
    touch(track.end(), what, page.held);
  } catch (...) {
    if (makes_branch) drop_last_track();
    throw;
  }
  track.frames.forget(track.last());
  track.was_touched = true;
  if (makes_branch) answer(id, {{"kind", "branched"}, {"track", number}});
  if (kind == "settings") answer_all(tracks());
  answer_all({{"kind", "changed"}, {"track", number}, {"step", track.last()}});
}

// The number that follows "body " in the words of a divergence.
Json body_in(const std::string& text) {
  const std::size_t at = text.find("body ");
  return at == std::string::npos ? Json() : Json(std::strtoul(text.c_str() + at + 5, nullptr, 10));
}

// The track itself or what it branched off: the one that has the step.
std::uint32_t Engine::owner(std::uint32_t track, std::uint64_t step) const {
  while (tracks_[track]->parent != Track::kNoParent && step <= tracks_[track]->first())
    track = tracks_[track]->parent;
  return track;
}

// Where both have the same owner they are the same. The steps that two owners share are compared by their
// recordings; with branches of branches there may be several such runs of steps.
std::optional<Divergence> Engine::find_parting(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t last = std::min(track_at(a).last(), track_at(b).last());
  const auto root = [&](std::uint32_t track) { return owner(track, 0); };
  const std::uint64_t first = std::max(tracks_[root(a)]->first(), tracks_[root(b)]->first()) + 1;
  for (std::uint64_t step = first; step <= last;) {
    const std::uint32_t owner_a = owner(a, step), owner_b = owner(b, step);
    std::uint64_t end = step;
    while (end < last && owner(a, end + 1) == owner_a && owner(b, end + 1) == owner_b) ++end;
    if (owner_a != owner_b) {
      Player one = tracks_[owner_a]->open(), other = tracks_[owner_b]->open();
      const std::optional<Divergence> parting = compare(one, other, workers_);
      const bool is_in_run = parting && parting->step <= end && (parting->step >= step || step == first);
      // Live tracks measure contacts, which is a part of the whole state: between one of them and a recording
      // only motion counts.
      const bool is_alike = tracks_[owner_a]->is_live() == tracks_[owner_b]->is_live();
      if (is_in_run && (is_alike || moves_otherwise(one, other, parting->step, workers_))) return parting;
    }
    step = end + 1;
  }
  return std::nullopt;
}

void Engine::tell_parting(PageId page, std::uint32_t a, std::uint32_t b) {
  const std::optional<Divergence> parting = find_parting(a, b);
  Json message = {{"kind", "parted"}, {"a", a}, {"b", b}, {"step", nullptr}};
  if (parting) {
    message["step"] = parting->step;
    message["text"] = parting->difference;
    message["body"] = body_in(parting->difference);
  }
  answer(page, message);
}

void Engine::end_with(std::uint32_t number, const std::string& error) {
  Track& track = *tracks_[number];
  if (track.error.empty()) track.error = error;
  run_to_.erase(number);
  answer_all(tracks());
}

Bytes Engine::make_frame(std::uint32_t number, const FrameOptions& options) {
  Track& track = *tracks_[number];
  auto frame = std::make_shared<const std::string>(view::make_frame(
      track.shown(), number, track.shown_step(), track.shown_dt(), options, cast_, track.memory));
  for (const Bytes& news : cast_.take_news()) {
    for (const auto& [page, state] : pages_) send_(page, news, false);
  }
  return frame;
}

bool Engine::serve() {
  if (pages_.empty()) return false;
  // Two pages that look at different steps of a track must not take it from each other: a page keeps its turn
  // until it has a frame, or for as many steps as lie between keyframes mostly.
  constexpr int kMostSteps = 600;
  auto turn =
      turn_steps_ > 0 && turn_steps_ < kMostSteps ? pages_.lower_bound(turn_) : pages_.upper_bound(turn_);
  for (std::size_t i = 0; i < pages_.size(); ++i, ++turn) {
    if (turn == pages_.end()) turn = pages_.begin();
    if (turn->first != turn_) turn_steps_ = 0;
    turn_ = turn->first;
    if (serve(turn->first, turn->second)) return true;
  }
  turn_steps_ = 0;
  return false;
}

// Does something for a page; false: it has all that it has asked for.
bool Engine::serve(PageId id, Page& page) {
  if (page.asks.empty()) return false;
  const Ask ask = page.asks.front();
  Track& track = *tracks_[ask.track];
  track.near = ask.step;
  Bytes frame = track.frames.find(ask.step, page.options);
  bool is_there = frame != nullptr;
  if (!is_there) {
    const bool is_beyond = ask.step > track.last() && (!track.is_live() || !track.error.empty());
    if (ask.step < track.first() || is_beyond) {
      page.asks.pop_front();
      return true;
    }
    try {
      is_there = track.approach(ask.step, workers_);
      ++turn_steps_;
      if (track.is_whole()) {
        frame = make_frame(ask.track, page.options);
        track.frames.keep(track.shown_step(), page.options, frame, ask.step);
      }
    } catch (const std::exception& error) {
      turn_steps_ = 0;
      page.asks.clear();
      if (ask.step > track.last()) end_with(ask.track, error.what());
      answer(id, {{"kind", "error"}, {"text", error.what()}});
      return true;
    }
  }
  if (!is_there) return true;
  turn_steps_ = 0;
  page.asks.pop_front();
  send_(id, std::move(frame), false);
  return true;
}

bool Engine::run_on() {
  for (const auto& [number, step] : run_to_) {
    Track& track = *tracks_[number];
    if (step <= track.last() || !track.error.empty()) continue;
    try {
      track.approach(track.last() + 1, workers_);
    } catch (const std::exception& error) {
      end_with(number, error.what());
    }
    return true;
  }
  return false;
}

bool Engine::look_ahead() {
  for (std::uint32_t number = 0; number < openings_; ++number) {
    Track& track = *tracks_[number];
    try {
      if (!track.error.empty() || !track.look_ahead(workers_)) continue;
      if (!track.frames.has(track.shown_step()))
        track.frames.keep(track.shown_step(), {}, make_frame(number, {}), track.near);
    } catch (const std::exception& error) {
      end_with(number, error.what());
      answer_all({{"kind", "error"}, {"text", error.what()}});
    }
    return true;
  }
  return false;
}

Json Engine::tracks() const {
  Json list = Json::array();
  for (std::uint32_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = *tracks_[i];
    const WorldSettings& settings = (track.is_live() ? track.end() : track.shown()).settings();
    list.push_back({{"track", i},
                    {"name", track.name},
                    {"parent", track.parent == Track::kNoParent ? Json() : Json(track.parent)},
                    {"first", track.first()},
                    {"last", track.last()},
                    {"planned", track.planned()},
                    {"dt", track.dt()},
                    {"live", track.is_live()},
                    {"keyframes", track.keyframes()},
                    {"settings",
                     {{"gravity", json_of(settings.gravity)},
                      {"substeps", settings.substeps},
                      {"solver", solver_name(settings.solver)}}},
                    {"error", track.error}});
  }
  return {{"kind", "tracks"}, {"tracks", list}};
}

// From a row and an event on, as many as go into a message.
Json Engine::past_of(std::uint32_t number, std::size_t row, std::size_t event) const {
  const Track& track = *tracks_[number];
  const std::size_t end = std::min(row + kPastAtOnce, track.past().size());
  Json rows = Json::array(), events = Json::array();
  for (std::size_t i = row; i < end; ++i) rows.push_back(track.past()[i].figures);
  constexpr const char* kNames[] = {"sleep", "wake", "hit", "break", "restore"};
  for (std::size_t i = event; i < track.events().size(); ++i) {
    const PastEvent& each = track.events()[i];
    if (each.step < track.first() + row || each.step >= track.first() + end) continue;
    events.push_back({each.step, kNames[static_cast<int>(each.kind)], each.index, each.count, each.value});
  }
  return {{"kind", "past"}, {"track", number},  {"from", track.first() + row},   {"dt", track.dt()},
          {"rows", rows},   {"events", events}, {"keyframes", track.keyframes()}};
}

void Engine::tell_past() {
  for (std::uint32_t number = 0; number < tracks_.size(); ++number) {
    Told& told = told_[number];
    const Track& track = *tracks_[number];
    while (told.rows < track.past().size()) {
      answer_all(past_of(number, told.rows, told.events));
      told.rows = std::min(told.rows + kPastAtOnce, track.past().size());
      while (told.events < track.events().size() &&
             track.events()[told.events].step < track.first() + told.rows)
        ++told.events;
    }
  }
}

void Engine::copy_recording(std::uint64_t number, Take take) {
  post([this, number, take = std::move(take)] {
    std::string bytes, problem;
    try {
      const Track& track = track_at(number);
      track.open();  // waits until all is in the file
      bytes.resize(std::filesystem::file_size(track.file()));
      std::ifstream file(track.file(), std::ios::binary);
      file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      if (!file) throw Error(track.file() + ": cannot be read");
    } catch (const std::exception& error) {
      problem = error.what();
    }
    take(std::move(bytes), std::move(problem));
  });
}

void Engine::make_page(std::uint64_t number, std::uint64_t from, std::uint64_t to, std::uint64_t every,
                       Take take) {
  post([this, number, from, to, every, take = std::move(take)] {
    std::string bytes, problem;
    try {
      const Track& track = track_at(number);
      if (every == 0) throw Error("every 0 must be at least 1");
      if (from < track.first() || to > track.last() || from > to) {
        throw Error(track.name + ": steps " + std::to_string(from) + " to " + std::to_string(to) +
                    " are not among " + std::to_string(track.first()) + " to " +
                    std::to_string(track.last()));
      }
      Player player = track.open();
      const exports::Show show = exports::play(player, from, to, every, workers_,
                                               [this](std::uint64_t, std::uint64_t) { stop_if_ending(); });
      bytes = view::make_page(show, track.name);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    take(std::move(bytes), std::move(problem));
  });
}

}  // namespace scree::view
