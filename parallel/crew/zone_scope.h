// Reports a zone to the hooks of a Workers for as long as the scope lives.
#pragma once

#include <scree/zones.h>

namespace scree {

class ZoneScope {
 public:
  // `hooks` may be null.
  ZoneScope(const ZoneHooks* hooks, const Zone& zone) : hooks_(hooks), zone_(zone) {
    if (hooks_ != nullptr) hooks_->begin(hooks_->context, zone_);
  }
  ~ZoneScope() {
    if (hooks_ != nullptr) hooks_->end(hooks_->context, zone_);
  }
  ZoneScope(const ZoneScope&) = delete;
  ZoneScope& operator=(const ZoneScope&) = delete;

 private:
  const ZoneHooks* hooks_;
  Zone zone_;
};

}  // namespace scree
