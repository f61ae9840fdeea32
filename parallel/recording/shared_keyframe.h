// Keyframes of a world that many ranks have. Each rank writes its part of one, see
// ../distributed/world_parts.h; rank 0's recorder writes all else of the file.
#pragma once

#include <parallel/crew/crew.h>
#include <parallel/recording/recorder_impl.h>
#include <scree/error.h>
#include <scree/world.h>

#include <optional>
#include <string>

namespace scree {

// Writes a keyframe where the recorder wants one. All ranks call it together, `recorder` is null on others
// than rank 0. Where something fails, the recording ends, and all ranks get an Error.
std::optional<Error> write_shared_keyframe(World& world, SharedRecorder::Impl* recorder,
                                           const std::string& file, int compression_level, Crew& crew);

}  // namespace scree
