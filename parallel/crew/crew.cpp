// Crew: asks for helpers at the first stage that is worth sharing, and lets them go at the end of the step.
#include <parallel/crew/crew.h>
#include <parallel/crew/crew_state.h>
#include <parallel/crew/workers_impl.h>
#include <parallel/crew/zone_scope.h>

namespace scree {

Crew::Crew(Workers& workers)
    : kernels_(workers.impl_->kernels),
      zones_(workers.impl_->zones.begin != nullptr ? &workers.impl_->zones : nullptr),
      workers_(workers.impl_.get()) {}

Crew::~Crew() {
  if (state_ != nullptr) state_->close();
}

namespace {

// A stage whose zones are reported.
struct Watched {
  const ZoneHooks* zones;
  const char* name;
  StageFunction function;
  void* context;
};

void run_watched(void* context, int chunk, int worker) {
  const Watched& watched = *static_cast<const Watched*>(context);
  const ZoneScope zone(watched.zones, {ZoneKind::chunk, watched.name, chunk});
  watched.function(watched.context, chunk, worker);
}

}  // namespace

void Crew::run_stage(int chunks, StageFunction function, void* context, const char* name) {
  if (chunks <= 0) return;
  ++stages_;
  if (zones_ == nullptr) return share(chunks, function, context);
  Watched watched{zones_, name, function, context};
  const ZoneScope zone(zones_, {ZoneKind::stage, name, chunks});
  share(chunks, run_watched, &watched);
}

void Crew::share(int chunks, StageFunction function, void* context) {
  if (chunks == 1 || threads() == 1) {
    for (int chunk = 0; chunk < chunks; ++chunk) function(context, chunk, 0);
    return;
  }
  if (state_ == nullptr) {
    state_ = &workers_->pool->acquire();
    state_->set_width(width_);
    state_->publish(chunks, function, context);
    state_->open();
    workers_->send_helpers(width_ - 1);
  } else {
    state_->publish(chunks, function, context);
  }
  state_->finish(chunks);
}

int Crew::threads() {
  if (width_ == 0) width_ = workers_->available_threads();
  return width_;
}

}  // namespace scree
