// A show as messages of Foxglove's schemas (https://docs.foxglove.dev/docs/sdk/schemas) in an MCAP file.
#pragma once

#include <tools/export/show.h>

#include <string>

namespace scree::exports {

// Topics: /scene, the bodies' shapes, each time that bodies appear or go; /tf, where all bodies are at each
// sample; /stats, figures of the steps. The frame `map` has z up, as robotics wants it; `world` is the
// recorded world's.
std::string to_mcap(const Show& show);

}  // namespace scree::exports
