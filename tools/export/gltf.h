// A show as an animated scene in the glTF format 2.0 of the Khronos Group, for Blender and other viewers.
#pragma once

#include <tools/export/show.h>

#include <string>

namespace scree::exports {

// The text of a .gltf file with its buffer inside, and the bytes of a .glb file. Throws Error where the
// buffer would not fit into the 4 GiB of the format.
std::string to_gltf(const Show& show);
std::string to_glb(const Show& show);

}  // namespace scree::exports
