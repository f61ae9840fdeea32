// Scene files: scenes as JSON documents. tools/scenes/README.md states the schema.
#pragma once

#include <tools/scenes/scene.h>

#include <cstdint>
#include <optional>
#include <string>

namespace scree::scenes {

/// Limits for bodies and for joints of a scene file, repeats counted one by one: they take 2 and 4 GB, even
/// if the file is short.
inline constexpr std::int64_t kMostBodies = 10'000'000;

/// Reads a scene file. Throws scree::Error with the file, the place in the document (a JSON pointer; line and
/// column where the text is not JSON) and the reason.
Scene read_scene_file(const std::string& path);

/// Reads a scene from a text; `file` is the name that errors and a scene without a name carry. Files of
/// meshes are relative to `folder`; without one the text must not name any.
Scene parse_scene(const std::string& text, const std::string& file, std::int64_t most_bodies = kMostBodies,
                  const std::optional<std::string>& folder = std::nullopt);

}  // namespace scree::scenes
