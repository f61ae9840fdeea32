// Recorder: takes the calls and steps of a world and passes them to the writer.
#include <core/world/edit.h>
#include <parallel/recording/recorder_impl.h>
#include <scree/recording.h>

#include <exception>
#include <new>
#include <utility>

namespace scree {

namespace {

constexpr int kMostSpacing = 1'000'000'000;                     // steps
constexpr float kLeastInterval = 0.01f, kMostInterval = 60.0f;  // s
constexpr int kMostLevel = 19;                                  // beyond that zstd takes far more memory

void check_options(const RecorderOptions& options) {
  const auto require = [](bool holds, const std::string& problem) {
    if (!holds) throw Error("Recorder: RecorderOptions::" + problem);
  };
  require(
      options.keyframe_spacing >= 1 && options.keyframe_spacing <= kMostSpacing,
      "keyframe_spacing is " + std::to_string(options.keyframe_spacing) + "; it must lie in [1, 1000000000]");
  require(options.compression_level >= 1 && options.compression_level <= kMostLevel,
          "compression_level is " + std::to_string(options.compression_level) + "; it must lie in [1, 19]");
  require(options.flush_interval >= kLeastInterval && options.flush_interval <= kMostInterval,
          "flush_interval is " + std::to_string(options.flush_interval) + " s; it must lie in [0.01, 60]");
}

}  // namespace

// Does the work, or ends the recording if that fails.
template <class Work>
void Recorder::Impl::keep(Work&& work) noexcept {
  if (!writer.has_failed()) {
    try {
      work();
      return;
    } catch (const std::bad_alloc&) {
      writer.fail("memory ran out", ErrorCode::out_of_memory);
    } catch (const Error& error) {
      writer.fail(error.what(), error.code());
    } catch (const std::exception& error) {
      writer.fail(error.what(), ErrorCode::io_failure);
    }
  }
  end(false);
}

Recorder::Impl::Impl(WorldData& world, const std::string& file, const RecorderOptions& options)
    : spacing(static_cast<std::uint64_t>(options.keyframe_spacing)),
      first_step(world.step_count),
      writer(file, options) {
  if (world.border == nullptr) {
    place_matter(world);  // of later keyframes the step has done so
    add_state(world, ChunkKind::keyframe);
    writer.wait_until_written();
    if (writer.has_failed()) writer.throw_error("Recorder: ");
  } else if (!writer.is_regular_file()) {
    throw Error("Recorder: " + file + ": many ranks can write to a regular file only", ErrorCode::io_failure);
  }
  data = &world;
  data->recording.sink = this;
}

Recorder::Impl::~Impl() {
  // The recording program did not come to the end.
  if (std::uncaught_exceptions() > exceptions)
    writer.fail("an exception has ended it", ErrorCode::io_failure);
  end(true);
}

void Recorder::Impl::called(const MadeCall& call) noexcept {
  keep([&] {
    writer.add(position(), [&](RecordingBatch& batch) {
      CallWriter out(batch.bytes, solids);
      write_call(call, out);
      append_new_solids(batch.solids);
      ++batch.calls;
    });
    calls_follow = true;
  });
}

void Recorder::Impl::restored(const WorldData& world) noexcept {
  keep([&] {
    add_state(world, ChunkKind::restored);
    calls_follow = true;
  });
}

void Recorder::Impl::stepped(const WorldData& world, float dt, std::uint64_t hash) noexcept {
  keep([&] {
    writer.add(position(), [&](RecordingBatch& batch) {
      batch.bytes.put(static_cast<std::uint8_t>(RecordedCall::step));
      batch.bytes.put(dt);
      batch.bytes.put(hash);
      ++batch.steps;
    });
    ++steps;
    calls_follow = false;
    const bool is_whole = world.border == nullptr;
    if (is_whole && steps - last_keyframe >= spacing) add_state(world, ChunkKind::keyframe);
  });
}

void Recorder::Impl::world_ended() noexcept {
  data = nullptr;
  writer.stop();
}

void Recorder::Impl::step_failed() noexcept {
  data = nullptr;
  writer.fail("memory ran out", ErrorCode::out_of_memory);
  writer.stop();
}

void Recorder::Impl::end(bool with_keyframe) noexcept {
  const bool is_whole = data != nullptr && data->border == nullptr;
  if (is_whole && with_keyframe && can_add_keyframe()) {
    keep([this] { add_state(*data, ChunkKind::keyframe); });
  }
  if (data != nullptr) std::exchange(data, nullptr)->recording.sink = nullptr;
  writer.stop();
}

void Recorder::Impl::append_new_solids(SolidVectors& to) {
  const SolidViews all = solids.solids();
  for (; hulls_told < all.hulls.size(); ++hulls_told) to.hulls.push_back(all.hulls[hulls_told]);
  for (; meshes_told < all.meshes.size(); ++meshes_told) to.meshes.push_back(all.meshes[meshes_told]);
}

void Recorder::Impl::add_state(const WorldData& world, ChunkKind kind) {
  std::unique_ptr<StateToRecord> state = writer.take_spare_state();
  if (state == nullptr) state = std::make_unique<StateToRecord>();
  save_world(world, state->snapshot, false);
  state->kind = kind;
  state->solids = solids.numbers_of(state->snapshot.hulls, state->snapshot.meshes);
  SolidVectors new_solids;
  append_new_solids(new_solids);
  writer.add_state(position(), std::move(state), std::move(new_solids));
  if (kind == ChunkKind::keyframe) note_keyframe();
}

Recorder::Recorder(World& world, const std::string& file, const RecorderOptions& options) {
  check_whole(internals(world, "Recorder"), "Recorder");
  begin(world, file, options);
}

Recorder SharedRecorder::record_part(World& world, const std::string& file, const RecorderOptions& options) {
  Recorder recorder;
  recorder.begin(world, file, options);
  return recorder;
}

void Recorder::begin(World& world, const std::string& file, const RecorderOptions& options) {
  check_options(options);
  check_byte_order("Recorder");
  WorldData& data = internals(world, "Recorder");
  if (data.recording.sink != nullptr) {
    throw Error("Recorder: the world is being recorded already", ErrorCode::already_recording);
  }
  impl_ = std::make_unique<Impl>(data, file, options);
}

Recorder::Recorder() noexcept = default;
Recorder::~Recorder() = default;
Recorder::Recorder(Recorder&&) noexcept = default;
Recorder& Recorder::operator=(Recorder&&) noexcept = default;

void Recorder::finish() {
  if (impl_ == nullptr || std::exchange(impl_->finished, true)) return;
  impl_->end(true);
  if (impl_->writer.has_failed()) impl_->writer.throw_error("Recorder: ");
}

bool Recorder::is_recording() const noexcept {
  return impl_ != nullptr && impl_->data != nullptr && !impl_->writer.has_failed();
}

std::string Recorder::error() const { return impl_ != nullptr ? impl_->writer.error() : std::string(); }

std::uint64_t Recorder::steps() const noexcept { return impl_ != nullptr ? impl_->steps : 0; }

std::uint64_t Recorder::bytes_written() const noexcept {
  return impl_ != nullptr ? impl_->writer.bytes_written() : 0;
}

}  // namespace scree
