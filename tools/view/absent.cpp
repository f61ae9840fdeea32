// Takes the place of resources.cpp in a build without a page.
#include <tools/view/resources.h>

namespace scree::view {

std::string_view page_text() { return {}; }
std::string_view style_text() { return {}; }
std::span<const Resource> modules() { return {}; }

}  // namespace scree::view
