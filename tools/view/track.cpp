// See track.h.
#include <tools/files/recordings.h>
#include <tools/view/track.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <thread>
#include <utility>

namespace scree::view {
namespace {

constexpr float kFlushInterval = 0.02f;  // s
constexpr int kKeyframeSpacing = 60;     // steps: looking back plays that many at most
constexpr float kUsualDt = 1.0f / 60.0f;
constexpr PlayerMeasures kMeasures{
    .contact_forces = true, .residual = true, .contact_events = ContactEvents::hit};

// What a live world measures from its beginning. It changes no pose and no velocity.
void measure(World& world) {
  WorldSettings settings = world.settings();
  settings.contact_forces = settings.measure_residual = true;
  settings.contact_events = settings.contact_events | ContactEvents::hit;
  world.set_settings(settings);
}

Player measuring_player(const std::string& file) {
  Player player = files::open_recording(file);
  player.measure(kMeasures);
  return player;
}

void note_events(const World& world, std::uint64_t step, std::vector<PastEvent>& events) {
  const auto note = [&](EventKind kind, std::size_t count, std::uint32_t index, float value = 0.0f) {
    events.push_back({step, kind, index, static_cast<std::uint32_t>(count), value});
  };
  if (const auto bodies = world.sleep_begins(); !bodies.empty())
    note(EventKind::sleep, bodies.size(), bodies.front().index);
  if (const auto bodies = world.sleep_ends(); !bodies.empty())
    note(EventKind::wake, bodies.size(), bodies.front().index);
  if (const auto joints = world.broken_joints(); !joints.empty())
    note(EventKind::break_joint, joints.size(), joints.front().index);
  if (const auto bodies = world.restored_bodies(); !bodies.empty())
    note(EventKind::restore, bodies.size(), bodies.front().index);
  const auto hits = world.contact_hits();
  if (hits.empty()) return;
  const auto fastest = std::max_element(
      hits.begin(), hits.end(),
      [](const ContactEvent& a, const ContactEvent& b) { return a.approach_speed < b.approach_speed; });
  note(EventKind::hit, hits.size(), fastest->body_a.index, fastest->approach_speed);
}

}  // namespace

Bytes FrameCache::find(std::uint64_t step, const FrameOptions& options) const {
  const auto entry = frames_.find(step);
  if (entry == frames_.end()) return nullptr;
  const FrameOptions& has = entry->second.options;
  const bool fits =
      (has.shade == options.shade || options.shade == Shade::none) && (has.details || !options.details);
  return fits ? entry->second.bytes : nullptr;
}

void FrameCache::erase(Frames::iterator entry) {
  if (entry == frames_.end()) return;
  bytes_ -= entry->second.bytes->size();
  frames_.erase(entry);
}

void FrameCache::keep(std::uint64_t step, const FrameOptions& options, Bytes frame, std::uint64_t near) {
  erase(frames_.find(step));
  bytes_ += frame->size();
  frames_[step] = {options, std::move(frame)};
  const auto distance = [&](std::uint64_t from) { return from < near ? near - from : from - near; };
  while (bytes_ > most_bytes_ && frames_.size() > 1) {
    const auto last = std::prev(frames_.end());
    erase(distance(frames_.begin()->first) > distance(last->first) ? frames_.begin() : last);
  }
}

Track::Track(std::string called, const std::string& file) : name(std::move(called)), file_(file) {
  player_.emplace(measuring_player(file));
  scout_.emplace(measuring_player(file));
  first_ = player_->info().first_step;
  last_ = planned_ = player_->info().last_step;
  show(player_->world(), first_, std::nullopt);
  note(player_->world(), 0.0, false);
}

Track::Track(std::string called, const scenes::Scene& scene, const std::string& file)
    : name(std::move(called)), dt_(scene.dt) {
  stage_ = std::make_unique<scenes::Stage>(std::vector<scenes::Scene>{scene});
  planned_ = static_cast<std::uint64_t>(scene.steps);
  begin_live(stage_->worlds().front(), file);
}

Track::Track(std::string called, World world, float dt, const std::string& file)
    : name(std::move(called)), dt_(dt > 0.0f ? dt : kUsualDt) {
  world_ = std::make_unique<World>(std::move(world));
  begin_live(*world_, file);
  planned_ = first_;
}

void Track::begin_live(World& world, const std::string& file) {
  measure(world);
  live_ = &world;
  file_ = file;
  recorder_.emplace(world, file,
                    RecorderOptions{.keyframe_spacing = kKeyframeSpacing, .flush_interval = kFlushInterval});
  first_ = last_ = world.stats().step;
  show(world, first_, std::nullopt);
  note(world, 0.0, false);
}

void Track::show(const World& world, std::uint64_t step, std::optional<float> dt) {
  shown_ = &world;
  shown_step_ = step;
  shown_dt_ = dt.value_or(0.0f);
  is_whole_ = dt.has_value() || step == first_;
}

void Track::note(const World& world, double time, bool was_played) {
  const StepStats& stats = world.stats();
  PastStep past;
  past.figures = {time, static_cast<double>(world.body_count())};
  if (was_played) {
    const double figures[] = {static_cast<double>(stats.awake_bodies),
                              static_cast<double>(stats.contacts),
                              stats.kinetic_energy,
                              stats.residual,
                              stats.step_ms,
                              1.0};
    std::copy(std::begin(figures), std::end(figures), past.figures.begin() + 2);
    std::copy(std::begin(stats.phase_ms), std::end(stats.phase_ms),
              past.figures.begin() + PastStep::kFigures);
    note_events(world, first_ + past_.size(), events_);
  }
  past_.push_back(past);
}

void Track::advance(Workers& workers) {
  if (!error.empty()) throw Error(error);
  if (std::exchange(was_touched, false)) frames.forget(last_);
  if (stage_) {
    stage_->advance(dt_, workers);
  } else {
    step(*live_, dt_, workers);
  }
  ++last_;
  note(*live_, past_.back().figures[0] + double{dt_}, true);
  if (const std::string problem = recorder_->error(); !problem.empty())  // one could not look back any more
    throw Error(name + ": it ends at step " + std::to_string(last_) +
                ", because it cannot be recorded: " + problem);
}

std::vector<std::uint64_t> Track::keyframes() const {
  if (!is_live()) return {player_->keyframe_steps().begin(), player_->keyframe_steps().end()};
  std::vector<std::uint64_t> steps;
  for (std::uint64_t step = first_; step <= last_; step += kKeyframeSpacing) steps.push_back(step);
  return steps;
}

bool Track::approach(std::uint64_t step, Workers& workers) {
  if (!is_live() || step < last_) return approach_past(std::min(step, last_), workers);
  if (step > last_) advance(workers);
  show(*live_, last_, past_.back().figures.at(7) > 0.0 ? std::optional(dt_) : std::nullopt);
  return last_ >= step;
}

bool Track::approach_past(std::uint64_t step, Workers& workers) {
  return files::naming(file_, [&] { return play_towards(step, workers); });
}

bool Track::play_towards(std::uint64_t step, Workers& workers) {
  if (!player_ || step > player_->info().last_step) {
    player_.emplace(open(step));
    show(player_->world(), player_->position(), std::nullopt);  // what was shown has gone
  }
  const std::uint64_t here = player_->position();
  const bool is_from_seek = here != first_ && !player_->recorded_dt();
  if (here != step || is_from_seek) {
    // A step is played to each state, so that it has its contacts, unless it is the first one.
    const std::span<const std::uint64_t> keyframes = player_->keyframe_steps();
    const auto after = std::lower_bound(keyframes.begin(), keyframes.end(), step);
    const std::uint64_t keyframe = after == keyframes.begin() ? keyframes.front() : after[-1];
    if (step < here || keyframe > here || (here == step && is_from_seek)) {
      player_->seek(keyframe, workers);
    } else {
      player_->step(workers);
    }
  }
  const std::optional<float> dt = player_->recorded_dt();
  if (dt_ == 0.0f && dt) dt_ = *dt;
  show(player_->world(), player_->position(), dt);
  return player_->position() == step && is_whole_;
}

bool Track::look_ahead(Workers& workers) {
  if (!scout_) return false;
  if (!scout_->step(workers)) {
    scout_.reset();
    show(player_->world(), player_->position(), player_->recorded_dt());
    return false;
  }
  const float dt = *scout_->recorded_dt();
  if (dt_ == 0.0f) dt_ = dt;
  note(scout_->world(), past_.back().figures[0] + double{dt}, true);
  show(scout_->world(), scout_->position(), dt);
  files::check_repeats(*scout_, file_);
  return true;
}

World Track::branch() const { return clone(*shown_); }

Player Track::open(std::uint64_t step) const {
  constexpr int kTries = 250;  // 5 s: a disk may be slow
  for (int i = 0; i < kTries; ++i) {
    Player player = measuring_player(file_);
    if (player.info().last_step >= step) return player;
    if (recorder_ && !recorder_->error().empty()) throw Error(name + ": " + recorder_->error());
    std::this_thread::sleep_for(std::chrono::duration<float>(kFlushInterval));
  }
  throw Error(file_ + ": what was recorded last is not in the file yet");
}

}  // namespace scree::view
